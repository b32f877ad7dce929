// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/photometric_alignment.h"

#include <ceres/problem.h>
#include <ceres/sized_cost_function.h>
#include <ceres/solver.h>

#include "raylign/ceres_backend/robust_loss.h"
#include "raylign/geometry/se3.h"
#include "raylign/image/sample.h"
#include "raylign/residuals/photometric.h"

namespace raylign::ceres_backend {
namespace {

class PhotometricCost final : public ceres::SizedCostFunction<1, 6> {
 public:
  PhotometricCost(const PhotometricPoint& point,
                  const PlaneView<GradientCell>& target,
                  const PinholeCamera& camera,
                  const Matrix4& T_init)
      : point_(point), target_(target), camera_(camera), T_init_(T_init) {}

  bool Evaluate(double const* const* x, double* residual, double** J) const override {
    const Vector6 xi = Eigen::Map<const Vector6>(x[0]);
    const Matrix4 T = se3_exp(xi) * T_init_;
    WarpPose<double> pose = {{}, {}, camera_.fx(), camera_.fy(), camera_.cx(), camera_.cy()};
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 3; ++k) pose.R[3 * row + k] = T(row, k);
      pose.t[row] = T(row, 3);
    }
    const WarpedPoint<double> p = warp(point_.ray_x, point_.ray_y, point_.D, pose);
    Sample<double> sample = {};
    const bool is_seen = p.inverse_q > 0.0 && sample_bilinear(target_, p.u, p.v, sample);
    const double weight = is_seen ? 1.0 / point_.sigma : 0.0;
    residual[0] = weight * photometric_residual(point_.I, sample.value, 1.0, 0.0);
    if (J == nullptr || J[0] == nullptr) return true;
    RowMajor<1, 6> J_left = RowMajor<1, 6>::Zero();
    if (is_seen) photometric_jacobian(p, pose, sample.du, sample.dv, J_left.data());
    Eigen::Map<RowMajor<1, 6>>{J[0]} = weight * J_left * se3_left_jacobian(xi);
    return true;
  }

 private:
  PhotometricPoint point_;
  PlaneView<GradientCell> target_;
  PinholeCamera camera_;
  Matrix4 T_init_;
};

}  // namespace

PhotometricAlignment align_photometric(const std::vector<PhotometricPoint>& points,
                                       const PlaneView<GradientCell>& target,
                                       const PinholeCamera& camera,
                                       const Matrix4& T_init,
                                       const Loss& loss,
                                       const LmOptions& options) {
  Vector6 xi = Vector6::Zero();
  RobustLoss robust_loss(loss);
  ceres::Problem::Options ownership;
  ownership.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  ceres::Problem problem(ownership);
  for (const PhotometricPoint& point : points) {
    problem.AddResidualBlock(new PhotometricCost(point, target, camera, T_init), &robust_loss,
                             xi.data());
  }
  ceres::Solver::Options ceres_options;
  ceres_options.linear_solver_type = ceres::DENSE_NORMAL_CHOLESKY;
  ceres_options.max_num_iterations = options.max_num_iterations;
  ceres_options.function_tolerance = options.function_tolerance;
  ceres_options.gradient_tolerance = options.gradient_tolerance;
  ceres_options.parameter_tolerance = options.parameter_tolerance;
  ceres_options.num_threads = options.num_threads;
  ceres_options.logging_type = ceres::SILENT;
  ceres::Solver::Summary summary;
  ceres::Solve(ceres_options, &problem, &summary);
  PhotometricAlignment result;
  result.T_th = se3_exp(xi) * T_init;
  result.cost = summary.final_cost;
  result.converged = summary.termination_type == ceres::CONVERGENCE;
  return result;
}

}  // namespace raylign::ceres_backend
