// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/trial_kernels.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <utility>
#include <vector>

#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/landmark_math.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/parametrization/constants.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

// Points whose cameras stand still: the step is theirs alone.
struct Fixture {
  BalProblem problem = test::small_problem();
  Loss loss{LossType::HUBER, 5.0};
  Layout layout{problem};
  CameraBlocks cameras{problem, PoseParametrization::SE3, resolve_constants(problem, {}),
                       layout.observed};
  std::vector<double> X;
  std::vector<double> X_trial;
  std::vector<ObservationJacobian> J{static_cast<std::size_t>(layout.num_observations())};
  std::vector<LandmarkBlock> blocks{static_cast<std::size_t>(layout.num_landmarks())};
  std::vector<LandmarkFactor> factors{blocks.size()};
  std::vector<double> delta = std::vector<double>(layout.num_cameras * kRow, 0.0);

  Fixture() {
    for (const std::int32_t p : layout.points) {
      for (int k = 0; k < 3; ++k) X.push_back(problem.points(p, k));
    }
    X_trial = X;
    linearize_at(X, blocks);
    for (std::size_t j = 0; j < blocks.size(); ++j) factors[j] = factor(j, {false, false, false});
  }

  LandmarkFactor factor(std::size_t j, std::array<bool, 3> held, double scale = 2.0) const {
    const double* H = blocks[j].H;  // a damped step falls short of the minimum
    const double diagonal[3] = {scale * H[0], scale * H[3], scale * H[5]};
    LandmarkFactor factor;
    factor_block(H, diagonal, held.data(), factor.W);
    return factor;
  }

  State state(const std::vector<double>& at) const {
    return {layout.observations(), cameras.packets(), at.data(), &loss};
  }

  double linearize_at(const std::vector<double>& at, std::vector<LandmarkBlock>& out) {
    std::vector<CameraSums> sums(layout.num_cameras, CameraSums{});
    std::vector<CameraRows> scratch(layout.max_window());
    return linearize(state(at), 0, layout.num_windows(),
                     {{J.data(), nullptr}, out.data(), sums.data(), 0, scratch.data()});
  }

  int num_behind(const std::vector<double>& at) const {
    int count = 0;
    for (std::size_t j = 0; j < blocks.size(); ++j) {
      for (int i = 0; i < layout.num_cameras; ++i) {
        const CameraPacket& camera = cameras.packets()[i];
        const double* x = at.data() + 3 * j;
        const double* R_z = camera.R + 6;
        const double z = R_z[0] * x[0] + R_z[1] * x[1] + R_z[2] * x[2] + camera.t[2];
        count += z >= 0.0 ? 1 : 0;  // BAL looks along −z
      }
    }
    return count;
  }

  TrialSums run(bool refine_points) {
    std::vector<TrialScratch> scratch(layout.max_track_length());
    const TrialStep step{state(X),       cameras.packets(), {J.data(), nullptr}, blocks.data(),
                         factors.data(), delta.data(),      X_trial.data(),      refine_points};
    return try_landmarks(step, 0, layout.num_landmarks(), scratch.data());
  }
};

double largest_gradient(const std::vector<LandmarkBlock>& blocks) {
  double largest = 0.0;
  for (const LandmarkBlock& block : blocks) {
    for (const double g : block.g) largest = std::max(largest, std::abs(g));
  }
  return largest;
}

TEST(TrialKernels, RefinementGoesOnToTheMinimumOfEachPoint) {
  Fixture s;
  const double start = largest_gradient(s.blocks);
  const TrialSums joint = s.run(false);
  const TrialSums refined = s.run(true);
  EXPECT_LT(refined.cost, joint.cost);
  // the model is credited with what came on top of its step
  EXPECT_NEAR(refined.model_decrease - joint.model_decrease, joint.cost - refined.cost,
              1e-10 * joint.cost);
  EXPECT_EQ(refined.squared_step, joint.squared_step);
  std::vector<LandmarkBlock> after = s.blocks;
  EXPECT_NEAR(s.linearize_at(s.X_trial, after), refined.cost, 1e-12 * refined.cost);
  EXPECT_LT(largest_gradient(after), 1e-2 * start);
}

TEST(TrialKernels, HeldCoordinatesKeepTheirBits) {
  Fixture s;
  s.factors[3] = s.factor(3, {false, true, false});
  s.factors[4] = s.factor(4, {true, true, true});
  s.run(true);
  EXPECT_EQ(s.X_trial[3 * 3 + 1], s.X[3 * 3 + 1]);
  EXPECT_NE(s.X_trial[3 * 3], s.X[3 * 3]);
  for (int k = 0; k < 3; ++k) EXPECT_EQ(s.X_trial[3 * 4 + k], s.X[3 * 4 + k]);
}

TEST(TrialKernels, APointThatTheStepPutsBehindACameraStartsFromWhereItWas) {
  Fixture s;
  EXPECT_EQ(s.num_behind(s.X), 0);
  for (LandmarkFactor& factor : s.factors) {  // steps that leave the scene
    for (double& w : factor.W) w *= 1e2;
  }
  s.run(false);
  EXPECT_GT(s.num_behind(s.X_trial), 0);
  s.run(true);
  EXPECT_EQ(s.num_behind(s.X_trial), 0);
}

// Of the whole solve: the same minimum as the path of Ceres, in no more steps.
TEST(FastMode, ReachesTheMinimumOfParityInNoMoreSteps) {
  for (const auto kind : {PointParametrization::XYZ, PointParametrization::HOMOGENEOUS}) {
    BundleOptions options;
    options.backend = Backend::NATIVE;
    options.point_parametrization = kind;
    options.lm.function_tolerance = 1e-12;
    BalProblem fast = test::small_problem();
    BalProblem slow = fast;
    const Summary ours = adjust(fast, {}, options);
    options.parity = true;
    const Summary theirs = adjust(slow, {}, options);
    EXPECT_NEAR(ours.final_cost, theirs.final_cost, 1e-9 * theirs.final_cost);
    EXPECT_LE(ours.iterations.size(), theirs.iterations.size());
  }
}

}  // namespace
}  // namespace raylign::native
