// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/sized_cost_function.h>

#include "raylign/ceres_backend/point_blocks.h"
#include "raylign/ceres_backend/pose_blocks.h"
#include "raylign/residuals/reprojection.h"

namespace raylign::ceres_backend {

/// Reprojection residual with hand-written Jacobians. Blocks: pose, intrinsics, point.
template <typename Camera, typename Pose, typename Point>
class ReprojectionCost final
    : public ceres::SizedCostFunction<2, Pose::kSize, Camera::kNumParams, Point::kSize> {
 public:
  explicit ReprojectionCost(const Vector2& observed, const Point& point_model = Point())
      : observed_(observed), point_model_(point_model) {}

  bool Evaluate(double const* const* x, double* residual, double** J) const override {
    const Pose pose(x[0]);
    const typename Camera::Params intrinsics = Eigen::Map<const typename Camera::Params>(x[1]);
    const double w = point_model_.w(x[2]);
    const Vector3 rotated = pose.R_cw * point_model_.x_bar(x[2]);
    const Vector3 p_c = rotated + w * pose.t_cw;
    Vector2 r;
    if (J == nullptr) {
      if (!reprojection_residual<Camera>(p_c, intrinsics, observed_, r)) return false;
    } else {
      RowMajor<2, 3> J_p;
      RowMajor<2, Camera::kNumParams> J_intrinsics;
      if (!reprojection_residual<Camera>(p_c, intrinsics, observed_, r, &J_p, &J_intrinsics))
        return false;
      if (J[0] != nullptr) {
        pose.write_jacobian(pose_jacobian(J_p, rotated).template rightCols<3>(), w * J_p, J[0]);
      }
      if (J[1] != nullptr) {
        Eigen::Map<RowMajor<2, Camera::kNumParams>>{J[1]} = J_intrinsics;
      }
      if (J[2] != nullptr) {
        point_model_.write_jacobian(point_jacobian(J_p, pose.R_cw), J_p * pose.t_cw, J[2]);
      }
    }
    Eigen::Map<Vector2>{residual} = r;
    return true;
  }

 private:
  Vector2 observed_;
  Point point_model_;
};

/// A point m / ρ, m = (α, β, ±1) (where the camera looks), in the frame of its host camera h, seen
/// from camera c. In homogeneous world coordinates x̄ = R_hᵀ (m − ρ t_h), w = ρ. Blocks: pose of c,
/// intrinsics of c, (α, β, ρ), pose of h.
template <typename Camera, typename Pose>
class InverseDepthCost final
    : public ceres::SizedCostFunction<2, Pose::kSize, Camera::kNumParams, 3, Pose::kSize> {
 public:
  explicit InverseDepthCost(const Vector2& observed) : observed_(observed) {}

  bool Evaluate(double const* const* x, double* residual, double** J) const override {
    const Pose pose(x[0]);
    const Pose host(x[3]);
    const typename Camera::Params intrinsics = Eigen::Map<const typename Camera::Params>(x[1]);
    const double rho = x[2][2];
    const Vector3 s = Vector3(x[2][0], x[2][1], Camera::kViewZ) - rho * host.t_cw;
    const Vector3 rotated = pose.R_cw * (host.R_cw.transpose() * s);
    const Vector3 p_c = rotated + rho * pose.t_cw;
    Vector2 r;
    RowMajor<2, 3> J_p;
    RowMajor<2, Camera::kNumParams> J_intrinsics;
    const bool wanted = J != nullptr;
    if (!reprojection_residual<Camera>(p_c, intrinsics, observed_, r, wanted ? &J_p : nullptr,
                                       wanted ? &J_intrinsics : nullptr)) {
      return false;
    }
    Eigen::Map<Vector2>{residual} = r;
    if (!wanted) return true;
    if (J[0] != nullptr) {
      pose.write_jacobian(pose_jacobian(J_p, rotated).template rightCols<3>(), rho * J_p, J[0]);
    }
    if (J[1] != nullptr) {
      Eigen::Map<RowMajor<2, Camera::kNumParams>>{J[1]} = J_intrinsics;
    }
    const RowMajor<2, 3> J_s = J_p * pose.R_cw * host.R_cw.transpose();  // ∂r/∂s, in the host frame
    if (J[2] != nullptr) {
      Eigen::Map<RowMajor<2, 3>> J_point(J[2]);
      J_point.leftCols<2>() = J_s.leftCols<2>();
      J_point.col(2) = J_p * pose.t_cw - J_s * host.t_cw;
    }
    // R_h ← Exp(φ) R_h: x̄ ← R_hᵀ Exp(−φ) s, so −(φ × s) in the host frame
    if (J[3] != nullptr) {
      host.write_jacobian(-pose_jacobian(J_s, s).template rightCols<3>(), -rho * J_s, J[3]);
    }
    return true;
  }

 private:
  Vector2 observed_;
};

/// The same point seen from its host itself: the pose cancels. Blocks: intrinsics, (α, β, ρ).
template <typename Camera>
class InverseDepthHostCost final : public ceres::SizedCostFunction<2, Camera::kNumParams, 3> {
 public:
  explicit InverseDepthHostCost(const Vector2& observed) : observed_(observed) {}

  bool Evaluate(double const* const* x, double* residual, double** J) const override {
    const typename Camera::Params intrinsics = Eigen::Map<const typename Camera::Params>(x[0]);
    Vector2 r;
    RowMajor<2, 3> J_p;
    RowMajor<2, Camera::kNumParams> J_intrinsics;
    const bool wanted = J != nullptr;
    if (!reprojection_residual<Camera>({x[1][0], x[1][1], Camera::kViewZ}, intrinsics, observed_, r,
                                       wanted ? &J_p : nullptr, wanted ? &J_intrinsics : nullptr)) {
      return false;
    }
    Eigen::Map<Vector2>{residual} = r;
    if (!wanted) return true;
    if (J[0] != nullptr) {
      Eigen::Map<RowMajor<2, Camera::kNumParams>>{J[0]} = J_intrinsics;
    }
    if (J[1] != nullptr) {
      J_p.col(2).setZero();  // the host does not see ρ
      Eigen::Map<RowMajor<2, 3>>{J[1]} = J_p;
    }
    return true;
  }

 private:
  Vector2 observed_;
};

}  // namespace raylign::ceres_backend
