// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/views.h"

#include <gtest/gtest.h>

#include "photometric/small_room.h"
#include "raylign/photometric/brightness_start.h"
#include "raylign/photometric/levels.h"
#include "raylign/photometric/normals.h"

namespace raylign::photometric {
namespace {

using test::SmallRoom;
using test::SmallRoomOptions;
using test::SmallSetting;

std::int64_t count(const Views& views, EdgeStatus status) {
  return std::count(views.edges.begin(), views.edges.end(), status);
}

TEST(ViewsTest, AtTheTruthAlmostAllEdgesInViewAreUsed) {
  const SmallRoom room;
  SmallSetting s(room.truth());
  const Views views = find_views(s.setting, s.state, 0);
  const std::int64_t seen = views.scene.num_edges() - count(views, EdgeStatus::OUT_OF_VIEW);
  EXPECT_GT(count(views, EdgeStatus::OK), 0.97 * seen);
  EXPECT_EQ(count(views, EdgeStatus::OCCLUDED), 0);
}

TEST(ViewsTest, WhatABoardHidesIsOccluded) {
  SmallRoomOptions options;
  options.with_board = true;
  options.spacing = 4;
  options.extent = 0.5;
  const SmallRoom room(options);
  PhotometricOptions no_test;
  no_test.visibility.occlusion = 0.0;
  no_test.visibility.max_residual = 1e9;  // geometry alone
  PhotometricOptions with_test = no_test;
  with_test.visibility.occlusion = 0.05;
  SmallSetting plain(room.truth(), no_test);
  SmallSetting tested(room.truth(), with_test);
  const Views all = find_views(plain.setting, plain.state, 0);
  const Views views = find_views(tested.setting, tested.state, 0);
  std::int64_t hidden = 0, found = 0, wrong = 0;
  for (std::int64_t p = 0; p < room.truth().num_points(); ++p) {
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      if (all.edges[e] != EdgeStatus::OK) continue;
      const int image = views.scene.edges[e].image;
      Vector2 uv;
      ASSERT_TRUE(tested.state.project(image, tested.state.points.row(p), uv));
      const bool is_at_border = uv.x() < 5.0 || uv.y() < 5.0 || uv.x() >= SmallRoom::kWidth - 5 ||
                                uv.y() >= SmallRoom::kHeight - 5;
      if (is_at_border) continue;  // the depths around it, below, would lie outside the image
      const double z = tested.state.in_camera(image, tested.state.points.row(p)).z();
      const auto depth = [&](int du, int dv) {
        return room.frames()[image].depth(static_cast<int>(uv.y()) + dv,
                                          static_cast<int>(uv.x()) + du);
      };
      const bool is_hidden = depth(0, 0) < 0.9 * z;
      const bool is_near_edge =
          (depth(-5, 0) < 0.9 * z) != is_hidden || (depth(5, 0) < 0.9 * z) != is_hidden ||
          (depth(0, -5) < 0.9 * z) != is_hidden || (depth(0, 5) < 0.9 * z) != is_hidden;
      if (is_near_edge) continue;
      hidden += is_hidden ? 1 : 0;
      found += is_hidden && views.edges[e] == EdgeStatus::OCCLUDED ? 1 : 0;
      wrong += !is_hidden && views.edges[e] == EdgeStatus::OCCLUDED ? 1 : 0;
    }
  }
  ASSERT_GT(hidden, 50);
  EXPECT_GT(found, 0.8 * hidden);  // the rest lies between the board's own points
  EXPECT_LT(wrong, 0.05 * hidden);
}

TEST(ViewsTest, EdgesSayWhyTheyAreNotUsed) {
  const SmallRoom room;
  PhotometricProblem problem = room.truth();
  auto white = std::make_shared<Plane<std::uint8_t>>(SmallRoom::kWidth, SmallRoom::kHeight);
  std::fill(white->data(), white->data() + white->size(), std::uint8_t{0});
  problem.masks.assign(5, nullptr);
  problem.masks[1] = white;
  Vector6 turn = Vector6::Zero();
  turn[4] = M_PI;
  SmallRoom::set_pose(problem, 2, se3_exp(turn) * problem.pose(2));
  Vector6 forward = Vector6::Zero();
  forward[2] = -2.2;  // nearly at the far wall
  SmallRoom::set_pose(problem, 3, se3_exp(forward) * problem.pose(3));
  SmallSetting s(problem);
  const Views views = find_views(s.setting, s.state, 0);
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    const std::int32_t host = s.setting.hosts.image[p];
    if (host != 0) continue;
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      const std::int32_t image = views.scene.edges[e].image;
      const EdgeStatus status = views.edges[e];
      if (image == 1 && status != EdgeStatus::OUT_OF_VIEW) {
        EXPECT_EQ(status, EdgeStatus::SATURATED) << p;
      }
      if (image == 2) {
        EXPECT_EQ(status, EdgeStatus::BEHIND) << p;
      }
      if (image == 3) {
        EXPECT_NE(status, EdgeStatus::OK) << p;
      }
    }
  }
  EXPECT_GT(count(views, EdgeStatus::SCALE_CHANGE), 0);
}

