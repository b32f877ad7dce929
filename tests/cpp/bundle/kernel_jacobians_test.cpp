// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What the vector kernels linearise, against automatic and numeric differentiation of the residual
// written a second time, along the canonical tangent, at 1000 states of every awkward kind.
#include <ceres/jet.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <vector>

#include "camera/cameras.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/geometry/so3.h"
#include "raylign/parametrization/homogeneous.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign::native {
namespace {

constexpr int kNumStates = 1000;
constexpr int kNumColumns = 12;  // [ω; δc; three intrinsics; point]
using Rows12 = Eigen::Matrix<double, 2, kNumColumns>;
using Vector12 = Eigen::Matrix<double, kNumColumns, 1>;
using Block9 = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;

template <typename C, CameraModel kModel, CameraKind kCamera, PointKind kPoint>
struct Case {
  using Camera = C;
  static constexpr CameraModel model = kModel;
  static constexpr CameraKind camera_kind = kCamera;
  static constexpr PointKind point_kind = kPoint;
};

// Angles: tiny, zero, just below π, ordinary.
Vector3 random_rotation(test::NamedRng& rng, int index) {
  const Vector3 axis = rng.unit_vector<3>();
  const std::array<double, 5> angles = {1e-9, 0.0, M_PI - 1e-7, rng.uniform(0.0, 3.0), 1.0};
  return angles[index % 5] * axis;
}

// Points close to the plane of their camera.
bool is_grazing(int index) { return index % 3 == 1; }

// Ordinary, grazing, far away; behind, for a camera without a test of cheirality.
double random_depth(test::NamedRng& rng, int index, bool may_be_behind) {
  const std::array<double, 3> depths = {rng.uniform(0.5, 30.0), rng.uniform(1e-4, 1e-3), 1e6};
  return may_be_behind && index % 4 == 0 ? -depths[index % 3] : depths[index % 3];
}

// Every sixth camera has a huge distortion. It grows for ever: no state lies beyond a fold.
std::vector<double> random_params(test::NamedRng& rng, CameraModel model, int index) {
  const double f = rng.uniform(200, 1500);
  const double k = index % 6 == 1 ? 50.0 : 0.2;
  if (model == CameraModel::BAL) return {f, rng.normal(k), rng.normal(k)};
  std::vector<double> params = {f, rng.uniform(200, 1500), rng.normal(400), rng.normal(300)};
  if (model == CameraModel::PINHOLE) return params;
  for (const double distortion : {std::abs(rng.normal(k)), std::abs(rng.normal(k)),
                                  rng.normal(0.01), rng.normal(0.01), std::abs(rng.normal(k))}) {
    params.push_back(distortion);
  }
  return params;
}

// State i: camera i sees point i, and nobody else does.
template <typename Case>
struct States {
  using Camera = typename Case::Camera;
  static constexpr int kParams = Camera::kNumParams;
  static constexpr bool kHomogeneous = Case::point_kind == PointKind::HOMOGENEOUS;
  static constexpr int kStride = kHomogeneous ? 4 : 3;

  BundleProblem problem;
  std::vector<Vector4> X;  // XYZ: w = 1
  Constants held;

  States() {
    problem.camera_model = Case::model;
    problem.T_cw.resize(kNumStates, 16);
    problem.intrinsics.resize(kNumStates, kParams);
    problem.points.setZero(kNumStates, 3);
    problem.camera_index.setLinSpaced(kNumStates, 0, kNumStates - 1);
    problem.point_index = problem.camera_index;
    problem.observations.resize(kNumStates, 2);
    for (int i = 0; i < kNumStates; ++i) make_state(i);
    held = resolve_constants(problem, {});
    for (int i = 0; i < kNumStates; ++i) {
      held.intrinsics[i].fill(true);
      for (const int k : columns(i)) held.intrinsics[i][k] = false;
    }
  }

