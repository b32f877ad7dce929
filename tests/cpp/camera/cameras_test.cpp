// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What every camera promises, written once and run on real calibrations.
#include "camera/cameras.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raylign/base/error.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign::test {
namespace {

struct Kitti {
  static PinholeCamera make() { return kitti_camera(); }
};
struct TumFr1 {
  static RadtanCamera make() { return tum_fr1_camera(); }
};
struct Euroc {
  static RadtanCamera make() { return euroc_camera(); }
};
struct Ladybug {
  static BalCamera make() { return ladybug_camera(); }
};
struct WideBal {
  static BalCamera make() { return wide_bal_camera(); }
};

template <typename Calibration>
class CameraTest : public testing::Test {
 protected:
  using Model = decltype(Calibration::make());
  using ModelParams = typename Model::Params;

  const Model camera = Calibration::make();

  // A grid over the image, corners included.
  std::vector<Vector2> pixels() const {
    const PixelRange range = pixel_range(camera);
    std::vector<Vector2> grid;
    for (int i = 0; i <= 12; ++i) {
      for (int j = 0; j <= 12; ++j) {
        grid.emplace_back(range.u_min + i / 12.0 * (range.u_max - range.u_min),
                          range.v_min + j / 12.0 * (range.v_max - range.v_min));
      }
    }
    return grid;
  }