TEST(ViewsTest, AnotherImageIsAMismatch) {
  const SmallRoom room;
  PhotometricProblem problem = room.truth();
  TextureOptions other;
  other.seed = 99;
  Plane<float> image(SmallRoom::kWidth, SmallRoom::kHeight);
  test::NamedRng rng = test::make_rng("other image");
  for (std::size_t i = 0; i < image.size(); ++i) {
    image.data()[i] = static_cast<float>(rng.uniform(40.0, 220.0));
  }
  problem.images[2] = std::make_shared<ImagePyramid>(
      ImageView{image.data(), PixelType::FLOAT32, image.width(), image.height(), 1,
                sizeof(float) * static_cast<std::size_t>(image.width())});
  SmallSetting s(problem);
  const Views views = find_views(s.setting, s.state, 0);
  int wrong = 0, mismatches = 0, all = 0, used = 0;
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    if (s.setting.hosts.image[p] == 2) {
      used += views.points[p] == PointStatus::OK ? 1 : 0;
      continue;
    }
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      if (views.edges[e] == EdgeStatus::OUT_OF_VIEW) continue;
      const bool is_other = views.scene.edges[e].image == 2;
      all += is_other ? 1 : 0;
      mismatches += is_other && views.edges[e] == EdgeStatus::MISMATCH ? 1 : 0;
      wrong += !is_other && views.edges[e] == EdgeStatus::MISMATCH ? 1 : 0;
    }
  }
  EXPECT_GT(mismatches, 0.8 * all);
  EXPECT_LE(wrong, 2);
  EXPECT_LE(used, 4);  // by chance
}

TEST(NormalsTest, AreThoseOfTheWalls) {
  SmallRoomOptions options;
  options.spacing = 6;
  const SmallRoom room(options);
  SmallSetting s(room.truth());
  const Rows<double, 3> normals = fit_normals(s.state, s.setting.hosts, {});
  int known = 0, good = 0;
  for (Eigen::Index p = 0; p < normals.rows(); ++p) {
    if (!normals.row(p).allFinite()) continue;
    ++known;
    good += std::abs(normals.row(p).dot(room.truth().normals.row(p))) > 0.999 ? 1 : 0;
  }
  EXPECT_GT(known, 0.6 * normals.rows());
  EXPECT_GT(good, 0.88 * known);
}

TEST(NormalsTest, GivenOnesAreKept) {
  const SmallRoom room;
  SmallSetting s(room.truth());
  EXPECT_EQ(fit_normals(s.state, s.setting.hosts, room.truth().normals), room.truth().normals);
}

TEST(LevelsTest, FollowFromThePriors) {
  const SmallRoom room;
  PhotometricProblem problem = room.truth();
  const auto levels = [&](double sigma_px) {
    const double angle = sigma_px / 140.0 / std::sqrt(2.0);  // about x and y
    Matrix6 C = 1e-12 * Matrix6::Identity();
    C(3, 3) = C(4, 4) = angle * angle;
    problem.pose_covariances.resize(5, 36);
    for (int i = 0; i < 5; ++i) {
      problem.pose_covariances.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 36>>(C.data());
    }
    SmallSetting s(problem);
    return plan_levels(s.setting, s.state);
  };
  EXPECT_EQ(levels(1.0).num_levels, 1);
  EXPECT_EQ(levels(2.0).num_levels, 2);
  EXPECT_EQ(levels(4.0).num_levels, 3);
  EXPECT_NEAR(levels(4.0).expected_shift_px, 4.0, 1.0);
  const LevelPlan far = levels(60.0);
  EXPECT_EQ(far.num_levels, 4);  // 200 x 150 px have no more
  EXPECT_EQ(far.messages.size(), 1u);
}

TEST(LevelsTest, FourWhenNothingIsKnownAndOneForStoredPatches) {
  const SmallRoom room;
  SmallSetting s(room.truth());
  EXPECT_EQ(plan_levels(s.setting, s.state).num_levels, 4);
  SmallRoomOptions stored;
  stored.stored = true;
  const SmallRoom with_patches(stored);
  PhotometricOptions options;
  options.num_levels = 3;
  SmallSetting t(with_patches.truth(), options);
  const LevelPlan plan = plan_levels(t.setting, t.state);
  EXPECT_EQ(plan.num_levels, 1);
  EXPECT_EQ(plan.messages.size(), 1u);
}

TEST(BrightnessStartTest, IsCloseFromABadStart) {
  SmallRoomOptions options;
  options.gain = 0.3;
  options.bias = 15.0;
  const SmallRoom room(options);
  const PhotometricProblem start = room.start(1.0, 0.015, 0.03);
  SmallSetting s(start);
  const Rows<double, 2> found = estimate_brightness(s.setting, s.state, 1);
  for (int i = 1; i < 5; ++i) {
    const double sign = i % 2 == 0 ? 1.0 : -1.0;
    const double a = -sign * options.gain;  // undoes the sensor's gain and bias
    const double b = sign * options.bias * std::exp(a);
    EXPECT_NEAR(found(i, 0), a, 0.16) << i;
    EXPECT_NEAR(found(i, 1), b, 20.0) << i;
  }
}

TEST(HostsTest, APatchComesFromTheImageWithMostContrast) {
  const SmallRoom room;
  PhotometricProblem problem = room.truth();
  problem.hosts.resize(0);
  problem.host_uv.resize(0, 2);
  SmallSetting s(problem);
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    const std::int32_t host = s.setting.hosts.image[p];
    if (host < 0) continue;
    Vector2 uv;
    ASSERT_TRUE(s.state.project(host, s.state.points.row(p), uv));
    EXPECT_LT((uv.transpose() - s.setting.hosts.uv.row(p)).norm(), 1e-9);
  }
}

}  // namespace
}  // namespace raylign::photometric
