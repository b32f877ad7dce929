// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/bundle_config.h"

#include "raylign/base/error.h"

namespace raylign {
namespace {

CoordinateNames coordinate_names(ParameterKind kind, const CoordinateNames& intrinsics) {
  switch (kind) {
    case ParameterKind::POSE:
      return {"tx", "ty", "tz", "rotation"};
    case ParameterKind::INTRINSICS:
      return intrinsics;
    case ParameterKind::POINT:
      return {"x", "y", "z"};
  }
  return {};
}

void check_indices(const std::vector<std::int32_t>& indices,
                   const char* field,
                   std::int64_t count) {
  for (const std::int32_t index : indices) {
    if (index < 0 || index >= count) {
      throw OptionsError(std::string("BundleConfig.") + field + " must hold indices in [0, " +
                         std::to_string(count) + "), got " + std::to_string(index));
    }
  }
}

}  // namespace

const CoordinateNames& any_intrinsics() {
  static const CoordinateNames names = {"f", "fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  return names;
}

int coordinate_offset(ParameterKind kind,
                      const std::string& coordinate,
                      const CoordinateNames& intrinsics) {
  const CoordinateNames names = coordinate_names(kind, intrinsics);
  std::string known;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (coordinate == names[i]) return static_cast<int>(i);
    known += std::string(known.empty() ? "" : ", ") + names[i];
  }
  throw OptionsError("ConstantCoordinate.coordinate of kind " + to_string(kind) +
                     " must be one of " + known + ", got '" + coordinate + "'");
}

void BundleConfig::validate(std::int64_t num_cameras,
                            std::int64_t num_points,
                            const CoordinateNames& intrinsics) const {
  check_indices(constant_cameras, "constant_cameras", num_cameras);
  check_indices(constant_intrinsics, "constant_intrinsics", num_cameras);
  check_indices(constant_points, "constant_points", num_points);
  for (const ConstantCoordinate& constant : constant_coordinates) {
    coordinate_offset(constant.kind, constant.coordinate, intrinsics);
    if (constant.index == ConstantCoordinate::kAll) continue;
    check_indices({constant.index}, "constant_coordinates",
                  constant.kind == ParameterKind::POINT ? num_points : num_cameras);
  }
}

std::string to_string(Gauge gauge) {
  switch (gauge) {
    case Gauge::FREE:
      return "free";
    case Gauge::FIRST_CAMERA:
      return "first_camera";
    case Gauge::TWO_CAMERAS:
      return "two_cameras";
  }
  return "unknown";
}

std::string to_string(ParameterKind kind) {
  switch (kind) {
    case ParameterKind::POSE:
      return "pose";
    case ParameterKind::INTRINSICS:
      return "intrinsics";
    case ParameterKind::POINT:
      return "point";
  }
  return "unknown";
}

}  // namespace raylign
