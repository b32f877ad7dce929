// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/photometric_alignment.h"

#include <gtest/gtest.h>

#include "raylign/tracking/alignment_problem.h"
#include "raylign/tracking/point.h"
#include "support/named_rng.h"
#include "tracking/plane_scene.h"

namespace raylign {
namespace {

LmOptions tight() {
  LmOptions lm;
  lm.function_tolerance = 1e-12;
  lm.parameter_tolerance = 1e-10;
  lm.max_num_iterations = 100;
  return lm;
}

// No depth near the border: which points are in view must not change.
std::shared_ptr<Frame> inner_frame(const test::PlaneScene& scene) {
  constexpr int kMargin = 12;
  Plane<float> image, D;
  scene.render(Matrix4::Identity(), image, D);
  for (int v = 0; v < scene.height; ++v) {
    for (int u = 0; u < scene.width; ++u) {
      if (std::min({u, v, scene.width - 1 - u, scene.height - 1 - v}) < kMargin) D.at(u, v) = NAN;
    }
  }
  return scene.frame_of(image, D, 1e-4);
}

// The tracker's optimiser, σ frozen at the start, and Ceres at those σ find the same pose.
TEST(PhotometricAlignment, TrackerAndCeresAgree) {
  for (int seed = 0; seed < 5; ++seed) {
    auto rng = test::make_rng("photometric_oracle", static_cast<std::uint64_t>(seed));
    const test::PlaneScene scene;
    Plane<float> image, D;
    Vector6 xi;
    xi << rng.normal_vector<3>(0.01), rng.normal_vector<3>(0.005);
    scene.render(se3_exp(xi), image, D);
    // residuals that stay, in an image as smooth as before
    const double phase = rng.uniform(0.0, 6.0);
    for (int v = 0; v < image.height(); ++v) {
      for (int u = 0; u < image.width(); ++u) {
        image.at(u, v) += static_cast<float>(2.0 * std::sin(0.1 * u + phase) * std::cos(0.12 * v));
      }
    }
    const Keyframe keyframe(inner_frame(scene), {});
    const auto target = scene.frame_of(image, D, 0.0);

    TrackingOptions options;
    options.sigma_mode = SigmaMode::FROZEN;
    options.affine.mode = AffineMode::NONE;
    options.lm = tight();
    ThreadPool pool(1);
    tracking::Workspace workspace;
    tracking::PointPass pass(keyframe, *target, 0, options, pool, workspace);
    tracking::AlignmentProblem<tracking::Se3Motion> problem(pass, options, {}, {});
    minimize(problem, options.lm, IterationCallback(), Stopwatch(), pass.num_points());

    const PointList& list = keyframe.points(0);
    const tracking::PassSettings settings = pass.settings({}, {});
    std::vector<ceres_backend::PhotometricPoint> points;
    for (std::int64_t i = 0; i < list.padded_size(); ++i) {
      if (list.pixels()[static_cast<std::size_t>(i)] < 0) continue;
      const tracking::HostPoint p = tracking::host_point(list.arrays(), i);
      tracking::PointResidual start;
      ASSERT_TRUE(tracking::photometric_point(p, target->gradients(0).view(),
                                              tracking::point_pose(settings), settings, start));
      points.push_back({p.ray_x, p.ray_y, p.D, p.I, std::sqrt(start.variance)});
    }
    const ceres_backend::PhotometricAlignment oracle =
        ceres_backend::align_photometric(points, target->gradients(0).view(), scene.camera(),
                                         Matrix4::Identity(), options.loss, options.lm);
    const Vector6 difference = test::pose_error(problem.state().T_th, oracle.T_th);
    EXPECT_LT(difference.head<3>().norm(), 2e-5) << seed;
    EXPECT_LT(difference.tail<3>().norm(), 1e-5) << seed;
    const Vector6 error = test::pose_error(oracle.T_th, se3_exp(xi));
    EXPECT_LT(error.norm(), 2e-2) << seed;
  }
}

}  // namespace
}  // namespace raylign
