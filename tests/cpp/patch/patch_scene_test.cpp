// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/patch_scene.h"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "raylign/base/error.h"
#include "support/eigen_matchers.h"
#include "support/numeric_jacobian.h"
#include "support/patch_scenes.h"

namespace raylign {
namespace {

using test::is_relatively_near;
using test::numeric_jacobian;
using test::patch_case;
using test::PatchSceneOptions;

using Residual = Eigen::VectorXd;

Residual residual_of(const PatchScene& scene, std::int64_t p, const PatchEdge& edge) {
  const EdgeSample sample = evaluate_edge(scene, p, edge);
  EXPECT_TRUE(sample.is_seen);
  return Eigen::Map<const Residual>(sample.residual.data(), scene.pattern.size());
}

// −(gain ∇I) (2-row motion): what the functors and kernels do with both.
template <int N>
Eigen::Matrix<double, Eigen::Dynamic, N> chained(const PatchScene& scene,
                                                 const EdgeSample& sample,
                                                 const RowMajor<2, N>& motion) {
  Eigen::Matrix<double, Eigen::Dynamic, N> J(scene.pattern.size(), N);
  for (int n = 0; n < scene.pattern.size(); ++n) {
    J.row(n) = -(sample.gradient[n][0] * motion.row(0) + sample.gradient[n][1] * motion.row(1));
  }
  return J;
}

// No pixel within `margin` of a line where a bilinear image has a kink.
bool is_smooth(const PatchScene& scene, const PatchEdge& edge, const Vector2& uv, double margin) {
  if (scene.interpolation != SampleInterpolation::BILINEAR) return true;
  const double scale = std::ldexp(1.0, -edge.level);
  for (const auto& o : scene.pattern.offsets) {
    for (int k = 0; k < 2; ++k) {
      const double at =
          (uv[k] + 0.5) * scale - 0.5 + edge.A[2 * k] * o[0] + edge.A[2 * k + 1] * o[1];
      if (std::abs(at - std::round(at)) < margin) return false;
    }
  }
  return true;
}

struct Derivatives {
  PatchScene scene;  // moved by each difference
  std::int64_t p;
  PatchEdge edge;

  template <int N, typename Move>
  auto numeric(double h, const Move& move) {
    const PatchScene before = scene;
    const auto f = [&](const Eigen::Matrix<double, N, 1>& x) {
      scene = before;
      move(x);
      return residual_of(scene, p, edge);
    };
    const auto J =
        numeric_jacobian(f, Eigen::Matrix<double, N, 1>(Eigen::Matrix<double, N, 1>::Zero()), h);
    scene = before;
    return Eigen::Matrix<double, Eigen::Dynamic, N>(J);
  }
  auto numeric_pose(std::int32_t image, double h) {
    return numeric<6>(h, [&, image](const Vector6& xi) {
      pose_plus(TranslationUpdate::COUPLED, {}, xi, scene.poses[image].q, scene.poses[image].t);
    });
  }
};

struct T1 {
  const char* name;
  PatchSceneOptions options;
};

std::vector<T1> t1_cases() {
  std::vector<T1> cases;
  const auto add = [&](const char* name) -> PatchSceneOptions& {
    cases.push_back({name, {}});
    PatchSceneOptions& o = cases.back().options;
    o.num_points = 10;
    o.brightness = true;
    return o;
  };
  add("xyz");
  add("xyz stored").hosted = false;
  add("xyz, noise of both").noise_ratio = 0.76;
  PatchSceneOptions& stored = add("xyz stored, noise of both");
  stored.hosted = false;
  stored.noise_ratio = 2.0;
  add("inverse depth").inverse_depth = true;
  PatchSceneOptions& bilinear = add("bilinear inverse depth");
  bilinear.interpolation = SampleInterpolation::BILINEAR;
  bilinear.inverse_depth = true;
  PatchSceneOptions& wrapped = add("bilinear wrapped, level 1");
  wrapped.interpolation = SampleInterpolation::BILINEAR;
  wrapped.border = PatchBorder::WRAP;
  wrapped.level = 1;
  PatchSceneOptions& coarse = add("inverse depth, level 2, intrinsics per image");
  coarse.inverse_depth = true;
  coarse.level = 2;
  coarse.intrinsics_per_image = true;
  coarse.width = 320;
  coarse.height = 240;
  coarse.pattern = PatchPattern::spread8();
  return cases;
}

class EdgeDerivatives : public testing::TestWithParam<T1> {
 protected:
  // A step of about a hundredth of a pixel of the level, in units of the parameter at hand.
  static constexpr double kStep = 1e-2;
  static constexpr double kTolerance = 1e-6;

