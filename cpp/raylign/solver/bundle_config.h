// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace raylign {

/// What removes the seven similarity freedoms (rotation, translation, scale) of a reconstruction.
enum class Gauge {
  FREE,          ///< nothing held; the damping keeps the step finite
  FIRST_CAMERA,  ///< pose of the first camera that has observations (6 of 7; scale is left to the
                 ///< damping); on top of what else is held
  TWO_CAMERAS,   ///< that pose, and of the camera farthest from it the translation coordinate that
                 ///< a change of scale moves most (all 7)
};

enum class ParameterKind { POSE, INTRINSICS, POINT };

/// Names of the scalars of one block, in its order.
using CoordinateNames = std::vector<std::string>;

/// One scalar held constant. Coordinates: POSE "rotation" (all three), "tx", "ty", "tz" (of t_cw);
/// INTRINSICS the parameters of the camera model, of BAL "f", "k1", "k2"; POINT "x", "y", "z" (xyz
/// parametrisation only).
struct ConstantCoordinate {
  ParameterKind kind = ParameterKind::INTRINSICS;
  std::int32_t index = kAll;  ///< camera or point, or kAll
  std::string coordinate;

  static constexpr std::int32_t kAll = -1;
};

/// Every name that the parameters of some camera model have: all that can be checked before the
/// problem is known.
const CoordinateNames& any_intrinsics();

/// What is held fixed: apart from how to solve (BundleOptions). Indices are those of the problem.
/// A block that is held is returned bit by bit as it came in.
struct BundleConfig {
  Gauge gauge = Gauge::FREE;
  std::vector<std::int32_t> constant_cameras;     ///< poses (rotation and translation)
  std::vector<std::int32_t> constant_intrinsics;  ///< all intrinsics of these cameras
  std::vector<std::int32_t> constant_points;
  std::vector<ConstantCoordinate> constant_coordinates;

  /// Throws OptionsError for an index outside the problem or an unknown coordinate name.
  /// `intrinsics`: the names of the problem's camera model.
  void validate(std::int64_t num_cameras,
                std::int64_t num_points,
                const CoordinateNames& intrinsics = any_intrinsics()) const;
};

/// Offset of a named coordinate in its block: tx ty tz rotation → 0..3, x y z → 0..2, and the place
/// among `intrinsics`. Throws OptionsError for a name that the kind does not have.
int coordinate_offset(ParameterKind kind,
                      const std::string& coordinate,
                      const CoordinateNames& intrinsics = any_intrinsics());

std::string to_string(Gauge gauge);
std::string to_string(ParameterKind kind);

}  // namespace raylign
