// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/product_plan.h"

#include <algorithm>
#include <memory>
#include <utility>

#include "raylign/bundle/native/parallel.h"
#include "raylign/bundle/native/window_tracks.h"

namespace raylign::native {
namespace {

// Sorts the products of one window after another by block, equal blocks in their order: a counting
// sort over the pairs of the window's cameras.
class WindowPlanner {
 public:
  WindowPlanner(const Layout& layout, const SchurPattern& pattern)
      : layout_(layout),
        pattern_(pattern),
        tracks_(layout, pattern.active, pattern.diagonal_only) {}

  std::int64_t num_visits(int window) {
    tracks_.load(window);
    std::int64_t count = 0;
    for (const std::uint64_t bits : tracks_.rows()) count += __builtin_popcountll(bits);
    return count;
  }
  std::int64_t num_products() const { return tracks_.num_products(); }  // of that window

  void write(int window, BlockVisit* visits, Product* products) {
    tracks_.load(window);
    const std::int64_t num_cameras = tracks_.num_cameras();
    next_.assign(num_cameras * num_cameras, 0);
    using Sight = WindowTracks::Sight;
    tracks_.for_each_product(
        [&](const Sight& i, const Sight& k) { ++next_[i.camera * num_cameras + k.camera]; });
    write_visits(window, visits);
    tracks_.for_each_product([&](const Sight& i, const Sight& k) {
      products[next_[i.camera * num_cameras + k.camera]++] = {i.place, k.place};
    });
  }

 private:
  // From here on `next_` says where the next product of each pair goes.
  void write_visits(int window, BlockVisit* visits) {
    const CameraVisit* cameras = layout_.visits.data() + layout_.window_visits[window];
    std::int32_t sum = 0;
    for (int c = 0; c < tracks_.num_cameras(); ++c) {
      const std::int32_t i = cameras[c].camera;
      std::int32_t* next = next_.data() + std::int64_t{c} * tracks_.num_cameras();
      std::int64_t block = pattern_.starts[i];
      std::int32_t before = i;  // the camera of that block
      WindowTracks::for_each_bit(tracks_.row(c), tracks_.num_words(), [&](int k) {
        block = find_block(i, block, before, cameras[k].camera);
        before = cameras[k].camera;
        sum += std::exchange(next[k], sum);
        *visits++ = {i, static_cast<std::int32_t>(block), sum};
      });
    }
  }

  // Block (i, k), when block `first` of that row is (i, before) and before <= k. It is no farther
  // from there than k is from `before`, and mostly just as far: rows have few gaps.
  std::int64_t find_block(std::int32_t i,
                          std::int64_t first,
                          std::int32_t before,
                          std::int32_t k) const {
    const std::int32_t* columns = pattern_.columns.data();
    const std::int64_t last = std::min(first + (k - before), pattern_.starts[i + 1] - 1);
    if (columns[last] == k) return last;
    return std::lower_bound(columns + first, columns + last, k) - columns;
  }

  const Layout& layout_;
  const SchurPattern& pattern_;
  WindowTracks tracks_;
  std::vector<std::int32_t> next_;  // (num_cameras, num_cameras)
};

// Counts become where each window begins.
template <typename T>
T sum_before(std::vector<ProductWindow>& windows, T ProductWindow::* count) {
  T sum = 0;
  for (ProductWindow& window : windows) sum += std::exchange(window.*count, sum);
  return sum;
}

}  // namespace

ProductPlan::ProductPlan(const Layout& layout, const SchurPattern& pattern)
    : ProductPlan(layout, pattern, *std::make_unique<ThreadPool>(1)) {}

ProductPlan::ProductPlan(const Layout& layout, const SchurPattern& pattern, ThreadPool& pool)
    : windows(layout.num_windows()) {
  const auto for_each_planned = [&](const auto& task) {
    run_tasks(pool, layout.num_chunks(), [&](int g) {
      WindowPlanner planner(layout, pattern);
      for (auto w = layout.chunk_windows[g]; w < layout.chunk_windows[g + 1]; ++w) {
        if (!layout.is_long(layout.windows[w])) task(planner, w, windows[w]);
      }
    });
  };
  for_each_planned([](WindowPlanner& planner, int w, ProductWindow& window) {
    window.is_planned = true;
    window.visits_begin = planner.num_visits(w);
    window.products_begin = planner.num_products();
  });
  visits.resize(sum_before(windows, &ProductWindow::visits_begin));
  products.resize(sum_before(windows, &ProductWindow::products_begin));
  for (int w = 0; w < layout.num_windows(); ++w) {
    const bool is_last = w + 1 == layout.num_windows();
    windows[w].landmark_begin = layout.windows[w];
    windows[w].landmark_end = layout.windows[w + 1];
    windows[w].visits_end =
        is_last ? static_cast<std::int64_t>(visits.size()) : windows[w + 1].visits_begin;
  }
  for_each_planned([&](WindowPlanner& planner, int w, ProductWindow& window) {
    planner.write(w, visits.data() + window.visits_begin, products.data() + window.products_begin);
  });
}

}  // namespace raylign::native
