// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_blocks.h"

#include <gtest/gtest.h>

#include "raylign/geometry/so3.h"
#include "support/eigen_matchers.h"
#include "support/numeric_jacobian.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

using Vector9 = Eigen::Matrix<double, 9, 1>;
using Block9 = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;

BalProblem problem_with_rotation(const Vector3& omega) {
  BalProblem problem = test::small_problem(2, 5);
  problem.cameras.row(1).head<3>() = omega.transpose();
  problem.cameras.row(1).segment<3>(3) << 0.4, -1.3, 2.2;
  return problem;
}

// [ω; δc; δ(f, k1, k2)] between two packets.
Vector9 canonical_difference(const CameraPacket& from, const CameraPacket& to) {
  using ConstMatrix3 = Eigen::Map<const RowMajor<3, 3>>;
  using ConstVector3 = Eigen::Map<const Vector3>;
  Vector9 d;
  d << so3_log(ConstMatrix3(from.R).transpose() * ConstMatrix3(to.R)),
      ConstVector3(to.c) - ConstVector3(from.c),
      ConstVector3(to.intrinsics) - ConstVector3(from.intrinsics);
  return d;
}

class TangentMap : public testing::TestWithParam<std::tuple<PoseParametrization, int>> {};

Constants held_by(int bits, const BalProblem& problem) {
  Constants held = resolve_constants(problem, {});
  held.poses[1].rotation = (bits & 1) != 0;
  held.poses[1].translation[0] = (bits & 2) != 0;
  held.poses[1].translation[2] = (bits & 4) != 0;
  held.intrinsics[1][1] = (bits & 8) != 0;
  return held;
}

TEST_P(TangentMap, IsTheDerivativeOfTheStep) {
  const auto [parametrization, bits] = GetParam();
  auto rng = test::make_rng("tangent map", bits);
  for (const Vector3& omega : {Vector3(0, 0, 0), Vector3(1e-9, 0, 1e-9), Vector3(0.3, -1.1, 0.8),
                               Vector3((M_PI - 1e-6) * rng.unit_vector<3>())}) {
    const BalProblem problem = problem_with_rotation(omega);
    CameraBlocks cameras(problem, parametrization, held_by(bits, problem), {true, true});
    const int size = cameras.size(1);
    const auto moved = [&](const Eigen::VectorXd& delta) {
      Eigen::VectorXd all = Eigen::VectorXd::Zero(cameras.num_columns());
      all.segment(cameras.offset(1), size) = delta;
      cameras.try_step(all.data());
      return canonical_difference(cameras.packets()[1], cameras.trial_packets()[1]);
    };
    const Eigen::MatrixXd numeric =
        test::numeric_jacobian(moved, Eigen::VectorXd(Eigen::VectorXd::Zero(size)));
    const Block9 B(cameras.map(1).values);
    EXPECT_TRUE(test::is_near(B.leftCols(size), numeric, 1e-8)) << "omega " << omega.transpose();
    EXPECT_TRUE(B.rightCols(kRow - size).isZero(0.0));
  }
}

// Centres and translations in the frame of homogeneous points.
TEST(CameraBlocks, MapIsTheDerivativeOfTheStepInAnyFrame) {
  const BalProblem problem = problem_with_rotation({0.3, -1.1, 0.8});
  const HomogeneousFrame frame{{1.0, -2.0, 0.5}, 3.0};
  CameraBlocks cameras(problem, PoseParametrization::SE3, resolve_constants(problem, {}),
                       {true, true}, frame);
  const auto moved = [&](const Vector9& delta) {
    Eigen::VectorXd all = Eigen::VectorXd::Zero(cameras.num_columns());
    all.segment<9>(cameras.offset(1)) = delta;
    cameras.try_step(all.data());
    return canonical_difference(cameras.packets()[1], cameras.trial_packets()[1]);
  };
  EXPECT_TRUE(test::is_near(Block9(cameras.map(1).values).leftCols<9>(),
                            test::numeric_jacobian(moved, Vector9(Vector9::Zero())), 1e-8));
}

TEST_P(TangentMap, HeldCoordinatesKeepTheirBits) {
  const auto [parametrization, bits] = GetParam();
  const BalProblem before = problem_with_rotation({0.3, -1.1, 0.8});
  CameraBlocks cameras(before, parametrization, held_by(bits, before), {true, true});
  auto rng = test::make_rng("held coordinates", bits);
  for (int i = 0; i < 3; ++i) {
    const std::vector<double> delta(cameras.num_columns(), rng.normal(0.1));
    cameras.try_step(delta.data());
    cameras.accept();
  }
  BalProblem after = before;
  BundleScene scene(before);
  cameras.write_back(scene);
  scene.store(after);
  const Eigen::Matrix<bool, 9, 1> same =
      (after.cameras.row(1).array() == before.cameras.row(1).array()).transpose();
  Eigen::Matrix<bool, 9, 1> expected;
  const bool rotation = (bits & 1) != 0;
  expected << rotation, rotation, rotation, (bits & 2) != 0, false, (bits & 4) != 0, false,
      (bits & 8) != 0, false;
  EXPECT_EQ(same, expected);
}

INSTANTIATE_TEST_SUITE_P(Masks,
                         TangentMap,
                         testing::Combine(testing::Values(PoseParametrization::SE3,
                                                          PoseParametrization::QUATERNION,
                                                          PoseParametrization::ANGLE_AXIS),
                                          testing::Values(0, 1, 2, 6, 8, 15)),
                         [](const auto& instance) {
                           return to_string(std::get<0>(instance.param)) + "_" +
                                  std::to_string(std::get<1>(instance.param));
                         });

TEST(CameraBlocks, UnobservedCamerasHaveNoColumns) {
  const BalProblem problem = problem_with_rotation({0.1, 0.2, 0.3});
  const CameraBlocks cameras(problem, PoseParametrization::SE3, resolve_constants(problem, {}),
                             {false, true});
  EXPECT_EQ(cameras.size(0), 0);
  EXPECT_EQ(cameras.size(1), 9);
  EXPECT_EQ(cameras.num_columns(), 9);
}

}  // namespace
}  // namespace raylign::native
