// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_kinds.h"

#include <gtest/gtest.h>

#include <algorithm>

#include "raylign/geometry/so3.h"
#include "raylign/residuals/reprojection.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/small_bundle.h"

namespace raylign::native {
namespace {

template <typename C, typename K, CameraModel kModel>
struct Pair {
  using Camera = C;
  using Kind = K;
  static constexpr CameraModel model = kModel;
};

template <typename P>
class CameraKinds : public testing::Test {};
using Pairs = testing::Types<Pair<BalCamera, BalKind, CameraModel::BAL>,
                             Pair<PinholeCamera, PinholeKind, CameraModel::PINHOLE>,
                             Pair<RadtanCamera, RadtanKind, CameraModel::RADTAN>>;
TYPED_TEST_SUITE(CameraKinds, Pairs);

template <typename Camera>
CameraPacket packet_of(const Matrix3& R, const typename Camera::Params& params) {
  CameraPacket packet{};
  Eigen::Map<RowMajor<3, 3>>{packet.R} = R;
  std::copy_n(params.data(), Camera::kNumParams, packet.intrinsics);
  if constexpr (Camera::kNumParams == 9) {
    packet.max_radius_squared = Camera(params).distortion().max_radius_squared();
  }
  return packet;
}

// The one definition of the residual is the oracle: in front, behind, in the plane, past the fold.
TYPED_TEST(CameraKinds, AgreeWithTheCameraClass) {
  using Camera = typename TypeParam::Camera;
  const typename TypeParam::Kind kind;
  int num_projected = 0;
  for (int i = 0; i < 1000; ++i) {
    auto rng = test::make_rng("camera kinds", i);
    const typename Camera::Params params = test::small_bundle_params(TypeParam::model, i % 7);
    const Matrix3 R = so3_exp(rng.normal_vector<3>());
    Vector3 P = rng.normal_vector<3>(2.0);
    if (i % 10 == 0) P.z() = 0.0;
    const Vector2 uv = rng.normal_vector<2>(300.0);
    CameraPacket packet = packet_of<Camera>(R, params);
    const std::array<int, 3> columns =
        Camera::kNumParams == 3
            ? std::array<int, 3>{0, 1, 2}
            : std::array<int, 3>{i % Camera::kNumParams, -1, (i + 2) % Camera::kNumParams};
    std::copy(columns.begin(), columns.end(), packet.columns);
    Vector2 expected;
    RowMajor<2, 3> J_p;
    RowMajor<2, Camera::kNumParams> J_params;
    const bool projects = reprojection_residual<Camera>(P, params, uv, expected, &J_p, &J_params);
    typename TypeParam::Kind::template Projection<double> p{};
    ASSERT_EQ(project(kind, packet, P.data(), p), projects) << "state " << i;
    if (!projects) continue;
    ++num_projected;
    Vector2 r;
    ObservationJacobian J;
    residual(kind, packet, p, uv.data(), r.data());
    jacobian(kind, packet, p, J);
    EXPECT_TRUE(test::is_near(r, expected, 1e-12));
    EXPECT_TRUE(test::is_near(Eigen::Map<RowMajor<2, 3>>(J.A), J_p * R, 1e-12));
    for (int k = 0; k < 3; ++k) {
      const Vector2 column = columns[k] < 0 ? Vector2(0.0, 0.0) : Vector2(J_params.col(columns[k]));
      EXPECT_TRUE(test::is_near(Eigen::Map<RowMajor<2, 3>>(J.I).col(k), column, 1e-12));
    }
  }
  EXPECT_GT(num_projected, 300);
  EXPECT_LT(num_projected, 950);
}

}  // namespace
}  // namespace raylign::native