  void make_state(int i) {
    auto rng = test::make_rng("kernel jacobians", i);
    const Matrix3 R = so3_exp(random_rotation(rng, i));
    const Vector3 t = rng.normal_vector<3>(2.0);
    Eigen::Map<RowMajor<4, 4>> T(problem.T_cw.row(i).data());
    T << R, t, 0.0, 0.0, 0.0, 1.0;
    const std::vector<double> params = random_params(rng, Case::model, i);
    std::copy(params.begin(), params.end(), problem.intrinsics.row(i).data());
    const double z = Camera::kViewZ * random_depth(rng, i, Case::model == CameraModel::BAL);
    const double side = is_grazing(i) ? 0.05 : 0.5 * std::abs(z);
    const auto lateral = [&] { return side * std::copysign(rng.uniform(0.2, 2.0), rng.normal()); };
    const double x_c = lateral();
    const Vector3 P(x_c, lateral(), z);
    // every seventh homogeneous point lies beyond infinity, every seventh at infinity
    const double w = !kHomogeneous ? 1.0 : i % 7 == 0 ? -0.4 : i % 7 == 1 ? 0.0 : 1.0;
    Vector4 x;
    x << R.transpose() * (P - w * t), w;
    X.push_back(kHomogeneous ? Vector4(x.normalized()) : x);
    problem.points.row(i) = x.head<3>().transpose();
    problem.observations.row(i) = rng.normal_vector<2>(300.0).transpose();
  }

  // Parameters that move: BAL's three, or any three.
  static std::array<int, 3> columns(int i) {
    if (kParams == 3) return {0, 1, 2};
    std::array<int, 3> out = {i % kParams, (i + 1) % kParams, (i + 2) % kParams};
    std::sort(out.begin(), out.end());
    return out;
  }

  /// r of state i moved by d, from the numbers of the kernel's packet.
  template <typename T>
  std::array<T, 2> residual(int i, const CameraPacket& packet, const T* d) const {
    T moved[4];  // of the point
    for (int k = 0; k < kStride; ++k) {
      moved[k] = T(X[i][k]);
      if (!kHomogeneous) moved[k] += d[9 + k];
    }
    if (kHomogeneous) {  // to first order on the sphere: its tangent has a test of its own
      const RowMajor<4, 3> B = SphereTangent(X[i]).basis();
      for (int k = 0; k < 4; ++k) {
        for (int m = 0; m < 3; ++m) moved[k] += B(k, m) * d[9 + m];
      }
    }
    const T w = kHomogeneous ? moved[3] : T(1.0);
    const T c[3] = {packet.c[0] + d[3], packet.c[1] + d[4], packet.c[2] + d[5]};
    const T a[3] = {moved[0] - w * c[0], moved[1] - w * c[1], moved[2] - w * c[2]};
    T turned[3];
    ceres::AngleAxisRotatePoint(d, a, turned);
    T P[3];
    for (int row = 0; row < 3; ++row) {
      const double* R = packet.R + 3 * row;
      P[row] = R[0] * turned[0] + R[1] * turned[1] + R[2] * turned[2];
    }
    T params[kParams];
    for (int k = 0; k < kParams; ++k) params[k] = T(packet.intrinsics[k]);
    for (int k = 0; k < 3; ++k) params[columns(i)[k]] += d[6 + k];
    std::array<T, 2> r;
    test::plain_project(Camera(typename Camera::Params(Camera::Params::Ones())), params, P,
                        r.data());
    for (int k = 0; k < 2; ++k) r[k] -= problem.observations(i, k);
    return r;
  }

  Rows12 autodiff(int i, const CameraPacket& packet) const {
    using Jet = ceres::Jet<double, kNumColumns>;
    Jet d[kNumColumns];
    for (int k = 0; k < kNumColumns; ++k) d[k] = Jet(0.0, k);
    const std::array<Jet, 2> r = residual(i, packet, d);
    Rows12 J;
    J << r[0].v.transpose(), r[1].v.transpose();
    return J;
  }

  // Steps in fractions of the depth, across which the residual is smooth.
  Rows12 numeric(int i, const CameraPacket& packet) const {
    const double w = std::abs(X[i][3]);
    const Vector3 a = X[i].head<3>() - X[i][3] * Eigen::Map<const Vector3>(packet.c);
    const double z = std::abs(Eigen::Map<const RowMajor<3, 3>>(packet.R).row(2).dot(a));
    Vector12 units = Vector12::Ones();
    units.head<3>().setConstant(z / a.norm());
    if (w > 0.0) units.segment<3>(3).setConstant(z / w);
    units.tail<3>().setConstant(z);
    const auto moved = [&](const Vector12& d) {
      const Vector12 step = units.cwiseProduct(d);
      const std::array<double, 2> r = residual(i, packet, step.data());
      return Vector2(r[0], r[1]);
    };
    const Vector12 zero = Vector12::Zero();
    const Rows12 J = test::numeric_jacobian(moved, zero, 0.03);
    return J * units.cwiseInverse().asDiagonal();
  }
};

template <typename Case>
class KernelJacobians : public testing::Test {
 protected:
  using Camera = typename Case::Camera;

