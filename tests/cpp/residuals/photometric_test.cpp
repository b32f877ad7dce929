// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/residuals/photometric.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/geometry/se3.h"
#include "raylign/geometry/sim3.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"
#include "support/numeric_jacobian.h"

namespace raylign {
namespace {

using test::is_near;

// A sum of sines: what bilinear interpolation is to it does not enter, only the geometry does.
struct AnalyticImage {
  double ku, kv, mu, mv;

  double value(double u, double v) const {
    return 100.0 + 40.0 * std::sin(ku * u + kv * v) + 30.0 * std::cos(mu * u - mv * v);
  }
  double du(double u, double v) const {
    return 40.0 * ku * std::cos(ku * u + kv * v) - 30.0 * mu * std::sin(mu * u - mv * v);
  }
  double dv(double u, double v) const {
    return 40.0 * kv * std::cos(ku * u + kv * v) + 30.0 * mv * std::sin(mu * u - mv * v);
  }
};

struct Case {
  Matrix4 T;
  double fx, fy, cx, cy;
  double ray_x, ray_y, D;
  double gain, b;
  AnalyticImage image;

  WarpPose<double> pose(const Matrix4& M) const {
    WarpPose<double> p = {{}, {}, fx, fy, cx, cy};
    for (int row = 0; row < 3; ++row) {
      for (int k = 0; k < 3; ++k) p.R[3 * row + k] = M(row, k);
      p.t[row] = M(row, 3);
    }
    return p;
  }
  WarpedPoint<double> warped(const Matrix4& M, double depth) const {
    return warp(ray_x, ray_y, depth, pose(M));
  }
  double residual(const Matrix4& M, double depth) const {
    const WarpedPoint<double> p = warped(M, depth);
    return photometric_residual(70.0, image.value(p.u, p.v), gain, b);
  }
  // The image stands in for a map of inverse depth.
  double depth_term(const Matrix4& M, double depth) const {
    const WarpedPoint<double> p = warped(M, depth);
    return depth_residual(p, 1e-3 * image.value(p.u, p.v));
  }
};

// Twists from zero to nearly half a turn, Sim(3) scale on every third.
Case random_case(int index) {
  auto rng = test::make_rng("photometric", static_cast<std::uint64_t>(index));
  const double angle = index % 5 == 0 ? 0.0 : 3.1 * std::pow(10.0, -rng.uniform(0.0, 6.0));
  Case c;
  Vector7 xi;
  xi << rng.normal_vector<3>(0.3), angle * rng.unit_vector<3>(),
      index % 3 == 0 ? rng.normal(0.3) : 0;
  c.T = sim3_exp(xi);
  c.fx = rng.uniform(200, 800);
  c.fy = rng.uniform(200, 800);
  c.cx = rng.uniform(100, 400);
  c.cy = rng.uniform(100, 400);
  c.ray_x = rng.uniform(-0.6, 0.6);
  c.ray_y = rng.uniform(-0.5, 0.5);
  c.D = rng.uniform(0.1, 2.0);
  // turned away from the point: turn back
  if (!(c.warped(c.T, c.D).inverse_q > 0.2 && c.warped(c.T, c.D).inverse_q < 5.0)) {
    c.T.topLeftCorner<3, 3>() = Matrix3::Identity();
    c.T.topRightCorner<3, 1>() *= 0.1;
  }
  c.gain = rng.uniform(0.7, 1.4);
  c.b = rng.normal(10.0);
  c.image = {rng.uniform(0.01, 0.05), rng.uniform(0.01, 0.05), rng.uniform(0.01, 0.04),
             rng.uniform(0.01, 0.04)};
  return c;
}

constexpr int kNumCases = 200;
using Vector1 = Eigen::Matrix<double, 1, 1>;

// 1e-6 relative to the largest entry, per case.
bool agrees(const Eigen::MatrixXd& a, const Eigen::MatrixXd& numeric) {
  return (a - numeric).cwiseAbs().maxCoeff() <=
         1e-6 * std::max(1e-3, numeric.cwiseAbs().maxCoeff());
}

TEST(Photometric, JacobianAgreesWithNumericOne) {
  for (int i = 0; i < kNumCases; ++i) {
    const Case c = random_case(i);
    const WarpedPoint<double> p = c.warped(c.T, c.D);
    RowMajor<1, 7> J = RowMajor<1, 7>::Zero();
    photometric_jacobian(p, c.pose(c.T), c.gain * c.image.du(p.u, p.v),
                         c.gain * c.image.dv(p.u, p.v), J.data());
    const auto f = [&](const Vector7& xi) { return Vector1(c.residual(sim3_exp(xi) * c.T, c.D)); };
    EXPECT_TRUE(agrees(J, test::numeric_jacobian(f, Vector7(Vector7::Zero()), 1e-3))) << i;
  }
}

TEST(Photometric, InverseDepthDerivativeAgreesWithNumericOne) {
  for (int i = 0; i < kNumCases; ++i) {
    const Case c = random_case(i);
    const WarpedPoint<double> p = c.warped(c.T, c.D);
    const Vector1 d(photometric_d_inverse_depth(epipolar_step(p, c.pose(c.T)),
                                                c.gain * c.image.du(p.u, p.v),
                                                c.gain * c.image.dv(p.u, p.v)));
    const auto f = [&](const Vector1& D) { return Vector1(c.residual(c.T, D[0])); };
    EXPECT_TRUE(agrees(d, test::numeric_jacobian(f, Vector1(c.D), 1e-2 * c.D))) << i;
  }
}

TEST(Photometric, DepthDerivativesAgreeWithNumericOnes) {
  for (int i = 0; i < kNumCases; ++i) {
    const Case c = random_case(i);
    const WarpedPoint<double> p = c.warped(c.T, c.D);
    const double d_u = 1e-3 * c.image.du(p.u, p.v);
    const double d_v = 1e-3 * c.image.dv(p.u, p.v);
    RowMajor<1, 7> J;
    depth_jacobian(p, c.pose(c.T), d_u, d_v, J.data());
    const auto of_pose = [&](const Vector7& xi) {
      return Vector1(c.depth_term(sim3_exp(xi) * c.T, c.D));
    };
    EXPECT_TRUE(agrees(J, test::numeric_jacobian(of_pose, Vector7(Vector7::Zero()), 1e-3))) << i;
    const Vector1 d(depth_d_inverse_depth(p, c.pose(c.T), epipolar_step(p, c.pose(c.T)), d_u, d_v));
    const auto of_depth = [&](const Vector1& D) { return Vector1(c.depth_term(c.T, D[0])); };
    EXPECT_TRUE(agrees(d, test::numeric_jacobian(of_depth, Vector1(c.D), 1e-2 * c.D))) << i;
  }
}

// Depth noise acts along the epipolar line only (figure 4 of the paper): a rotation has none.
TEST(Photometric, RotationDoesNotPropagateDepthNoise) {
  Case c = random_case(1);
  c.T.topRightCorner<3, 1>().setZero();
  const EpipolarStep<double> step = epipolar_step(c.warped(c.T, c.D), c.pose(c.T));
  EXPECT_EQ(step.u, 0.0);
  EXPECT_EQ(step.v, 0.0);
}

TEST(Photometric, PointAtInfinityMovesWithRotationOnly) {
  Case c = random_case(2);
  const WarpedPoint<double> p = c.warped(c.T, 0.0);
  Matrix4 turned = c.T;
  turned.topRightCorner<3, 1>().setZero();
  const WarpedPoint<double> q = c.warped(turned, 1.0);
  EXPECT_NEAR(p.u, q.u, 1e-9);
  EXPECT_NEAR(p.v, q.v, 1e-9);
  EXPECT_EQ(p.inverse_z, 0.0);
}

TEST(Photometric, BilinearNoiseFactorAveragesToFourNinths) {
  constexpr int kSteps = 400;
  double sum = 0.0;
  for (int i = 0; i < kSteps; ++i) {
    for (int j = 0; j < kSteps; ++j) {
      sum += bilinear_noise_factor((i + 0.5) / kSteps, (j + 0.5) / kSteps);
    }
  }
  EXPECT_NEAR(sum / (kSteps * kSteps), 4.0 / 9.0, 1e-5);
  EXPECT_EQ(bilinear_noise_factor(0.0, 0.0), 1.0);
}

}  // namespace
}  // namespace raylign
