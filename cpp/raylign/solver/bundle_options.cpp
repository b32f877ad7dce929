// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/bundle_options.h"

#include "raylign/base/error.h"

namespace raylign {

void BundleOptions::validate() const {
  loss.validate();
  lm.validate();
  linear_solver.validate();
  if (jacobian_storage == JacobianStorage::FLOAT && backend == Backend::CERES) {
    throw OptionsError("BundleOptions.jacobian_storage FLOAT needs backend NATIVE, got ceres");
  }
}

std::string to_string(Backend backend) {
  switch (backend) {
    case Backend::AUTO:
      return "auto";
    case Backend::CERES:
      return "ceres";
    case Backend::NATIVE:
      return "native";
  }
  return "unknown";
}

std::string to_string(PoseParametrization parametrization) {
  switch (parametrization) {
    case PoseParametrization::SE3:
      return "se3";
    case PoseParametrization::QUATERNION:
      return "quaternion";
    case PoseParametrization::ANGLE_AXIS:
      return "angle_axis";
  }
  return "unknown";
}

std::string to_string(PointParametrization parametrization) {
  switch (parametrization) {
    case PointParametrization::XYZ:
      return "xyz";
    case PointParametrization::HOMOGENEOUS:
      return "homogeneous";
    case PointParametrization::INVERSE_DEPTH:
      return "inverse_depth";
  }
  return "unknown";
}

std::string to_string(JacobianStorage storage) {
  switch (storage) {
    case JacobianStorage::AUTO:
      return "auto";
    case JacobianStorage::DOUBLE:
      return "double";
    case JacobianStorage::FLOAT:
      return "float";
  }
  return "unknown";
}

}  // namespace raylign
