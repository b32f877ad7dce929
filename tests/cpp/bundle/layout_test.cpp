// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/layout.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <numeric>
#include <string>
#include <tuple>
#include <vector>

#include "bundle/random_tracks.h"
#include "raylign/bundle/native/product_plan.h"
#include "raylign/synthetic/bal.h"

namespace raylign::native {
namespace {

BalProblem synthetic(SyntheticBalKind kind) {
  SyntheticBalOptions options;
  options.kind = kind;
  options.num_cameras = 90;
  options.num_points = 20000;  // enough for four threads to share
  options.seed = 3;
  return synthetic_bal(options).problem;
}

// The same observations in no order, points that nobody sees among them.
BalProblem shuffled(const BalProblem& problem) {
  std::vector<Eigen::Index> order(problem.num_observations());
  std::iota(order.begin(), order.end(), 0);
  std::shuffle(order.begin(), order.end(), test::make_rng("shuffled").engine());
  BalProblem result = problem;
  result.colors.resize(0, 3);
  result.points.setZero(2 * problem.num_points(), 3);
  for (std::size_t i = 0; i < order.size(); ++i) {
    const auto from = order[i];
    result.camera_index[i] = problem.camera_index[from];
    result.point_index[i] = 2 * problem.point_index[from] + 1;
    result.observations.row(i) = problem.observations.row(from);
  }
  return result;
}

struct Case {
  const char* name;
  BalProblem (*make)();
};
const Case kCases[] = {
    {"street", [] { return synthetic(SyntheticBalKind::STREET); }},
    {"orbit", [] { return synthetic(SyntheticBalKind::ORBIT); }},
    {"shuffled", [] { return shuffled(synthetic(SyntheticBalKind::STREET)); }},
    {"long_and_double", [] { return test::random_tracks(90, 3000, 90); }},
    {"shuffled_long", [] { return shuffled(test::random_tracks(90, 3000, 90)); }},
    {"one_camera", [] { return test::random_tracks(1, 50, 90); }},
};

class Preprocessing : public testing::TestWithParam<Case> {
 protected:
  BalProblem problem_ = GetParam().make();
};

struct ExpectedTrack {
  std::int32_t point;
  std::vector<std::int32_t> observations;
};

// The documented order by its definition, but for the order by length.
std::vector<ExpectedTrack> expected_tracks(const BalProblem& problem) {
  std::vector<ExpectedTrack> tracks(problem.num_points());
  for (std::int32_t i = 0; i < problem.num_observations(); ++i) {
    tracks[problem.point_index[i]].observations.push_back(i);
  }
  std::vector<ExpectedTrack> seen;
  const auto camera = [&](std::int32_t i) { return problem.camera_index[i]; };
  for (std::size_t p = 0; p < tracks.size(); ++p) {
    auto& list = tracks[p].observations;
    if (list.empty()) continue;
    std::stable_sort(list.begin(), list.end(),
                     [&](auto a, auto b) { return camera(a) < camera(b); });
    seen.push_back({static_cast<std::int32_t>(p), list});
  }
  const auto key = [&](const ExpectedTrack& track) {
    return std::pair(camera(track.observations.front()), camera(track.observations.back()));
  };
  std::stable_sort(seen.begin(), seen.end(),
                   [&](const auto& a, const auto& b) { return key(a) < key(b); });
  return seen;
}

TEST_P(Preprocessing, LandmarksLieByTheirCamerasAndInAWindowByTheirLength) {
  const Layout layout(problem_);
  auto tracks = expected_tracks(problem_);
  ASSERT_EQ(layout.num_landmarks(), static_cast<std::int64_t>(tracks.size()));
  ASSERT_EQ(layout.num_observations(), problem_.num_observations());
  ASSERT_EQ(layout.windows.front(), 0);
  ASSERT_EQ(layout.windows.back(), layout.num_landmarks());
  for (int w = 0; w < layout.num_windows(); ++w) {
    std::stable_sort(
        tracks.begin() + layout.windows[w], tracks.begin() + layout.windows[w + 1],
        [](const auto& a, const auto& b) { return a.observations.size() > b.observations.size(); });
  }
  std::int64_t q = 0;
  for (std::size_t j = 0; j < tracks.size(); ++j) {
    ASSERT_EQ(layout.points[j], tracks[j].point) << "landmark " << j;
    ASSERT_EQ(layout.starts[j], q);
    for (const std::int32_t i : tracks[j].observations) {
      ASSERT_EQ(layout.camera[q], problem_.camera_index[i]);
      ASSERT_EQ(layout.uv[2 * q], problem_.observations(i, 0));
      ASSERT_EQ(layout.uv[2 * q + 1], problem_.observations(i, 1));
      ++q;
    }
  }
  EXPECT_EQ(layout.starts.back(), q);
}

TEST_P(Preprocessing, WindowsAreFullOrHoldOneLongTrack) {
  const Layout layout(problem_);
  const auto size = [&](std::int64_t begin, std::int64_t end) {
    return layout.starts[end] - layout.starts[begin];
  };
  for (int g = 0; g < layout.num_chunks(); ++g) {
    EXPECT_EQ(layout.windows[layout.chunk_windows[g]], layout.chunks[g]);
    for (auto w = layout.chunk_windows[g]; w < layout.chunk_windows[g + 1]; ++w) {
      const std::int64_t begin = layout.windows[w];
      const std::int64_t end = layout.windows[w + 1];
      ASSERT_LT(begin, end);
      if (layout.is_long(begin)) {
        EXPECT_EQ(end, begin + 1);
        continue;
      }
      EXPECT_LE(size(begin, end), Layout::kWindow);
      if (end == layout.chunks[g + 1] || layout.is_long(end)) continue;
      // the one that had no room here is not longer than the first, the longest, of the next window
      EXPECT_GT(size(begin, end) + size(end, end + 1), Layout::kWindow);
    }
  }
}

TEST_P(Preprocessing, VisitsListEachWindowByCamera) {
  const Layout layout(problem_);
  std::vector<bool> observed(layout.num_cameras, false);
  for (int w = 0; w < layout.num_windows(); ++w) {
    const std::int64_t first = layout.starts[layout.windows[w]];
    const std::int64_t count = layout.starts[layout.windows[w + 1]] - first;
    std::vector<std::int32_t> places(count);
    std::iota(places.begin(), places.end(), 0);
    std::stable_sort(places.begin(), places.end(), [&](auto a, auto b) {
      return layout.camera[first + a] < layout.camera[first + b];
    });
    std::int32_t p = 0;
    for (auto v = layout.window_visits[w]; v < layout.window_visits[w + 1]; ++v) {
      const CameraVisit& visit = layout.visits[v];
      ASSERT_LT(p, visit.end);
      observed[visit.camera] = true;
      for (; p < visit.end; ++p) {
        ASSERT_EQ(layout.places[first + p], places[p]);
        ASSERT_EQ(layout.camera[first + places[p]], visit.camera);
      }
    }
    ASSERT_EQ(p, count);
  }
  EXPECT_EQ(layout.observed, observed);
}

void expect_same(const Layout& a, const Layout& b) {
  EXPECT_EQ(a.points, b.points);
  EXPECT_EQ(a.starts, b.starts);
  EXPECT_EQ(a.camera, b.camera);
  EXPECT_EQ(a.uv, b.uv);
  EXPECT_EQ(a.observed, b.observed);
  EXPECT_EQ(a.chunks, b.chunks);
  EXPECT_EQ(a.windows, b.windows);
  EXPECT_EQ(a.chunk_windows, b.chunk_windows);
  EXPECT_EQ(a.places, b.places);
  EXPECT_EQ(a.window_visits, b.window_visits);
  ASSERT_EQ(a.visits.size(), b.visits.size());
  for (std::size_t v = 0; v < a.visits.size(); ++v) {
    ASSERT_EQ(a.visits[v].camera, b.visits[v].camera);
    ASSERT_EQ(a.visits[v].end, b.visits[v].end);
  }
}

void expect_same(const SchurPattern& a, const SchurPattern& b) {
  EXPECT_EQ(a.active, b.active);
  EXPECT_EQ(a.starts, b.starts);
  EXPECT_EQ(a.columns, b.columns);
  EXPECT_EQ(a.diagonal_only, b.diagonal_only);
  EXPECT_EQ(a.num_pairs, b.num_pairs);
}

void expect_same(const ProductPlan& a, const ProductPlan& b) {
  const auto window = [](const ProductWindow& x) {
    return std::tuple(x.landmark_begin, x.landmark_end, x.visits_begin, x.visits_end,
                      x.products_begin, x.is_planned);
  };
  const auto visit = [](const BlockVisit& x) { return std::tuple(x.row, x.block, x.products_end); };
  const auto product = [](const Product& x) { return std::pair(x.i, x.k); };
  const auto compare = [](const auto& x, const auto& y, const auto& fields) {
    ASSERT_EQ(x.size(), y.size());
    for (std::size_t i = 0; i < x.size(); ++i) ASSERT_EQ(fields(x[i]), fields(y[i])) << i;
  };
  compare(a.windows, b.windows, window);
  compare(a.visits, b.visits, visit);
  compare(a.products, b.products, product);
}

TEST_P(Preprocessing, TablesAreTheSameForAnyNumberOfThreads) {
  const auto num_cameras = static_cast<std::size_t>(problem_.num_cameras());
  std::vector<unsigned char> some(num_cameras, 1);
  std::fill_n(some.begin(), num_cameras / 3, 0);  // whole windows without a moving camera
  if (num_cameras > 50) some[50] = 0;
  ThreadPool one(1);
  const Layout layout(problem_, PointKind::XYZ, one);
  for (const int num_threads : {1, 2, 4}) {
    SCOPED_TRACE(num_threads);
    ThreadPool pool(num_threads);
    expect_same(Layout(problem_, PointKind::XYZ, pool), layout);
    for (const auto& active : {std::vector<unsigned char>(num_cameras, 1), some}) {
      const SchurPattern pattern(layout, active, one);
      expect_same(SchurPattern(layout, active, pool), pattern);
      expect_same(ProductPlan(layout, pattern, pool), ProductPlan(layout, pattern, one));
      const SchurPattern diagonal = SchurPattern::diagonal(active);
      expect_same(ProductPlan(layout, diagonal, pool), ProductPlan(layout, diagonal, one));
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Problems, Preprocessing, testing::ValuesIn(kCases), [](const auto& param) {
  return std::string(param.param.name);
});

TEST(Layout, HasNoWindowsWithoutObservations) {
  BalProblem problem = test::random_tracks(3, 1, 3);
  problem.camera_index.resize(0);
  problem.point_index.resize(0);
  problem.observations.resize(0, 2);
  const Layout layout(problem);
  EXPECT_EQ(layout.num_landmarks(), 0);
  EXPECT_EQ(layout.num_windows(), 0);
  const SchurPattern pattern(layout, {1, 1, 1});
  EXPECT_EQ(pattern.num_blocks(), 0);
  EXPECT_TRUE(ProductPlan(layout, pattern).products.empty());
}

}  // namespace
}  // namespace raylign::native
