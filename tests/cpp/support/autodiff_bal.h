// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/ceres.h>
#include <ceres/rotation.h>

#include <memory>
#include <vector>

#include "raylign/camera/bal.h"
#include "raylign/scene/bal_problem.h"

namespace raylign::test {

/// The formulation of Ceres' own BAL example: one block of nine numbers per camera, additive,
/// automatic differentiation. The reference of tests and benchmarks.
struct AutodiffBalResidual {
  double u, v;

  template <typename T>
  bool operator()(const T* camera, const T* point, T* residual) const {
    T p_c[3];
    ceres::AngleAxisRotatePoint(camera, point, p_c);
    for (int k = 0; k < 3; ++k) p_c[k] += camera[3 + k];
    bal_project(camera + 6, p_c, residual);
    residual[0] -= u;
    residual[1] -= v;
    return true;
  }
};

/// A BAL problem in that formulation; `problem` is optimised in place.
class AutodiffBal {
 public:
  explicit AutodiffBal(BalProblem& problem) : problem_(problem) {
    for (std::int64_t i = 0; i < problem.num_observations(); ++i) {
      using Cost = ceres::AutoDiffCostFunction<AutodiffBalResidual, 2, 9, 3>;
      const auto uv = problem.observations.row(i);
      ceres_.AddResidualBlock(new Cost(new AutodiffBalResidual{uv[0], uv[1]}), nullptr,
                              camera(problem.camera_index[i]), point(problem.point_index[i]));
    }
  }

  ceres::Solver::Summary solve(ceres::Solver::Options options) {
    auto ordering = std::make_shared<ceres::ParameterBlockOrdering>();
    std::vector<double*> blocks;
    ceres_.GetParameterBlocks(&blocks);
    const double* first = problem_.points.data();
    const double* last = first + problem_.points.size();
    for (double* block : blocks) {
      ordering->AddElementToGroup(block, block >= first && block < last ? 0 : 1);
    }
    options.linear_solver_ordering = ordering;
    ceres::Solver::Summary summary;
    ceres::Solve(options, &ceres_, &summary);
    return summary;
  }

 private:
  double* camera(std::int32_t c) { return problem_.cameras.data() + 9 * std::int64_t{c}; }
  double* point(std::int32_t p) { return problem_.points.data() + 3 * std::int64_t{p}; }

  BalProblem& problem_;
  ceres::Problem ceres_;
};

}  // namespace raylign::test
