// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Geometry>

#include "raylign/base/eigen.h"

/// Unit quaternions, memory order xyzw (Eigen, TUM); Hamilton product; rotation vector ω in rad.
namespace raylign {

using Quaternion = Eigen::Quaterniond;

/// [sin(θ/2) ω/θ; cos(θ/2)], θ = ‖ω‖; full accuracy for every θ.
Quaternion quaternion_exp(const Vector3& omega);
/// ω with ‖ω‖ <= π; q and −q give the same. The norm of q does not matter as long as it is not
/// zero.
Vector3 quaternion_log(const Quaternion& q);

/// Rotation matrix of q / ‖q‖.
Matrix3 quaternion_to_matrix(const Quaternion& q);
/// Unit quaternion with w >= 0. Shepperd 1978: divides by the largest component, so no angle is
/// special.
Quaternion quaternion_from_matrix(const Matrix3& R);

}  // namespace raylign
