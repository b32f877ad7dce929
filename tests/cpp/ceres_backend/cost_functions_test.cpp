// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/cost_functions.h"

#include <ceres/autodiff_cost_function.h>
#include <ceres/rotation.h>
#include <gtest/gtest.h>

#include <memory>
#include <vector>

#include "camera/cameras.h"
#include "raylign/geometry/se3.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"

// Hand-written Jacobians against Ceres' automatic differentiation of the same residual written a
// second time, for every parametrisation, at 1000 states of every awkward kind.
namespace raylign::ceres_backend {
namespace {

constexpr int kNumStates = 1000;

template <int Size, typename T>
void transform(const T* pose, const T x_bar[3], const T& w, T p_c[3]) {
  const T* t = pose + Size - 3;
  if constexpr (Size == 6) {
    ceres::AngleAxisRotatePoint(pose, x_bar, p_c);
  } else {
    const T wxyz[4] = {pose[3], pose[0], pose[1], pose[2]};
    ceres::QuaternionRotatePoint(wxyz, x_bar, p_c);  // normalises first
  }
  for (int k = 0; k < 3; ++k) p_c[k] += w * t[k];
}

template <typename Camera, typename T>
void project(const T* intrinsics, const T* p_c, const Vector2& observed, T* residual) {
  test::plain_project(Camera(typename Camera::Params(Camera::Params::Ones())), intrinsics, p_c,
                      residual);
  residual[0] -= observed[0];
  residual[1] -= observed[1];
}

// Homogeneous points are tested in a frame that is neither centred nor of unit scale.
const HomogeneousFrame kFrame{Vector3(1.0, -2.0, 0.5), 3.0};

template <typename Camera, int PoseSize, int PointSize>
struct ReprojectionFunctor {
  Vector2 observed;
  template <typename T>
  bool operator()(const T* pose, const T* intrinsics, const T* point, T* residual) const {
    const T w = PointSize == 4 ? point[PointSize - 1] : T(1.0);
    T x_bar[3];
    for (int k = 0; k < 3; ++k) {
      x_bar[k] = PointSize == 4 ? kFrame.scale * point[k] + kFrame.center[k] * w : point[k];
    }
    T p_c[3];
    transform<PoseSize>(pose, x_bar, w, p_c);
    project<Camera>(intrinsics, p_c, observed, residual);
    return true;
  }
};

template <typename Camera, int PoseSize>
struct InverseDepthFunctor {
  Vector2 observed;
  template <typename T>
  bool operator()(
      const T* pose, const T* intrinsics, const T* point, const T* host, T* residual) const {
    const T* t_h = host + PoseSize - 3;
    const T s[3] = {point[0] - point[2] * t_h[0], point[1] - point[2] * t_h[1],
                    T(Camera::kViewZ) - point[2] * t_h[2]};
    T inverse_host[PoseSize];  // R_hᵀ
    for (int k = 0; k < PoseSize; ++k) inverse_host[k] = T(0.0);
    for (int k = 0; k < 3; ++k) inverse_host[k] = -host[k];
    if constexpr (PoseSize == 7) inverse_host[3] = host[3];
    T x_bar[3];
    transform<PoseSize>(inverse_host, s, T(0.0), x_bar);
    T p_c[3];
    transform<PoseSize>(pose, x_bar, point[2], p_c);
    project<Camera>(intrinsics, p_c, observed, residual);
    return true;
  }
};

template <typename Camera>
struct InverseDepthHostFunctor {
  Vector2 observed;
  template <typename T>
  bool operator()(const T* intrinsics, const T* point, T* residual) const {
    const T p_c[3] = {point[0], point[1], T(Camera::kViewZ)};
    project<Camera>(intrinsics, p_c, observed, residual);
    return true;
  }
};

// Rotation angles: ordinary, tiny, zero, just below π.
Vector3 random_rotation(test::NamedRng& rng, int index) {
  const Vector3 axis = rng.unit_vector<3>();
  switch (index % 5) {
    case 0:
      return 1e-9 * axis;
    case 1:
      return Vector3::Zero();
    case 2:
      return (M_PI - 1e-7) * axis;
    default:
      return rng.uniform(0.0, 3.0) * axis;
  }
}

// Distortion that grows for ever: no state lies beyond a fold.
BalCamera::Params random_params(test::NamedRng& rng, CameraType<BalCamera> /*type*/) {
  return {rng.uniform(200, 1500), rng.normal(0.2), rng.normal(0.1)};
}

PinholeCamera::Params random_params(test::NamedRng& rng, CameraType<PinholeCamera> /*type*/) {
  return {rng.uniform(200, 1500), rng.uniform(200, 1500), rng.normal(400), rng.normal(300)};
}

RadtanCamera::Params random_params(test::NamedRng& rng, CameraType<RadtanCamera> /*type*/) {
  RadtanCamera::Params params;
  params << random_params(rng, CameraType<PinholeCamera>{}), std::abs(rng.normal(0.2)),
      std::abs(rng.normal(0.1)), rng.normal(0.01), rng.normal(0.01), std::abs(rng.normal(0.01));
  return params;
}

template <typename Camera>
struct State {
  Vector3 omega, t, omega_h, t_h, p_c;
  typename Camera::Params intrinsics;
  Vector2 observed;

