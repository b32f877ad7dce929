// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_priors.h"

#include <Eigen/Eigenvalues>

#include "raylign/ceres_backend/pose_manifold.h"
#include "raylign/geometry/se3.h"

namespace raylign::ceres_backend {
namespace {

// rootᵀ root = Λ also where Λ has no rank to spare: a prior may leave directions free.
Eigen::MatrixXd root_of(const Eigen::MatrixXd& information) {
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(information);
  return eigen.eigenvalues().cwiseMax(0.0).cwiseSqrt().asDiagonal() *
         eigen.eigenvectors().transpose();
}

}  // namespace

PosePriorCost::PosePriorCost(const PosePrior& prior)
    : inverse_prior_(se3_inverse(prior.T_cw)), root_(root_of(prior.information)) {}

bool PosePriorCost::Evaluate(double const* const* x, double* residual, double** J) const {
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = Eigen::Map<const Quaternion>(x[0]).toRotationMatrix();
  T.topRightCorner<3, 1>() = Eigen::Map<const Vector3>(x[0] + 4);
  const Vector6 xi = se3_log(T * inverse_prior_);
  Eigen::Map<Vector6>{residual} = root_ * xi;
  if (J == nullptr || J[0] == nullptr) return true;
  RowMajor<6, 7> d_tangent_d_block;
  PoseManifold(TranslationUpdate::COUPLED).MinusJacobian(x[0], d_tangent_d_block.data());
  Eigen::Map<RowMajor<6, 7>>{J[0]} = root_ * se3_left_jacobian_inverse(xi) * d_tangent_d_block;
  return true;
}

LinearPriorCost::LinearPriorCost(const Eigen::VectorXd& value, const Eigen::MatrixXd& information)
    : value_(value), root_(root_of(information)) {
  set_num_residuals(static_cast<int>(value.size()));
  mutable_parameter_block_sizes()->push_back(static_cast<int>(value.size()));
}

bool LinearPriorCost::Evaluate(double const* const* x, double* residual, double** J) const {
  const Eigen::Index size = value_.size();
  Eigen::Map<Eigen::VectorXd>{residual, size} =
      root_ * (Eigen::Map<const Eigen::VectorXd>(x[0], size) - value_);
  if (J != nullptr && J[0] != nullptr) {
    Eigen::Map<decltype(root_)>{J[0], size, size} = root_;
  }
  return true;
}

}  // namespace raylign::ceres_backend
