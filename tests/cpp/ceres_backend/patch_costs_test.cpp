// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <ceres/crs_matrix.h>
#include <gtest/gtest.h>

#include "raylign/ceres_backend/patch_problem.h"
#include "support/eigen_matchers.h"
#include "support/patch_scenes.h"

namespace raylign::ceres_backend {
namespace {

using test::patch_case;
using test::PatchSceneOptions;

struct Case {
  const char* name;
  LossScope scope;
  bool hosted, inverse_depth, intrinsics_per_image;
  double noise_ratio = 0.0;
};

class PatchJacobian : public testing::TestWithParam<Case> {};

// All residuals, priors included, and the Jacobian with respect to the tangents of what is free.
struct Evaluated {
  double cost = 0.0;
  std::vector<double> residuals;
  Eigen::MatrixXd J;
};

Evaluated evaluate(PatchProblem& problem, const std::vector<double*>& blocks) {
  ceres::Problem::EvaluateOptions options;
  options.parameter_blocks = blocks;
  options.apply_loss_function = false;
  Evaluated out;
  ceres::CRSMatrix jacobian;
  EXPECT_TRUE(
      problem.ceres_problem().Evaluate(options, &out.cost, &out.residuals, nullptr, &jacobian));
  out.J.setZero(jacobian.num_rows, jacobian.num_cols);
  for (int row = 0; row < jacobian.num_rows; ++row) {
    for (int k = jacobian.rows[row]; k < jacobian.rows[row + 1]; ++k) {
      out.J(row, jacobian.cols[k]) = jacobian.values[k];
    }
  }
  return out;
}

TEST_P(PatchJacobian, MatchesDifferences) {
  const Case& c = GetParam();
  PatchSceneOptions scene_options;
  scene_options.num_points = 5;
  scene_options.brightness = true;
  scene_options.hosted = c.hosted;
  scene_options.inverse_depth = c.inverse_depth;
  scene_options.intrinsics_per_image = c.intrinsics_per_image;
  scene_options.noise_ratio = c.noise_ratio;
  PatchScene scene = patch_case(scene_options).start;
  scene.edges[2].mask = 0x0ff7u;
  PatchConstraints held = test::patch_constraints(scene, true, true);
  held.poses[2].translation[1] = true;
  held.intrinsics.back()[2] = true;
  held.weight_a = 10.0;
  held.weight_b = 0.1;
  Matrix6 information = Matrix6::Identity() * 3.0;
  information(0, 4) = information(4, 0) = 1.0;
  Matrix4 T = Matrix4::Identity();
  T(0, 3) = 0.3;
  held.pose_priors.push_back({1, T, information});
  held.point_priors.push_back({3, {0.4, 0.1, 2.0}, Matrix3::Identity() * 7.0});
  PatchSolveOptions options;
  options.scope = c.scope;
  PatchProblem problem(scene, held, options);
  ASSERT_EQ(problem.invalid_start(), "");

  std::vector<double*> blocks;
  for (double* block : problem.blocks()) {
    if (!problem.ceres_problem().IsParameterBlockConstant(block)) blocks.push_back(block);
  }
  const Evaluated at = evaluate(problem, blocks);
  const double h = 1e-5;
  Eigen::Index column = 0;
  for (double* block : blocks) {
    const ceres::Problem& ceres_problem = problem.ceres_problem();
    const int size = ceres_problem.ParameterBlockSize(block);
    const ceres::Manifold* manifold = ceres_problem.GetManifold(block);
    const int tangent_size = ceres_problem.ParameterBlockTangentSize(block);
    const Eigen::VectorXd start = Eigen::Map<Eigen::VectorXd>(block, size);
    for (int k = 0; k < tangent_size; ++k, ++column) {
      const auto residuals_at = [&](double step) -> Eigen::VectorXd {
        const Eigen::VectorXd delta = step * Eigen::VectorXd::Unit(tangent_size, k);
        if (manifold != nullptr) {
          manifold->Plus(start.data(), delta.data(), block);
        } else {
          Eigen::Map<Eigen::VectorXd>{block, size} = start + delta;
        }
        std::vector<double> r = evaluate(problem, blocks).residuals;
        Eigen::Map<Eigen::VectorXd>{block, size} = start;
        return Eigen::Map<Eigen::VectorXd>(r.data(), static_cast<Eigen::Index>(r.size()));
      };
      // fourth order
      const Eigen::VectorXd J = (8.0 * (residuals_at(h) - residuals_at(-h)) -
                                 (residuals_at(2.0 * h) - residuals_at(-2.0 * h))) /
                                (12.0 * h);
      EXPECT_TRUE(test::is_relatively_near(at.J.col(column), J, 1e-6)) << "column " << column;
    }
  }
  EXPECT_EQ(column, at.J.cols());
}

INSTANTIATE_TEST_SUITE_P(All,
                         PatchJacobian,
                         testing::Values(Case{"xyz", LossScope::PATCH, true, false, false},
                                         Case{"xyz_pixels", LossScope::PIXEL, true, false, false},
                                         Case{"stored", LossScope::PATCH, false, false, true},
                                         Case{"noise_of_both", LossScope::PIXEL, true, false, false,
                                              0.8},
                                         Case{"inverse_depth", LossScope::PATCH, true, true, false},
                                         Case{"inverse_depth_pixels_intrinsics_per_image",
                                              LossScope::PIXEL, true, true, true}),
                         [](const auto& test_case) { return test_case.param.name; });

TEST(PatchProblem, TheHostItselfMovesNothing) {
  PatchSceneOptions scene_options;
  scene_options.num_points = 5;
  scene_options.inverse_depth = true;
  PatchScene scene = patch_case(scene_options).start;
  for (std::int64_t e = 0; e < scene.starts[1]; ++e) scene.edges[e].image = scene.hosts[0];
  for (int i = 0; i < 16; ++i) scene.patches[i] += 10.0f;  // else there is nothing to derive
  PatchConstraints held = test::patch_constraints(scene, true, true);
  held.poses.assign(5, {});
  PatchProblem problem(scene, held, {});
  const Evaluated at = evaluate(problem, problem.blocks());
  const Eigen::Index rows = 16 * scene.starts[1];
  EXPECT_LT(at.J.topRows(rows).cwiseAbs().maxCoeff(), 1e-9 * at.J.cwiseAbs().maxCoeff());
}

}  // namespace
}  // namespace raylign::ceres_backend
