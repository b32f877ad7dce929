// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What a reconstruction cannot know: at the minimum the undamped reduced system has the seven
// similarities of the world as its null space, and nothing else.
#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <Eigen/QR>

#include "bundle/reference.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/geometry/so3.h"
#include "raylign/parametrization/constants.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

BundleOptions options_of(PointParametrization point) {
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.pose_parametrization = PoseParametrization::QUATERNION;
  options.point_parametrization = point;
  options.lm.max_num_iterations = 100;
  options.lm.function_tolerance = 1e-15;
  return options;
}

// S of the minimum, undamped, columns of unit length; the lengths.
struct Minimum {
  BalProblem problem = test::small_problem(8, 60);
  Eigen::MatrixXd S;
  Eigen::VectorXd scale;

  Minimum(Gauge gauge, PointParametrization point) {
    const BundleOptions options = options_of(point);
    BundleConfig config;
    config.gauge = gauge;
    adjust(problem, config, options);
    ReprojectionProblem native(problem, resolve_constants(problem, config), options);
    native.linearize();
    const SolverContext context{native.layout(), native.cameras(), native.pool()};
    SchurSystem system(context, SchurPattern(context.layout, moving_cameras(context.cameras)));
    system.form(native.damped(0.0));
    S = test::dense_schur(system);
    scale = S.diagonal().cwiseSqrt();
    S = (scale.cwiseInverse().asDiagonal() * S * scale.cwiseInverse().asDiagonal()).eval();
  }
  Eigen::VectorXd eigenvalues() const {
    return Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd>(S, Eigen::EigenvaluesOnly).eigenvalues();
  }
};

class NullSpace : public testing::TestWithParam<PointParametrization> {};

TEST_P(NullSpace, HasSevenDimensionsWhereTheGaugeIsFree) {
  const Eigen::VectorXd eigenvalues = Minimum(Gauge::FREE, GetParam()).eigenvalues();
  EXPECT_LT(eigenvalues.head<7>().cwiseAbs().maxCoeff(), 1e-12);
  EXPECT_GT(eigenvalues[7], 1e-9);
}

TEST_P(NullSpace, KeepsTheScaleWhereOneCameraIsHeld) {
  const Eigen::VectorXd eigenvalues = Minimum(Gauge::FIRST_CAMERA, GetParam()).eigenvalues();
  EXPECT_LT(std::abs(eigenvalues[0]), 1e-12);
  EXPECT_GT(eigenvalues[1], 1e-9);
}

TEST_P(NullSpace, IsEmptyWhereTwoCamerasHoldTheGauge) {
  EXPECT_GT(Minimum(Gauge::TWO_CAMERAS, GetParam()).eigenvalues()[0], 1e-9);
}

// Tangent [υ; φ; δ(f, k1, k2)] with t ← t + υ, R ← Exp(φ) R, of the world X ← Exp(ω) X (1 + σ) + τ:
// the pixels stay where R ← R Exp(−ω), t ← (1 + σ) t − R τ.
TEST_P(NullSpace, IsTheSimilaritiesOfTheWorld) {
  const Minimum minimum(Gauge::FREE, GetParam());
  const auto num_cameras = static_cast<Eigen::Index>(minimum.problem.num_cameras());
  Eigen::MatrixXd modes = Eigen::MatrixXd::Zero(9 * num_cameras, 7);
  for (Eigen::Index i = 0; i < num_cameras; ++i) {
    const Matrix3 R = so3_exp(minimum.problem.cameras.row(i).head<3>().transpose());
    modes.block<3, 3>(9 * i, 0) = -R;
    modes.block<3, 3>(9 * i + 3, 3) = -R;
    modes.block<3, 1>(9 * i, 6) = minimum.problem.cameras.row(i).segment<3>(3).transpose();
  }
  const Eigen::MatrixXd scaled = minimum.scale.asDiagonal() * modes;
  const Eigen::MatrixXd Q = Eigen::HouseholderQR<Eigen::MatrixXd>(scaled).householderQ() *
                            Eigen::MatrixXd::Identity(scaled.rows(), 7);
  EXPECT_LT((minimum.S * Q).norm(), 1e-11);
}

INSTANTIATE_TEST_SUITE_P(Points,
                         NullSpace,
                         testing::Values(PointParametrization::XYZ,
                                         PointParametrization::HOMOGENEOUS),
                         [](const auto& instance) { return to_string(instance.param); });

}  // namespace
}  // namespace raylign::native
