// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/kernels.h"

#include <gtest/gtest.h>

#include "raylign/tracking/aligner.h"
#include "raylign/tracking/alignment_problem.h"
#include "raylign/tracking/point.h"
#include "raylign/tracking/point_pass.h"
#include "support/named_rng.h"
#include "tracking/plane_scene.h"

namespace raylign {
namespace {

using tracking::PassSettings;
using tracking::PassSums;
using tracking::TermSums;

Vector6 small_motion() {
  Vector6 xi;
  xi << 0.02, -0.01, 0.03, 0.01, -0.02, 0.03;
  return xi;
}

// The kernel's sums over a level by its scalar twin, point by point in double.
struct Twin {
  const Keyframe& keyframe;
  const Frame& target;
  PassSettings settings;

  void add(const tracking::PointResidual& p, double scale, int columns, TermSums& sums) const {
    const double variance = scale * scale * p.variance;
    const LossValue loss = settings.loss->evaluate(p.r * p.r / variance);
    const double w = loss.d_rho / variance;
    int entry = 0;
    for (int i = 0; i < columns; ++i) {
      for (int j = i; j < columns; ++j) sums.H[entry++] += w * p.J[i] * p.J[j];
      sums.g[i] += w * p.J[i] * p.r;
    }
    sums.rho += loss.rho;
    sums.count += 1.0;
    sums.weight += loss.d_rho;
    sums.weighted_square += loss.d_rho * p.r * p.r / variance;
  }

  PassSums run(int level) const {
    PassSums sums;
    const PointList& points = keyframe.points(level);
    const tracking::PointPose at = tracking::point_pose(settings);
    for (std::int64_t i = 0; i < points.padded_size(); ++i) {
      if (points.pixels()[static_cast<std::size_t>(i)] < 0) continue;
      const tracking::HostPoint point = tracking::host_point(points.arrays(), i);
      tracking::PointResidual p;
      if (tracking::photometric_point(point, target.gradients(level).view(), at, settings, p)) {
        add(p, static_cast<double>(settings.photometric_scale), settings.with_brightness ? 8 : 6,
            sums.photometric);
        const double g2 = p.g_u * p.g_u + p.g_v * p.g_v;
        sums.good += p.r * p.r < 1600.0 + 0.25 * g2 ? 1.0 : 0.0;
      }
      if (target.has_depth() &&
          tracking::depth_point(point, target.depth_cells(level).view(), at, settings, p)) {
        add(p, static_cast<double>(settings.depth_scale), settings.with_scale ? 7 : 6, sums.depth);
      }
    }
    return sums;
  }
};

void expect_near(const TermSums& a, const TermSums& b) {
  double size = 0.0;
  for (const double value : b.H) size = std::max(size, std::abs(value));
  for (int k = 0; k < tracking::kMaxTriangle; ++k) {
    EXPECT_NEAR(a.H[k], b.H[k], 1e-5 * (std::abs(b.H[k]) + 1e-2 * size)) << "H " << k;
  }
  for (int k = 0; k < tracking::kMaxColumns; ++k) {
    EXPECT_NEAR(a.g[k], b.g[k], 1e-4 * (std::abs(b.g[k]) + std::sqrt(size * b.rho) * 1e-2));
  }
  EXPECT_NEAR(a.rho, b.rho, 1e-4 * b.rho);
  EXPECT_NEAR(a.weight, b.weight, 1e-4 * b.weight);
  EXPECT_NEAR(a.weighted_square, b.weighted_square, 1e-4 * b.weighted_square);
  EXPECT_EQ(a.count, b.count);
}

class KernelTest : public testing::TestWithParam<TrackingOptions> {};

TEST_P(KernelTest, AgreesWithItsScalarTwin) {
  const test::PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-4), {});
  const Matrix4 T = se3_exp(small_motion());
  const auto target = scene.frame(T, 1e-4);
  ThreadPool pool(1);
  tracking::Workspace workspace;
  const TrackingOptions options = GetParam();
  for (int level = 0; level < 2; ++level) {
    tracking::PointPass pass(keyframe, *target, level, options, pool, workspace);
    tracking::PoseState state = {se3_exp(Vector6(0.7 * small_motion())), 0.1, -3.0};
    if (options.affine.mode == AffineMode::NONE) state.a = state.b = 0.0;
    const PassSums sums = pass.run(state, {}, nullptr, workspace.buffers[0]);
    const PassSums expected = Twin{keyframe, *target, pass.settings(state, {})}.run(level);
    EXPECT_GT(sums.photometric.count, 500.0);
    expect_near(sums.photometric, expected.photometric);
    expect_near(sums.depth, expected.depth);
    EXPECT_EQ(sums.good, expected.good);
  }
}

