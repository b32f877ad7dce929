// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/product_plan.h"

#include <algorithm>
#include <numeric>
#include <utility>

namespace raylign::native {
namespace {

// Collects the products of one window and sorts them by block, equal blocks in their order.
class WindowSorter {
 public:
  explicit WindowSorter(const SchurPattern& pattern) : pattern_(pattern) {}

  void start(std::int64_t max_products) {
    std::size_t size = 64;
    while (size < 2 * static_cast<std::size_t>(max_products)) size *= 2;
    table_.assign(size, kFree);
    visits_.clear();
    found_.clear();
  }

  void add_track(const std::int32_t* cameras, std::int64_t first, std::int64_t length) {
    for (std::int64_t a = first; a < first + length; ++a) {
      if (pattern_.active[cameras[a]] == 0) continue;
      for (std::int64_t b = a; b < first + length; ++b) {
        if (pattern_.active[cameras[b]] == 0) continue;
        if (pattern_.diagonal_only && cameras[b] != cameras[a]) break;
        const std::int32_t visit = visit_of(cameras[a], cameras[b]);
        add(visit, a, b);
        // the same camera twice in a track: both orders fall into one block
        if (a != b && cameras[a] == cameras[b]) add(visit, b, a);
      }
    }
  }

  void write(ProductPlan& plan) {
    order_.resize(visits_.size());
    std::iota(order_.begin(), order_.end(), 0);
    std::sort(order_.begin(), order_.end(), [&](std::int32_t a, std::int32_t b) {
      const Visit& x = visits_[a];
      const Visit& y = visits_[b];
      return x.i != y.i ? x.i < y.i : x.k < y.k;
    });
    const auto base = static_cast<std::int64_t>(plan.products.size());
    plan.products.resize(base + static_cast<std::int64_t>(found_.size()));
    std::int32_t sum = 0;
    for (const std::int32_t v : order_) {
      Visit& visit = visits_[v];
      const std::int32_t end = sum + visit.count;
      plan.visits.push_back({visit.i, pattern_.find(visit.i, visit.k), end});
      visit.count = sum;  // from here on: where its next product goes
      sum = end;
    }
    for (const auto& [visit, product] : found_) {
      plan.products[base + visits_[visit].count++] = product;
    }
  }

 private:
  struct Visit {
    std::int32_t i, k, count;
  };
  static constexpr std::int32_t kFree = -1;

  // Open addressing; there is always room.
  std::int32_t visit_of(std::int32_t i, std::int32_t k) {
    const std::size_t mask = table_.size() - 1;
    std::size_t at =
        (static_cast<std::size_t>(i) * 0x9E3779B1u + static_cast<std::size_t>(k)) & mask;
    for (; table_[at] != kFree; at = (at + 1) & mask) {
      const Visit& visit = visits_[table_[at]];
      if (visit.i == i && visit.k == k) return table_[at];
    }
    table_[at] = static_cast<std::int32_t>(visits_.size());
    visits_.push_back({i, k, 0});
    return table_[at];
  }

  void add(std::int32_t visit, std::int64_t i, std::int64_t k) {
    ++visits_[visit].count;
    found_.push_back({visit, {static_cast<std::uint16_t>(i), static_cast<std::uint16_t>(k)}});
  }

  const SchurPattern& pattern_;
  std::vector<std::int32_t> table_;
  std::vector<Visit> visits_;
  std::vector<std::int32_t> order_;
  std::vector<std::pair<std::int32_t, Product>> found_;
};

std::int64_t num_products(const Layout& layout, const ProductWindow& window) {
  std::int64_t sum = 0;
  for (auto j = window.landmark_begin; j < window.landmark_end; ++j) {
    const std::int64_t length = layout.starts[j + 1] - layout.starts[j];
    sum += length * (length + 1) / 2;
  }
  return sum;
}

}  // namespace

ProductPlan::ProductPlan(const Layout& layout, const SchurPattern& pattern) {
  WindowSorter sorter(pattern);
  products.reserve(pattern.num_pairs);
  windows.reserve(layout.num_windows());
  for (int w = 0; w < layout.num_windows(); ++w) {
    ProductWindow window{};
    window.landmark_begin = layout.windows[w];
    window.landmark_end = layout.windows[w + 1];
    window.products_begin = static_cast<std::int64_t>(products.size());
    window.visits_begin = static_cast<std::int64_t>(visits.size());
    window.is_planned = !layout.is_long(window.landmark_begin);
    if (window.is_planned) {
      const std::int64_t first = layout.starts[window.landmark_begin];
      sorter.start(num_products(layout, window));
      for (auto j = window.landmark_begin; j < window.landmark_end; ++j) {
        sorter.add_track(layout.camera.data() + first, layout.starts[j] - first,
                         layout.starts[j + 1] - layout.starts[j]);
      }
      sorter.write(*this);
    }
    window.visits_end = static_cast<std::int64_t>(visits.size());
    windows.push_back(window);
  }
}

}  // namespace raylign::native
