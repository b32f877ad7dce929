// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bundle_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>

#include "raylign/base/error.h"
#include "raylign/scene/bal_statistics.h"
#include "raylign/solver/bundle_config.h"
#include "support/eigen_matchers.h"
#include "support/small_bundle.h"
#include "support/small_problem.h"

namespace raylign {
namespace {

class Models : public testing::TestWithParam<CameraModel> {};
INSTANTIATE_TEST_SUITE_P(All,
                         Models,
                         testing::ValuesIn(all_camera_models()),
                         [](const auto& instance) { return to_string(instance.param); });

TEST_P(Models, NamesOfTheParametersAreAllKnownToTheConfig) {
  const auto names = param_names(GetParam());
  EXPECT_EQ(static_cast<int>(names.size()), num_params(GetParam()));
  for (const std::string& name : names) {
    EXPECT_EQ(std::count(any_intrinsics().begin(), any_intrinsics().end(), name), 1) << name;
  }
}

TEST_P(Models, ASceneStoresWhatItLoadedBitByBit) {
  const BundleProblem problem = test::small_bundle(GetParam()).problem;
  BundleProblem stored = problem;
  BundleScene(problem).store(stored);
  EXPECT_TRUE(stored == problem);
}

TEST_P(Models, ASceneStoresWhatMoved) {
  const BundleProblem problem = test::small_bundle(GetParam()).problem;
  BundleProblem stored = problem;
  BundleScene scene(problem);
  scene.omega(2, 1) += 0.1;
  scene.t(3, 0) += 0.5;
  scene.intrinsics(1, 0) += 7.0;
  scene.points(4, 2) -= 1.0;
  scene.store(stored);
  EXPECT_TRUE(test::is_near(BundleScene(stored).omega, scene.omega, 1e-14));
  EXPECT_EQ(stored.pose(3)(0, 3), problem.pose(3)(0, 3) + 0.5);
  EXPECT_EQ(stored.intrinsics, scene.intrinsics);
  EXPECT_EQ(stored.points, scene.points);
  const Eigen::Array<bool, Eigen::Dynamic, 1> moved =
      (stored.T_cw.array() != problem.T_cw.array()).rowwise().any();
  EXPECT_EQ(moved.count(), 2);
}

TEST_P(Models, NoiseFreePixelsHaveNoResidual) {
  const BundleProblem truth = test::small_bundle(GetParam(), 0.0).truth;
  EXPECT_LT(reprojection_residuals(truth).cwiseAbs().maxCoeff(), 1e-11);
  EXPECT_GT(depths(truth).minCoeff(), 0.0);
  EXPECT_EQ(statistics(truth).num_behind_camera, 0);
}

TEST_P(Models, APointBehindTheCameraHasNegativeDepth) {
  BundleProblem problem = test::small_bundle(GetParam()).truth;
  const Matrix4 T_wc = problem.pose(0).inverse();
  const Vector4 behind(0.1, 0.2, GetParam() == CameraModel::BAL ? 3.0 : -3.0, 1.0);
  problem.points.row(7) = (T_wc * behind).head<3>().transpose();
  const std::int64_t i = 7 * problem.num_cameras();  // camera 0 sees point 7
  EXPECT_NEAR(depths(problem)[i], -3.0, 1e-12);
  const bool projects = reprojection_residuals(problem).row(i).allFinite();
  EXPECT_EQ(projects, GetParam() == CameraModel::BAL);
  EXPECT_GE(statistics(problem).num_behind_camera, 1);
}

TEST(BundleProblem, RefusesArraysThatDisagree) {
  const BundleProblem good = test::small_bundle(CameraModel::RADTAN).problem;
  EXPECT_NO_THROW(good.validate());
  EXPECT_NO_THROW(BundleProblem{}.camera_model);
  BundleProblem bad = good;
  bad.intrinsics.conservativeResize(Eigen::NoChange, 4);
  EXPECT_THROW(bad.validate(), ShapeError);
  bad = good;
  bad.intrinsics.conservativeResize(4, Eigen::NoChange);
  EXPECT_THROW(bad.validate(), ShapeError);
  bad = good;
  bad.camera_index[3] = 5;
  EXPECT_THROW(bad.validate(), ShapeError);
  bad = good;
  bad.point_index.conservativeResize(3);
  EXPECT_THROW(bad.validate(), ShapeError);
}

TEST(BundleProblem, RefusesPosesThatAreNotRigid) {
  const BundleProblem good = test::small_bundle(CameraModel::PINHOLE).problem;
  const auto refuses = [&](auto change) {
    BundleProblem bad = good;
    Eigen::Map<RowMajor<4, 4>> T(bad.T_cw.row(2).data());
    change(T);
    try {
      bad.validate();
    } catch (const ShapeError& error) {
      return std::string(error.what()).find("T_cw[2]") != std::string::npos;
    }
    return false;
  };
  EXPECT_TRUE(refuses([](auto& T) { T(0, 3) = NAN; }));
  EXPECT_TRUE(refuses([](auto& T) { T(0, 0) = NAN; }));
  EXPECT_TRUE(refuses([](auto& T) { T(3, 0) = 1e-9; }));
  EXPECT_TRUE(refuses([](auto& T) { T.template topLeftCorner<3, 3>() *= 1.001; }));
  EXPECT_TRUE(refuses([](auto& T) { T.row(2) *= -1.0; }));  // a reflection
  BundleProblem rounded = good;
  rounded.T_cw = rounded.T_cw.cast<float>().cast<double>();
  EXPECT_NO_THROW(rounded.validate());
}

TEST(BundleProblem, ComesFromABalProblemWithTheSameCostAndGoesBack) {
  const BalProblem bal = test::small_problem();
  for (const CameraModel model : {CameraModel::BAL, CameraModel::RADTAN}) {
    const BundleProblem problem = to_bundle_problem(bal, model);
    EXPECT_NEAR(reprojection_cost(problem), reprojection_cost(bal), 1e-12 * reprojection_cost(bal));
    EXPECT_TRUE(test::is_near(depths(problem), depths(bal), 1e-13));
    EXPECT_TRUE(test::is_near(camera_centers(problem), camera_centers(bal), 1e-13));
    const BalProblem back = to_bal_problem(problem);
    EXPECT_TRUE(test::is_near(back.cameras, bal.cameras, 1e-14));
    EXPECT_EQ(back.observations, bal.observations);
    EXPECT_EQ(back.points, bal.points);
  }
}

TEST(BundleProblem, SubtractsThePrincipalPointOnTheWayToBal) {
  BundleProblem problem = to_bundle_problem(test::small_problem(), CameraModel::RADTAN);
  const double cost = reprojection_cost(problem);
  problem.intrinsics.col(2).setConstant(320.0);
  problem.intrinsics.col(3).setConstant(240.0);
  problem.observations.rowwise() += Eigen::RowVector2d(320.0, 240.0);
  EXPECT_NEAR(reprojection_cost(problem), cost, 1e-10 * cost);
  EXPECT_NEAR(reprojection_cost(to_bal_problem(problem)), cost, 1e-10 * cost);
}

TEST(BundleProblem, RefusesConversionsThatWouldChangeTheCamera) {
  EXPECT_THROW(to_bundle_problem(test::small_problem(), CameraModel::PINHOLE), OptionsError);
  BalProblem plain = test::small_problem();
  plain.cameras.rightCols<2>().setZero();
  EXPECT_NEAR(reprojection_cost(to_bundle_problem(plain, CameraModel::PINHOLE)),
              reprojection_cost(plain), 1e-12 * reprojection_cost(plain));
  BundleProblem problem = to_bundle_problem(plain, CameraModel::RADTAN);
  problem.intrinsics(3, 1) += 1.0;
  EXPECT_THROW(to_bal_problem(problem), OptionsError);
  problem = to_bundle_problem(plain, CameraModel::RADTAN);
  problem.intrinsics(1, 8) = 1e-9;
  EXPECT_THROW(to_bal_problem(problem), OptionsError);
}

}  // namespace
}  // namespace raylign