std::vector<TrackingOptions> all_kinds() {
  std::vector<TrackingOptions> kinds(6);
  kinds[1].gradient = GradientMode::ESM;
  kinds[1].affine.mode = AffineMode::NONE;
  kinds[2].noise_model = NoiseModel::EXACT;
  kinds[2].loss = {LossType::STUDENT_T, 1.0, 5.0};
  kinds[3].motion = MotionGroup::SIM3;
  kinds[3].loss = {LossType::TUKEY, 4.685, 5.0};
  kinds[4].loss = {LossType::TRIVIAL, 1.0, 5.0};
  kinds[4].depth.use_gradient = false;
  kinds[5].sigma_mode = SigmaMode::FROZEN;
  return kinds;
}

INSTANTIATE_TEST_SUITE_P(Options, KernelTest, testing::ValuesIn(all_kinds()));

// Gauss-Newton on the scalar twin's sums, in double, against the aligner on the kernel's.
TEST(Kernel, ScalarAndVectorCodeEndAtTheSamePose) {
  const test::PlaneScene scene;
  const Keyframe keyframe(scene.frame(Matrix4::Identity(), 1e-4), {});
  const auto target = scene.frame(se3_exp(small_motion()), 1e-4);
  for (const bool with_depth : {false, true}) {
    TrackingOptions options;
    options.finest_level = options.coarsest_level = 0;
    options.affine.mode = AffineMode::NONE;
    options.depth.enabled = with_depth;
    options.depth.estimate_weight = false;
    options.lm.function_tolerance = 0.0;
    options.lm.parameter_tolerance = 1e-9;
    AlignmentStart start;
    start.T_th = se3_exp(Vector6(0.8 * small_motion()));
    const AlignmentResult vectors = Aligner(options).align(keyframe, *target, start);
    EXPECT_EQ(vectors.status, AlignmentStatus::OK) << vectors.reason;
    ThreadPool pool(1);
    tracking::Workspace workspace;
    const tracking::PointPass pass(keyframe, *target, 0, options, pool, workspace);
    tracking::TermScales scales;
    scales.photometric_scale = vectors.sigma_scale;
    Matrix4 T = start.T_th;
    for (int i = 0; i < 12; ++i) {
      Twin twin = {keyframe, *target, pass.settings({T, 0.0, 0.0}, scales)};
      const PassSums sums = twin.run(0);
      auto equations = tracking::photometric_equations(sums.photometric, false);
      if (with_depth) {
        const auto depth = tracking::depth_equations(sums.depth, false);
        equations.H += options.depth.weight * depth.H;
        equations.g += options.depth.weight * depth.g;
      }
      const Matrix6 H = equations.H.topLeftCorner<6, 6>();
      T = se3_exp(Vector6(-H.ldlt().solve(equations.g.head<6>()))) * T;
    }
    EXPECT_LT(test::pose_error(vectors.T_th, T).norm(), 1e-5) << with_depth;
  }
}

// Padding, points behind the camera and pixels that are not finite must not leak into the sums.
TEST(Kernel, NothingThatIsNotFiniteGetsIntoTheSums) {
  const test::PlaneScene scene;
  Plane<float> image, D;
  scene.render(Matrix4::Identity(), image, D);
  const Keyframe keyframe(scene.frame_of(image, D, 1e-4), {});
  for (std::size_t i = 0; i < image.size(); i += 7) image.data()[i] = NAN;
  for (std::size_t i = 0; i < D.size(); i += 5) D.data()[i] = i % 2 == 0 ? NAN : -1.0F;
  const auto target = scene.frame_of(image, D, 1e-4);
  ThreadPool pool(1);
  tracking::Workspace workspace;
  const TrackingOptions options;
  tracking::PointPass pass(keyframe, *target, 0, options, pool, workspace);
  for (const double angle : {0.0, 0.3, 1.6, 3.1}) {
    Vector6 xi;
    xi << 0.0, 0.0, -1.9, 0.0, angle, 0.0;
    const PassSums sums = pass.run({se3_exp(xi), 0.0, 0.0}, {}, nullptr, workspace.buffers[0]);
    for (const double value : sums.photometric.H) EXPECT_TRUE(std::isfinite(value));
    for (const double value : sums.depth.g) EXPECT_TRUE(std::isfinite(value));
    EXPECT_TRUE(std::isfinite(sums.photometric.rho + sums.depth.rho + sums.usage + sums.good));
  }
}

}  // namespace
}  // namespace raylign