  void SetUp() override { scene_ = patch_case(GetParam().options).start; }

  template <typename Check>
  void for_edges(const Check& check) {
    int checked = 0;
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
        Derivatives at{scene_, p, scene_.edges[e]};
        const EdgeSample sample = evaluate_edge(scene_, p, at.edge);
        ASSERT_TRUE(sample.is_seen);
        if (!is_smooth(scene_, at.edge, sample.uv, 0.03)) continue;
        check(at, sample, edge_motion(scene_, p, at.edge, sample));
        ++checked;
      }
    }
    EXPECT_GE(checked, 10);
  }
  double px() const { return kStep * std::ldexp(1.0, GetParam().options.level); }
  double angle() const { return px() / scene_.intrinsics(0, 0); }

  PatchScene scene_;
};

TEST_P(EdgeDerivatives, OfTheProjectionMatchDifferences) {
  for_edges([&](Derivatives& at, const EdgeSample& sample, const EdgeMotion& motion) {
    const std::int32_t j = at.edge.image;
    const std::int32_t h = scene_.hosts[at.p];
    EXPECT_TRUE(is_relatively_near(chained(scene_, sample, motion.pose),
                                   at.numeric_pose(j, angle()), kTolerance));
    const auto J_point = chained(scene_, sample, motion.point);
    if (!scene_.inverse_depth) {
      const auto J = at.numeric<3>(
          angle(), [&](const Vector3& d) { at.scene.points.row(at.p) += d.transpose(); });
      EXPECT_TRUE(is_relatively_near(J_point, J, kTolerance));
      EXPECT_TRUE(motion.host_pose.isZero(0.0));
      EXPECT_TRUE(motion.host_intrinsics.isZero(0.0));
      return;
    }
    const auto J_rho = at.numeric<1>(10.0 * angle(), [&](const Eigen::Matrix<double, 1, 1>& d) {
      at.scene.points(at.p, 0) += d[0];
    });
    EXPECT_TRUE(is_relatively_near(J_point.col(0), J_rho, kTolerance));
    EXPECT_TRUE(J_point.rightCols(2).isZero(0.0));
    EXPECT_TRUE(is_relatively_near(chained(scene_, sample, motion.host_pose),
                                   at.numeric_pose(h, angle()), kTolerance));
  });
}

TEST_P(EdgeDerivatives, OfIntrinsicsMatchDifferences) {
  for_edges([&](Derivatives& at, const EdgeSample& sample, const EdgeMotion& motion) {
    const std::int64_t row = scene_.intrinsics_row(at.edge.image);
    const std::int32_t host = scene_.hosts[at.p];
    const bool shared = host >= 0 && row == scene_.intrinsics_row(host);
    const auto of_row = [&](std::int64_t r) {
      return at.numeric<4>(px(),
                           [&](const Vector4& d) { at.scene.intrinsics.row(r) += d.transpose(); });
    };
    const RowMajor<2, 4> of_image =
        shared ? RowMajor<2, 4>(motion.intrinsics + motion.host_intrinsics) : motion.intrinsics;
    EXPECT_TRUE(is_relatively_near(chained(scene_, sample, of_image), of_row(row), kTolerance));
    if (scene_.inverse_depth && !shared) {
      EXPECT_TRUE(is_relatively_near(chained(scene_, sample, motion.host_intrinsics),
                                     of_row(scene_.intrinsics_row(host)), kTolerance));
    }
  });
}

