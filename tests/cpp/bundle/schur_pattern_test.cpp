// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_pattern.h"

#include <gtest/gtest.h>

#include <set>
#include <utility>

#include "bundle/random_tracks.h"
#include "raylign/bundle/native/product_plan.h"

namespace raylign::native {
namespace {

class Pattern : public testing::TestWithParam<int> {};  // longest track

TEST_P(Pattern, HoldsThePairsOfMovingCameras) {
  const Layout layout(test::random_tracks(70, 400, GetParam()));
  std::vector<unsigned char> active(70, 1);
  active[4] = active[17] = 0;
  const SchurPattern pattern(layout, active);
  std::set<std::pair<int, int>> expected;
  std::int64_t num_pairs = 0;
  for (std::int64_t j = 0; j < layout.num_landmarks(); ++j) {
    for (auto a = layout.starts[j]; a < layout.starts[j + 1]; ++a) {
      for (auto b = a; b < layout.starts[j + 1]; ++b) {
        const int i = layout.camera[a];
        const int k = layout.camera[b];
        if (active[i] == 0 || active[k] == 0) continue;
        ++num_pairs;
        expected.insert({i, k});
      }
    }
  }
  std::set<std::pair<int, int>> found;
  for (int i = 0; i < 70; ++i) {
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      if (b > pattern.starts[i]) {
        EXPECT_LT(pattern.columns[b - 1], pattern.columns[b]);
      }
      found.insert({i, pattern.columns[b]});
    }
  }
  EXPECT_EQ(found, expected);
  EXPECT_GE(pattern.num_pairs, num_pairs);  // a camera twice in a track counts both orders
}

TEST_P(Pattern, PlanListsEveryProductOnceUnderItsBlock) {
  const Layout layout(test::random_tracks(70, 400, GetParam()));
  std::vector<unsigned char> active(70, 1);
  active[4] = active[17] = 0;
  const SchurPattern pattern(layout, active);
  const ProductPlan plan(layout, pattern);
  using Pair = std::pair<std::int64_t, std::int64_t>;  // observations
  std::multiset<Pair> expected;
  for (std::int64_t j = 0; j < layout.num_landmarks(); ++j) {
    for (auto a = layout.starts[j]; !layout.is_long(j) && a < layout.starts[j + 1]; ++a) {
      for (auto b = layout.starts[j]; b < layout.starts[j + 1]; ++b) {
        const int i = layout.camera[a];
        const int k = layout.camera[b];
        if (active[i] != 0 && active[k] != 0 && (a <= b || i == k)) expected.insert({a, b});
      }
    }
  }
  std::multiset<Pair> found;
  ASSERT_EQ(plan.windows.size(), static_cast<std::size_t>(layout.num_windows()));
  std::int64_t next_landmark = 0;
  for (const ProductWindow& window : plan.windows) {
    EXPECT_EQ(window.landmark_begin, next_landmark);
    next_landmark = window.landmark_end;
    EXPECT_EQ(window.is_planned, !layout.is_long(window.landmark_begin));
    const std::int64_t first = layout.starts[window.landmark_begin];
    std::int64_t p = window.products_begin;
    for (auto v = window.visits_begin; v < window.visits_end; ++v) {
      const BlockVisit& visit = plan.visits[v];
      if (v > window.visits_begin) {
        EXPECT_LT(plan.visits[v - 1].block, visit.block);
      }
      for (; p < window.products_begin + visit.products_end; ++p) {
        const Pair pair{first + plan.products[p].i, first + plan.products[p].k};
        EXPECT_EQ(layout.camera[pair.first], visit.row);
        EXPECT_EQ(layout.camera[pair.second], pattern.columns[visit.block]);
        found.insert(pair);
      }
    }
  }
  EXPECT_EQ(next_landmark, layout.num_landmarks());
  EXPECT_EQ(found, expected);
}

// The fullest window that there is: as many products as 16 bits cannot count.
TEST(ProductPlan, HoldsAWindowOfOneCameraAlone) {
  constexpr int kTrack = Layout::kLongTrack;
  constexpr int kPoints = Layout::kWindow / kTrack;
  BalProblem problem;
  problem.cameras.setZero(1, 9);
  problem.points.setZero(kPoints, 3);
  problem.camera_index.setZero(kPoints * kTrack);
  problem.point_index.resize(kPoints * kTrack);
  for (int i = 0; i < kPoints * kTrack; ++i) problem.point_index[i] = i / kTrack;
  problem.observations.setZero(kPoints * kTrack, 2);
  const Layout layout(problem);
  ASSERT_EQ(layout.num_windows(), 1);
  const ProductPlan plan(layout, SchurPattern(layout, {1}));
  ASSERT_EQ(plan.visits.size(), 1u);
  EXPECT_EQ(plan.visits[0].products_end, kPoints * kTrack * kTrack);
  EXPECT_EQ(plan.products.size(), static_cast<std::size_t>(kPoints * kTrack * kTrack));
}

INSTANTIATE_TEST_SUITE_P(Lengths, Pattern, testing::Values(3, 12, 90));

}  // namespace
}  // namespace raylign::native