  std::vector<double> intrinsics_block() const {
    return {intrinsics.data(), intrinsics.data() + Camera::kNumParams};
  }
  Vector3 world_point() const { return so3_exp(omega).transpose() * (p_c - t); }
};

template <typename Camera>
State<Camera> random_state(int index) {
  auto rng = test::make_rng("cost functions", index);
  State<Camera> s;
  s.omega = random_rotation(rng, index);
  s.omega_h = random_rotation(rng, index / 5);
  s.t = rng.normal_vector<3>(2.0);
  s.t_h = rng.normal_vector<3>(2.0);
  s.intrinsics = random_params(rng, CameraType<Camera>{});
  // every fourth point lies behind a BAL camera, whose cost has no cheirality test
  const bool behind = Camera::kViewZ < 0.0 && index % 4 == 0;
  const double z = rng.uniform(0.5, 30.0) * (behind ? -Camera::kViewZ : Camera::kViewZ);
  s.p_c = {rng.normal(1.0), rng.normal(1.0), z};
  s.observed = rng.normal_vector<2>(300.0);
  return s;
}

template <typename Pose>
std::vector<double> pose_block(const Vector3& omega, const Vector3& t) {
  std::vector<double> block(Pose::kSize);
  Pose::from_angle_axis(omega, t, block.data());
  return block;
}

// Evaluates both and compares residuals and every Jacobian block, each relative to its largest
// entry.
void expect_equal(const ceres::CostFunction& ours,
                  const ceres::CostFunction& autodiff,
                  const std::vector<std::vector<double>>& blocks,
                  int index) {
  std::vector<const double*> x;
  std::vector<std::vector<double>> J_ours, J_auto;
  std::vector<double*> p_ours, p_auto;
  for (const auto& block : blocks) {
    x.push_back(block.data());
    J_ours.emplace_back(2 * block.size());
    J_auto.emplace_back(2 * block.size());
  }
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    p_ours.push_back(J_ours[i].data());
    p_auto.push_back(J_auto[i].data());
  }
  Vector2 r_ours, r_auto, r_only;
  ASSERT_TRUE(ours.Evaluate(x.data(), r_ours.data(), p_ours.data()));
  ASSERT_TRUE(autodiff.Evaluate(x.data(), r_auto.data(), p_auto.data()));
  ASSERT_TRUE(ours.Evaluate(x.data(), r_only.data(), nullptr));
  EXPECT_EQ(r_ours, r_only);
  EXPECT_TRUE(test::is_near(r_ours, r_auto, 1e-11)) << "state " << index;
  for (std::size_t i = 0; i < blocks.size(); ++i) {
    const Eigen::Map<const Eigen::VectorXd> a(J_ours[i].data(), J_ours[i].size());
    const Eigen::Map<const Eigen::VectorXd> b(J_auto[i].data(), J_auto[i].size());
    EXPECT_TRUE(test::is_near(a, b, 1e-8)) << "state " << index << ", block " << i;
  }
}

template <typename C, typename P>
struct Models {
  using Camera = C;
  using Pose = P;
};

template <typename M>
class CostFunctions : public testing::Test {};
using AllModels = testing::Types<Models<BalCamera, QuaternionPose>,
                                 Models<BalCamera, AngleAxisPose>,
                                 Models<PinholeCamera, QuaternionPose>,
                                 Models<PinholeCamera, AngleAxisPose>,
                                 Models<RadtanCamera, QuaternionPose>,
                                 Models<RadtanCamera, AngleAxisPose>>;
TYPED_TEST_SUITE(CostFunctions, AllModels);

TYPED_TEST(CostFunctions, XyzJacobiansEqualAutodiff) {
  using Camera = typename TypeParam::Camera;
  using Pose = typename TypeParam::Pose;
  using Functor = ReprojectionFunctor<Camera, Pose::kSize, 3>;
  for (int i = 0; i < kNumStates; ++i) {
    const auto s = random_state<Camera>(i);
    const Vector3 x = s.world_point();
    const ReprojectionCost<Camera, Pose, XyzPoint> ours(s.observed);
    const ceres::AutoDiffCostFunction<Functor, 2, Pose::kSize, Camera::kNumParams, 3> autodiff(
        new Functor{s.observed});
    expect_equal(ours, autodiff,
                 {pose_block<Pose>(s.omega, s.t), s.intrinsics_block(), {x.data(), x.data() + 3}},
                 i);
  }
}

TYPED_TEST(CostFunctions, HomogeneousJacobiansEqualAutodiff) {
  using Camera = typename TypeParam::Camera;
  using Pose = typename TypeParam::Pose;
  using Functor = ReprojectionFunctor<Camera, Pose::kSize, 4>;
  for (int i = 0; i < kNumStates; ++i) {
    const auto s = random_state<Camera>(i);
    // every seventh point lies beyond infinity, every seventh at infinity
    const double w = i % 7 == 0 ? -0.4 : i % 7 == 1 ? 0.0 : 1.0;
    const Vector3 x_bar = so3_exp(s.omega).transpose() * (s.p_c - w * s.t);
    Vector4 x;
    x << (x_bar - w * kFrame.center) / kFrame.scale, w;
    x.normalize();
    const ReprojectionCost<Camera, Pose, HomogeneousPoint> ours(s.observed,
                                                                HomogeneousPoint(kFrame));
    const ceres::AutoDiffCostFunction<Functor, 2, Pose::kSize, Camera::kNumParams, 4> autodiff(
        new Functor{s.observed});
    expect_equal(ours, autodiff,
                 {pose_block<Pose>(s.omega, s.t), s.intrinsics_block(), {x.data(), x.data() + 4}},
                 i);
  }
}

TYPED_TEST(CostFunctions, InverseDepthJacobiansEqualAutodiff) {
  using Camera = typename TypeParam::Camera;
  using Pose = typename TypeParam::Pose;
  using Functor = InverseDepthFunctor<Camera, Pose::kSize>;
  for (int i = 0; i < kNumStates; ++i) {
    auto s = random_state<Camera>(i);
    const Vector3 rotated = so3_exp(s.omega_h) * s.world_point();
    s.t_h.z() = 2.0 * Camera::kViewZ - rotated.z();  // in front of the host
    const Vector3 p_h = rotated + s.t_h;
    const double rho = Camera::kViewZ / p_h.z();
    const InverseDepthCost<Camera, Pose> ours(s.observed);
    const ceres::AutoDiffCostFunction<Functor, 2, Pose::kSize, Camera::kNumParams, 3, Pose::kSize>
        autodiff(new Functor{s.observed});
    expect_equal(ours, autodiff,
                 {pose_block<Pose>(s.omega, s.t),
                  s.intrinsics_block(),
                  {rho * p_h.x(), rho * p_h.y(), rho},
                  pose_block<Pose>(s.omega_h, s.t_h)},
                 i);
  }
}

TYPED_TEST(CostFunctions, InverseDepthHostJacobiansEqualAutodiff) {
  using Camera = typename TypeParam::Camera;
  using Functor = InverseDepthHostFunctor<Camera>;
  for (int i = 0; i < kNumStates; ++i) {
    const auto s = random_state<Camera>(i);
    const double rho = Camera::kViewZ / s.p_c.z();
    const InverseDepthHostCost<Camera> ours(s.observed);
    const ceres::AutoDiffCostFunction<Functor, 2, Camera::kNumParams, 3> autodiff(
        new Functor{s.observed});
    expect_equal(ours, autodiff, {s.intrinsics_block(), {rho * s.p_c.x(), rho * s.p_c.y(), rho}},
                 i);
  }
}

}  // namespace
}  // namespace raylign::ceres_backend