TEST_P(EdgeDerivatives, OfBrightnessMatchDifferences) {
  for_edges([&](Derivatives& at, const EdgeSample& sample, const EdgeMotion&) {
    const std::int32_t j = at.edge.image;
    const std::int32_t h = scene_.hosts[at.p];
    const auto of_image = [&](std::int32_t image) {
      return at.numeric<2>(
          1e-2, [&](const Vector2& d) { at.scene.brightness.row(image) += d.transpose(); });
    };
    const EdgeBrightness& b = sample.brightness;
    Eigen::Matrix<double, Eigen::Dynamic, 2> J_j(scene_.pattern.size(), 2);
    Eigen::Matrix<double, Eigen::Dynamic, 2> J_h = J_j;
    for (int n = 0; n < scene_.pattern.size(); ++n) {
      const auto by_image = sample.by_brightness(n);
      const auto by_host = sample.by_host_brightness(n);
      J_j.row(n) << by_image[0], by_image[1];
      J_h.row(n) << by_host[0], by_host[1];
    }
    if (j == h) {  // an image against itself: brightness is no matter
      EXPECT_LT(of_image(j).cwiseAbs().maxCoeff(), 1e-9);
      EXPECT_EQ(b.gain, 1.0);
      EXPECT_EQ(b.offset, 0.0);
      return;
    }
    EXPECT_TRUE(is_relatively_near(of_image(j), J_j, kTolerance));
    if (h < 0) return;
    EXPECT_TRUE(is_relatively_near(of_image(h), J_h, kTolerance));
  });
}

INSTANTIATE_TEST_SUITE_P(T1,
                         EdgeDerivatives,
                         testing::ValuesIn(t1_cases()),
                         [](const auto& test_case) {
                           std::string name = test_case.param.name;
                           for (char& c : name)
                             c = std::isalnum(static_cast<unsigned char>(c)) != 0 ? c : '_';
                           return name;
                         });

TEST(PatchScene, TruthHasNoResidualButInterpolation) {
  for (const bool inverse_depth : {false, true}) {
    PatchSceneOptions options;
    options.inverse_depth = inverse_depth;
    options.brightness = true;
    const test::PatchCase scenes = patch_case(options);
    double worst = 0.0;
    double start = 0.0;
    for (std::int64_t p = 0; p < options.num_points; ++p) {
      for (std::int64_t e = scenes.truth.starts[p]; e < scenes.truth.starts[p + 1]; ++e) {
        const PatchEdge& edge = scenes.truth.edges[e];
        worst = std::max(worst, residual_of(scenes.truth, p, edge).cwiseAbs().maxCoeff());
        start = std::max(start, residual_of(scenes.start, p, edge).cwiseAbs().maxCoeff());
      }
    }
    EXPECT_LT(worst, 1.0);
    EXPECT_GT(start, 20.0);
  }
}

TEST(PatchScene, InverseDepthAndXyzAreTheSamePoint) {
  PatchSceneOptions options;
  const PatchScene xyz = patch_case(options).truth;
  options.inverse_depth = true;
  const PatchScene inverse = patch_case(options).truth;
  for (std::int64_t p = 0; p < xyz.num_points(); ++p) {
    EXPECT_TRUE(test::is_near(world_point(inverse, p), world_point(xyz, p), 1e-12));
    for (const PatchEdge& edge : inverse.edges) {
      const EdgeSample a = evaluate_edge(xyz, p, edge);
      const EdgeSample b = evaluate_edge(inverse, p, edge);
      ASSERT_EQ(a.is_seen, b.is_seen);
      EXPECT_TRUE(test::is_near(a.uv, b.uv, 1e-10));
    }
  }
}

