// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/so3.h"

/// How a camera pose is stored in a Ceres parameter block. A pose block knows two things: its R_cw,
/// t_cw, and how Jacobians with respect to (φ, t), where R ← Exp(φ) R at fixed t, become Jacobians
/// with respect to the block's own numbers. Everything else in the cost functions is the same for
/// all of them.
namespace raylign::ceres_backend {

/// d φ / d q (3×4, q = xyzw) at a unit quaternion, φ the left rotation increment: φ = 2 vec(dq ⊗
/// q*). Its null space is q itself: the derivative of a residual that normalises q first.
inline RowMajor<3, 4> rotation_d_quaternion(const double* q) {
  const double x = 2.0 * q[0];
  const double y = 2.0 * q[1];
  const double z = 2.0 * q[2];
  const double w = 2.0 * q[3];
  RowMajor<3, 4> J;
  J << w, -z, y, -x,  //
      z, w, -x, -y,   //
      -y, x, w, -z;
  return J;
}

/// [q (xyzw, unit), t]: serves the SE(3) and the quaternion parametrisation, which differ in their
/// manifold only.
class QuaternionPose {
 public:
  static constexpr int kSize = 7;

  explicit QuaternionPose(const double* block)
      : R_cw(Eigen::Map<const Eigen::Quaterniond>(block).toRotationMatrix()),
        t_cw(block[4], block[5], block[6]),
        block_(block) {}

  void write_jacobian(const RowMajor<2, 3>& J_rotation,
                      const RowMajor<2, 3>& J_t,
                      double* out) const {
    Eigen::Map<RowMajor<2, kSize>> J(out);
    J.leftCols<4>() = J_rotation * rotation_d_quaternion(block_);
    J.rightCols<3>() = J_t;
  }

  static void from_angle_axis(const Vector3& omega, const Vector3& t, double* block) {
    Eigen::Map<Eigen::Quaterniond>{block} = quaternion_exp(omega);
    Eigen::Map<Vector3>{block + 4} = t;
  }
  static Vector3 angle_axis(const double* block) {
    return quaternion_log(Eigen::Map<const Eigen::Quaterniond>(block));
  }
  static const double* translation(const double* block) { return block + 4; }

  const Matrix3 R_cw;
  const Vector3 t_cw;

 private:
  const double* block_;
};

/// [ω (angle-axis), t]: additive, the numbers of the BAL file themselves.
class AngleAxisPose {
 public:
  static constexpr int kSize = 6;

  explicit AngleAxisPose(const double* block)
      : R_cw(so3_exp_and_left_jacobian(Vector3(block[0], block[1], block[2]), J_left_)),
        t_cw(block[3], block[4], block[5]) {}

  void write_jacobian(const RowMajor<2, 3>& J_rotation,
                      const RowMajor<2, 3>& J_t,
                      double* out) const {
    Eigen::Map<RowMajor<2, kSize>> J(out);
    J.leftCols<3>() = J_rotation * J_left_;  // Exp(ω + δ) = Exp(J_l δ) Exp(ω)
    J.rightCols<3>() = J_t;
  }

  static void from_angle_axis(const Vector3& omega, const Vector3& t, double* block) {
    Eigen::Map<Vector3>{block} = omega;
    Eigen::Map<Vector3>{block + 3} = t;
  }
  static Vector3 angle_axis(const double* block) { return Eigen::Map<const Vector3>(block); }
  static const double* translation(const double* block) { return block + 3; }

 private:
  Matrix3 J_left_;  // declared first: R_cw's initialiser fills it

 public:
  const Matrix3 R_cw;
  const Vector3 t_cw;
};

}  // namespace raylign::ceres_backend