  const States<Case> states_;
  const Layout layout_{states_.problem, Case::point_kind};
  const CameraBlocks cameras_{states_.problem, PoseParametrization::SE3, states_.held,
                              layout_.observed};
  std::vector<ObservationJacobian> J_{kNumStates};
  std::vector<LandmarkBlock> blocks_{kNumStates};
  std::vector<CameraSums> sums_{kNumStates, CameraSums{}};

  void linearize_by(Linearize* body) {
    std::fill(sums_.begin(), sums_.end(), CameraSums{});
    std::vector<double> X;
    for (const std::int32_t p : layout_.points) {
      X.insert(X.end(), states_.X[p].data(), states_.X[p].data() + States<Case>::kStride);
    }
    std::vector<CameraRows> scratch(layout_.max_window());
    body({layout_.observations(), cameras_.packets(), X.data(), nullptr}, 0, layout_.num_windows(),
         {{J_.data(), nullptr}, blocks_.data(), sums_.data(), 0, scratch.data()});
  }

  // `H` = JᵀJ, entry by entry in the units of its columns.
  template <typename Matrix, typename Jacobian>
  static void expect_gram(const Matrix& H, const Jacobian& J, int i) {
    const Eigen::VectorXd norm = J.colwise().norm().transpose();
    const Eigen::VectorXd scale = norm.unaryExpr([](double n) { return n > 0.0 ? 1.0 / n : 1.0; });
    const auto S = scale.asDiagonal();
    EXPECT_TRUE(test::is_near(S * H * S, S * (J.transpose() * J) * S, 1e-8)) << "state " << i;
  }

  void expect_derivatives(bool numeric) const {
    for (std::int64_t j = 0; j < kNumStates; ++j) {
      const int i = layout_.points[j];
      if (numeric && is_grazing(i)) continue;  // its pixel has no digits left for a difference
      const CameraPacket& packet = cameras_.packets()[i];
      const Rows12 J = numeric ? states_.numeric(i, packet) : states_.autodiff(i, packet);
      const Eigen::Map<const RowMajor<2, 3>> I(J_[j].I);
      for (int k = 0; k < 3; ++k) {
        EXPECT_TRUE(test::is_relatively_near(I.col(k), J.col(6 + k), 1e-8)) << "state " << i;
      }
      if (Case::point_kind == PointKind::XYZ) {
        const Eigen::Map<const RowMajor<2, 3>> A(J_[j].A);
        EXPECT_TRUE(test::is_relatively_near(A, J.rightCols<3>(), 1e-8)) << "state " << i;
      }
      expect_gram(Block9(sums_[i].U.values).leftCols<9>(), J.leftCols<9>(), i);
      const double* h = blocks_[j].H;
      Matrix3 H;
      H << h[0], h[1], h[2], h[1], h[3], h[4], h[2], h[4], h[5];
      expect_gram(H, J.rightCols<3>(), i);
    }
  }
};

using Cases = testing::Types<
    Case<BalCamera, CameraModel::BAL, CameraKind::BAL, PointKind::XYZ>,
    Case<BalCamera, CameraModel::BAL, CameraKind::BAL, PointKind::HOMOGENEOUS>,
    Case<PinholeCamera, CameraModel::PINHOLE, CameraKind::PINHOLE, PointKind::XYZ>,
    Case<PinholeCamera, CameraModel::PINHOLE, CameraKind::PINHOLE, PointKind::HOMOGENEOUS>,
    Case<RadtanCamera, CameraModel::RADTAN, CameraKind::RADTAN, PointKind::XYZ>,
    Case<RadtanCamera, CameraModel::RADTAN, CameraKind::RADTAN, PointKind::HOMOGENEOUS>>;
TYPED_TEST_SUITE(KernelJacobians, Cases);

TYPED_TEST(KernelJacobians, EqualAutomaticDifferentiation) {
  this->linearize_by(narrow_linearize());
  this->expect_derivatives(false);
  if (wide_linearize() == nullptr) GTEST_SKIP() << "no AVX-512";
  this->linearize_by(wide_linearize());
  this->expect_derivatives(false);
}

TYPED_TEST(KernelJacobians, EqualCentralDifferences) {
  this->linearize_by(linearize);
  this->expect_derivatives(true);
}

}  // namespace
}  // namespace raylign::native