TEST(PatchScene, MaskedPixelsHaveNoResidual) {
  PatchScene scene = patch_case().start;
  PatchEdge edge = scene.edges[1];
  const EdgeSample all = evaluate_edge(scene, 0, edge);
  edge.mask = 0xfff0u;
  const EdgeSample some = evaluate_edge(scene, 0, edge);
  for (int n = 0; n < 16; ++n) {
    EXPECT_EQ(some.residual[n], n < 4 ? 0.0 : all.residual[n]);
    EXPECT_EQ(some.counts(edge, n), n >= 4);
  }
}

TEST(PatchScene, EdgesBehindNearOrOutsideAreNotSeen) {
  PatchScene scene = patch_case().truth;
  const PatchEdge edge = scene.edges[1];
  const auto seen_at = [&](const Vector3& in_camera) {  // of the edge's camera
    const PatchPose& pose = scene.poses[edge.image];
    scene.points.row(0) = (pose.q.conjugate() * (in_camera - pose.t)).transpose();
    return evaluate_edge(scene, 0, edge).is_seen;
  };
  EXPECT_TRUE(seen_at({0.0, 0.0, 2.0}));
  EXPECT_FALSE(seen_at({0.0, 0.0, -2.0}));
  EXPECT_FALSE(seen_at({9.0, 0.0, 2.0}));
  const double nan = std::numeric_limits<double>::quiet_NaN();
  EXPECT_FALSE(seen_at({nan, 0.0, 2.0}));
  EXPECT_FALSE(seen_at({0.0, 0.0, nan}));
  scene.min_depth = 3.0;
  EXPECT_FALSE(seen_at({0.0, 0.0, 2.0}));
  scene.min_depth = -std::numeric_limits<double>::infinity();
  EXPECT_TRUE(seen_at({0.0, 0.0, -2.0}));
  EXPECT_FALSE(seen_at({0.0, 0.0, nan}));
}

TEST(PatchScene, RefusesWhatDisagrees) {
  const PatchScene good = patch_case().start;
  EXPECT_NO_THROW(good.validate());
  const auto refuses = [&](const auto& spoil) {
    PatchScene scene = good;
    spoil(scene);
    EXPECT_THROW(scene.validate(), ShapeError);
  };
  refuses([](PatchScene& s) { s.poses.pop_back(); });
  refuses([](PatchScene& s) { s.brightness.conservativeResize(3, 2); });
  refuses([](PatchScene& s) { s.intrinsics.conservativeResize(2, 4); });
  refuses([](PatchScene& s) { s.intrinsics.resize(0, 4); });
  refuses([](PatchScene& s) { s.starts.clear(); });
  refuses([](PatchScene& s) { s.starts.pop_back(); });
  refuses([](PatchScene& s) { s.starts[0] = 1; });
  refuses([](PatchScene& s) { s.starts.back() += 1; });
  refuses([](PatchScene& s) { std::swap(s.starts[3], s.starts[4]); });
  refuses([](PatchScene& s) { s.starts[3] = -5; });
  refuses([](PatchScene& s) { s.patches.pop_back(); });
  refuses([](PatchScene& s) { s.points.conservativeResize(7, 3); });
  refuses([](PatchScene& s) { s.host_uv.resize(0, 2); });
  refuses([](PatchScene& s) { s.hosts[2] = 5; });
  refuses([](PatchScene& s) { s.hosts[2] = -2; });
  refuses([](PatchScene& s) { s.edges[9].image = -1; });
  refuses([](PatchScene& s) { s.edges[9].image = 5; });
  refuses([](PatchScene& s) { s.edges[9].level = 1; });
  refuses([](PatchScene& s) { s.edges[9].level = -1; });
  refuses([](PatchScene& s) { s.images[1] = nullptr; });

  PatchScene scene = good;
  scene.inverse_depth = true;
  EXPECT_NO_THROW(scene.validate());
  scene.hosts[2] = -1;
  EXPECT_THROW(scene.validate(), OptionsError);
  scene = good;
  scene.pattern.offsets.clear();
  scene.patches.clear();
  EXPECT_THROW(scene.validate(), OptionsError);
}

}  // namespace
}  // namespace raylign