  // Points inside the field of view, 0.1 to 100 units away.
  std::vector<Vector3> points() const {
    std::vector<Vector3> result;
    for (const Vector2& uv : pixels()) {
      Vector3 bearing;
      EXPECT_TRUE(camera.unproject(uv, bearing));
      result.push_back(bearing * std::pow(10.0, -1.0 + 3.0 * (result.size() % 7) / 6.0));
    }
    return result;
  }
};

using Calibrations = testing::Types<Kitti, TumFr1, Euroc, Ladybug, WideBal>;
TYPED_TEST_SUITE(CameraTest, Calibrations);

TYPED_TEST(CameraTest, ProjectInvertsUnproject) {
  for (const Vector2& uv : this->pixels()) {
    Vector3 bearing;
    ASSERT_TRUE(this->camera.unproject(uv, bearing)) << uv.transpose();
    EXPECT_NEAR(bearing.norm(), 1.0, 1e-15);
    EXPECT_TRUE(this->camera.is_in_front(bearing));
    Vector2 back;
    ASSERT_TRUE(this->camera.project(7.5 * bearing, back));
    EXPECT_TRUE(is_near(back, uv, 1e-13));
  }
}

TYPED_TEST(CameraTest, UnprojectInvertsProject) {
  for (const Vector3& p_c : this->points()) {
    Vector2 uv;
    Vector3 bearing;
    ASSERT_TRUE(this->camera.project(p_c, uv));
    ASSERT_TRUE(this->camera.unproject(uv, bearing));
    EXPECT_TRUE(is_near(bearing, p_c.normalized(), 1e-12));
  }
}

TYPED_TEST(CameraTest, ProjectAgreesWithJets) {
  using Camera = typename TestFixture::Model;
  for (const Vector3& p_c : this->points()) {
    Vector2 uv, uv_jet;
    RowMajor<2, 3> J_point, J_point_jet;
    RowMajor<2, Camera::kNumParams> J_params, J_params_jet;
    ASSERT_TRUE(this->camera.project(p_c, uv, &J_point, &J_params));
    jet_project(this->camera, p_c, uv_jet, J_point_jet, J_params_jet);
    EXPECT_LE((uv - uv_jet).norm(), 1e-12);  // u = fx x + cx may cancel
    EXPECT_TRUE(is_near(J_point, J_point_jet, 1e-13));
    EXPECT_TRUE(is_near(J_params, J_params_jet, 1e-13));
  }
}

TYPED_TEST(CameraTest, ProjectJacobiansAgreeWithDifferences) {
  using Camera = typename TestFixture::Model;
  using Params = typename TestFixture::ModelParams;
  const Vector3 p_c = this->points()[17];
  Vector2 uv;
  RowMajor<2, 3> J_point;
  RowMajor<2, Camera::kNumParams> J_params;
  ASSERT_TRUE(this->camera.project(p_c, uv, &J_point, &J_params));
  const auto by_point = [&](const Vector3& p) {
    Vector2 out;
    EXPECT_TRUE(this->camera.project(p, out));
    return out;
  };
  const auto by_params = [&](const Params& params) {
    Vector2 out;
    EXPECT_TRUE(Camera(params).project(p_c, out));
    return out;
  };
  EXPECT_TRUE(is_near(J_point, numeric_jacobian(by_point, p_c, 1e-2 * p_c.norm()), 1e-9));
  EXPECT_TRUE(is_near(J_params, numeric_jacobian(by_params, this->camera.params()), 1e-9));
}

TYPED_TEST(CameraTest, UnprojectJacobiansAgreeWithDifferences) {
  using Camera = typename TestFixture::Model;
  using Params = typename TestFixture::ModelParams;
  for (const std::size_t index : {20u, 45u, 84u, 120u}) {
    const Vector2 uv = this->pixels()[index];
    Vector3 bearing;
    RowMajor<3, 2> J_uv;
    RowMajor<3, Camera::kNumParams> J_params;
    ASSERT_TRUE(this->camera.unproject(uv, bearing, &J_uv, &J_params));
    const auto by_pixel = [&](const Vector2& pixel) {
      Vector3 out;
      EXPECT_TRUE(this->camera.unproject(pixel, out));
      return out;
    };
    const auto by_params = [&](const Params& params) {
      Vector3 out;
      EXPECT_TRUE(Camera(params).unproject(uv, out));
      return out;
    };
    EXPECT_TRUE(is_relatively_near(J_uv, numeric_jacobian(by_pixel, uv, 2.0), 1e-8));
    EXPECT_TRUE(is_near(J_params, numeric_jacobian(by_params, this->camera.params(), 5e-3), 1e-9));
  }
}

TYPED_TEST(CameraTest, JacobiansAreOptionalOneByOne) {
  using Camera = typename TestFixture::Model;
  const Vector3 p_c = this->points()[3];
  Vector2 uv;
  RowMajor<2, 3> J_point, J_point_only;
  RowMajor<2, Camera::kNumParams> J_params, J_params_only;
  ASSERT_TRUE(this->camera.project(p_c, uv, &J_point, &J_params));
  ASSERT_TRUE(this->camera.project(p_c, uv, &J_point_only));
  ASSERT_TRUE(this->camera.project(p_c, uv, nullptr, &J_params_only));
  EXPECT_EQ(J_point, J_point_only);
  EXPECT_EQ(J_params, J_params_only);
}

TYPED_TEST(CameraTest, HasNoProjectionOnItsPlaneOrForNan) {
  const double nan = std::numeric_limits<double>::quiet_NaN();
  Vector2 uv;
  Vector3 bearing;
  EXPECT_FALSE(this->camera.project(Vector3(1.0, 2.0, 0.0), uv));
  EXPECT_FALSE(this->camera.project(Vector3(1.0, 2.0, 1e-13), uv));
  EXPECT_FALSE(this->camera.project(Vector3(1.0, 2.0, nan), uv));
  EXPECT_FALSE(this->camera.project(Vector3(nan, 2.0, this->points()[0].z()), uv));
  EXPECT_FALSE(this->camera.project(Vector3(1e308, 1e308, 1e-3), uv));
  EXPECT_FALSE(this->camera.unproject(Vector2(nan, 0.0), bearing));
  EXPECT_FALSE(
      this->camera.unproject(Vector2(std::numeric_limits<double>::infinity(), 0.0), bearing));
}

TYPED_TEST(CameraTest, PointsBehind) {
  const double sign = viewing_sign(this->camera);
  Vector2 uv;
  for (const Vector3& p_c : this->points()) {
    EXPECT_GT(sign * p_c.z(), 0.0);
    EXPECT_TRUE(this->camera.is_in_front(p_c));
    EXPECT_FALSE(this->camera.is_in_front(-p_c));
    // BAL has no cheirality test: the point and its mirror image through the centre are one pixel.
    EXPECT_EQ(this->camera.project(-p_c, uv), sign < 0.0);
  }
}

TYPED_TEST(CameraTest, ValidateNamesTheParameter) {
  using Camera = typename TestFixture::Model;
  EXPECT_NO_THROW(this->camera.validate());
  for (int i = 0; i < Camera::kNumParams; ++i) {
    typename TestFixture::ModelParams params = this->camera.params();
    params[i] = std::numeric_limits<double>::infinity();
    EXPECT_THROW(Camera(params).validate(), OptionsError) << i;
  }
  typename TestFixture::ModelParams params = this->camera.params();
  params[0] = -1.0;
  EXPECT_THROW(Camera(params).validate(), OptionsError);
}

TEST(BalCamera, LooksAlongMinusZWithVUp) {
  Vector2 uv;
  ASSERT_TRUE(BalCamera(100.0, 0.0, 0.0).project(Vector3(1.0, 2.0, -4.0), uv));
  EXPECT_EQ(uv, Vector2(25.0, 50.0));
}

TEST(BalCamera, MirroredPointIsTheSamePixel) {
  Vector2 uv, uv_behind;
  const Vector3 p_c(0.3, -0.2, -1.1);
  ASSERT_TRUE(wide_bal_camera().project(p_c, uv));
  ASSERT_TRUE(wide_bal_camera().project(-p_c, uv_behind));
  EXPECT_EQ(uv, uv_behind);
}

TEST(BalCamera, JacobiansHoldBehindTheCamera) {
  const Vector3 p_c(0.7, 0.4, 1.9);
  Vector2 uv, uv_jet;
  RowMajor<2, 3> J_point, J_point_jet, J_params, J_params_jet;
  ASSERT_TRUE(wide_bal_camera().project(p_c, uv, &J_point, &J_params));
  jet_project(wide_bal_camera(), p_c, uv_jet, J_point_jet, J_params_jet);
  EXPECT_TRUE(is_near(J_point, J_point_jet, 1e-14));
  EXPECT_TRUE(is_near(J_params, J_params_jet, 1e-14));
}

}  // namespace
}  // namespace raylign::test
