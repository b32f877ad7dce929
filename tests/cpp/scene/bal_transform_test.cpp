// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_transform.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/scene/bal_statistics.h"
#include "support/eigen_matchers.h"
#include "support/small_problem.h"

namespace raylign::test {
namespace {

Matrix4 random_similarity(int index) {
  NamedRng rng = make_rng("bal_transform", index);
  Matrix4 S = Matrix4::Identity();
  S.topLeftCorner<3, 3>() = rng.uniform(0.1, 10.0) * so3_exp(rng.normal_vector<3>());
  S.topRightCorner<3, 1>() = rng.normal_vector<3>();
  return S;
}

TEST(BalTransform, CostIsInvariantAndTheWayBackIsExactToRounding) {
  const BalProblem problem = small_problem();
  const double cost = reprojection_cost(problem);
  for (int i = 0; i < 20; ++i) {
    const Matrix4 S = random_similarity(i);
    const BalProblem moved = transform(problem, S);
    EXPECT_NEAR(reprojection_cost(moved), cost, 1e-12 * cost);
    const BalProblem back = transform(moved, inverse_similarity(S));
    EXPECT_TRUE(is_near(back.points, problem.points, 1e-12));
    EXPECT_TRUE(is_near(back.cameras, problem.cameras, 1e-12));
  }
}

TEST(BalTransform, DepthsGrowByTheScale) {
  const BalProblem problem = small_problem();
  Matrix4 S = Matrix4::Identity();
  S.topLeftCorner<3, 3>() *= 3.0;
  EXPECT_TRUE(is_near(depths(transform(problem, S)), 3.0 * depths(problem), 1e-14));
}

TEST(BalTransform, WithoutRotationTheAngleAxisIsVerbatim) {
  const BalProblem problem = small_problem();
  Matrix4 S = Matrix4::Identity();
  S.topLeftCorner<3, 3>() *= 7.3;
  S.topRightCorner<3, 1>() << 1.0, -2.0, 3.0;
  EXPECT_EQ(transform(problem, S).cameras.leftCols<3>(), problem.cameras.leftCols<3>());
  EXPECT_TRUE(transform(problem, Matrix4::Identity()) == problem);
}

TEST(BalTransform, InverseTimesForwardIsIdentity) {
  const Matrix4 S = random_similarity(99);
  EXPECT_TRUE(is_near(inverse_similarity(S) * S, Matrix4::Identity(), 1e-14));
}

TEST(BalTransform, RefusesWhatIsNoSimilarity) {
  Matrix4 shear = Matrix4::Identity();
  shear(0, 1) = 1e-6;
  Matrix4 mirror = Matrix4::Identity();
  mirror(2, 2) = -1.0;
  Matrix4 projective = Matrix4::Identity();
  projective(3, 0) = 1e-12;
  const Matrix4 nan = Matrix4::Constant(std::numeric_limits<double>::quiet_NaN());
  for (const Matrix4& S : {shear, mirror, projective, nan, Matrix4(Matrix4::Zero())}) {
    EXPECT_THROW(transform(small_problem(), S), ShapeError);
    EXPECT_THROW(inverse_similarity(S), ShapeError);
  }
}

TEST(BalTransform, NormalizeCentresAndScales) {
  const BalProblem problem = small_problem(5, 41);
  const NormalizedProblem normalized = normalize(problem, 100.0);
  const SceneExtent extent = scene_extent(normalized.problem);
  EXPECT_TRUE(is_near(extent.center, Vector3(Vector3::Zero()), 1e-11));
  EXPECT_NEAR(extent.deviation, 100.0, 1e-10);
  const double cost = reprojection_cost(problem);
  EXPECT_NEAR(reprojection_cost(normalized.problem), cost, 1e-12 * cost);
  const BalProblem back = transform(normalized.problem, inverse_similarity(normalized.S_nw));
  EXPECT_TRUE(is_near(back.points, problem.points, 1e-12));
  EXPECT_TRUE(is_near(back.cameras, problem.cameras, 1e-12));
}

TEST(BalTransform, NormalizeSurvivesNaNPoints) {
  BalProblem problem = small_problem();
  for (int i = 0; i < 40; i += 2)
    problem.points(i, i % 3) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(normalize(problem).S_nw.allFinite());
  EXPECT_TRUE(normalize(BalProblem{}).S_nw.isIdentity(0.0));
}

TEST(BalTransform, ScenesAtTheLimitsOfDoubleAreOnlyMoved) {
  BalProblem overflowing = small_problem();
  for (Eigen::Index p = 0; p < overflowing.num_points(); ++p) {
    overflowing.points.row(p).setConstant(p % 2 == 0 ? 1.7e308 : -1.7e308);
  }
  BalProblem vanishing = small_problem();
  vanishing.points *= 1e-320;
  for (const BalProblem& problem : {overflowing, vanishing}) {
    const Matrix3 sR = normalize(problem).S_nw.topLeftCorner<3, 3>();
    EXPECT_EQ(sR, Matrix3(Matrix3::Identity()));
  }
  BalProblem large = small_problem();
  large.points *= 1e200;
  EXPECT_NEAR(scene_extent(normalize(large).problem).deviation, 100.0, 1e-10);
}

TEST(BalTransform, NormalizeRefusesImpossibleExtents) {
  for (const double extent : {0.0, -1.0, std::numeric_limits<double>::infinity(),
                              std::numeric_limits<double>::quiet_NaN()}) {
    EXPECT_THROW(normalize(small_problem(), extent), OptionsError);
  }
}

TEST(BalTransform, CentresArePointsThatThePosesMapToZero) {
  const BalProblem problem = small_problem();
  const Rows<double, 3> centers = camera_centers(problem);
  const Rows<double, 16> poses = camera_poses(problem);
  for (int c = 0; c < problem.num_cameras(); ++c) {
    const Matrix4 T_cw = Eigen::Map<const RowMajor<4, 4>>(poses.row(c).data());
    EXPECT_TRUE(
        is_near(T_cw * centers.row(c).transpose().homogeneous(), Vector4(Vector4::UnitW()), 1e-14));
  }
}

}  // namespace
}  // namespace raylign::test
