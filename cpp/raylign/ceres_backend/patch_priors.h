// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/cost_function.h>
#include <ceres/sized_cost_function.h>

#include "raylign/patch/patch_solve_options.h"

namespace raylign::ceres_backend {

/// ½ ξᵀ Λ ξ, ξ = log(T_cw T_prior⁻¹). Block: pose [q, t].
class PosePriorCost final : public ceres::SizedCostFunction<6, 7> {
 public:
  explicit PosePriorCost(const PosePrior& prior);
  bool Evaluate(double const* const* x, double* residual, double** J) const override;

 private:
  Matrix4 inverse_prior_;
  Matrix6 root_;  // rootᵀ root = Λ
};

/// ½ (x − x₀)ᵀ Λ (x − x₀) of the first `size` coordinates.
class LinearPriorCost final : public ceres::CostFunction {
 public:
  LinearPriorCost(const Eigen::VectorXd& value, const Eigen::MatrixXd& information);
  bool Evaluate(double const* const* x, double* residual, double** J) const override;

 private:
  Eigen::VectorXd value_;
  Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor> root_;
};

}  // namespace raylign::ceres_backend
