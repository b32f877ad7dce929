// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/supernodal_cholesky.h"

#include <algorithm>
#include <cmath>
#include <utility>

#include "raylign/solver/blas.h"
#include "raylign/solver/lapack.h"

namespace raylign::native {
namespace {

constexpr int kPanel = 128;  // pivots that are factored by one call
constexpr int kRows = 256;   // of a panel, solved by one task
constexpr int kStrip = 64;   // columns of an update, computed by one task

constexpr double kOne = 1.0;
constexpr double kMinusOne = -1.0;
constexpr int kStep = 1;

int num_parts(int size, int part) { return (size + part - 1) / part; }

// An update of `rows` rows: strips of kStrip columns, each from its first diagonal element down.
std::int64_t strip_begin(int rows, std::int64_t strip) {
  return kStrip * (strip * rows - kStrip * strip * (strip - 1) / 2);
}
int strip_height(int rows, int strip) { return rows - strip * kStrip; }
std::int64_t update_size(int rows) {
  const int last = num_parts(rows, kStrip) - 1;
  if (rows == 0) return 0;
  const std::int64_t height = strip_height(rows, last);
  return strip_begin(rows, last) + height * height;
}

// Runs the parts of one front after each other.
struct Alone {
  template <typename Task>
  void operator()(int count, const Task& task) const {
    for (int i = 0; i < count; ++i) task(i);
  }
};

// Where matrices that live for a while may lie in one table: the first gap that is large enough.
class Places {
 public:
  explicit Places(std::int64_t begin) : begin_(begin), end_(begin) {}

  std::int64_t take(std::int64_t size) {
    std::int64_t at = begin_;
    auto next = taken_.begin();
    for (; next != taken_.end() && next->first - at < size; ++next) at = next->second;
    taken_.insert(next, {at, at + size});
    end_ = std::max(end_, at + size);
    return at;
  }
  void give_back(std::int64_t at) {
    taken_.erase(std::find_if(taken_.begin(), taken_.end(),
                              [&](const auto& place) { return place.first == at; }));
  }
  std::int64_t end() const { return end_; }

 private:
  std::int64_t begin_, end_;
  std::vector<std::pair<std::int64_t, std::int64_t>> taken_;  // ascending
};

}  // namespace

SupernodalCholesky::SupernodalCholesky(const CameraBlocks& cameras,
                                       const SchurPattern& pattern,
                                       std::vector<std::int32_t> order,
                                       ThreadPool& pool)
    : cameras_(cameras),
      pool_(pool),
      order_(std::move(order)),
      offsets_{0},
      tree_(pattern, order_),
      fronts_(tree_.nodes.size()),
      subtree_is_definite_(tree_.subtrees.size()) {
  for (const std::int32_t i : order_) offsets_.push_back(offsets_.back() + cameras.size(i));
  measure_fronts();
  find_entries(pattern);
  find_runs();
  place_updates();
  x_.resize(offsets_.back());
}

void SupernodalCholesky::measure_fronts() {
  std::int64_t size = 0;
  std::size_t height = 0;
  for (std::size_t n = 0; n < fronts_.size(); ++n) {
    const Supernode& node = tree_.nodes[n];
    Front& front = fronts_[n];
    front.num_pivots = offsets_[node.end] - offsets_[node.first];
    for (const std::int32_t p : node.rows) front.num_rows += offsets_[p + 1] - offsets_[p];
    front.panel = size;
    size += std::int64_t{front.height()} * front.num_pivots;
    height = std::max(height, static_cast<std::size_t>(front.height()));
    if (node.parent >= 0) fronts_[node.parent].children.push_back(static_cast<std::int32_t>(n));
  }
  L_.resize(size);
  work_.resize(height);
}

void SupernodalCholesky::find_entries(const SchurPattern& pattern) {
  std::vector<std::int32_t> position(pattern.num_cameras(), -1);
  for (std::size_t p = 0; p < order_.size(); ++p) position[order_[p]] = static_cast<int>(p);
  std::vector<std::int32_t> node_of;  // by position
  for (std::size_t n = 0; n < fronts_.size(); ++n) {
    node_of.resize(tree_.nodes[n].end, static_cast<std::int32_t>(n));
  }
  std::vector<std::vector<std::pair<std::int32_t, Entry>>> by_node(fronts_.size());
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const std::int32_t p = position[i];
      const std::int32_t q = position[pattern.columns[b]];
      const std::int32_t column = std::min(p, q);
      const std::int32_t row = std::max(p, q);
      const Supernode& node = tree_.nodes[node_of[column]];
      Entry entry{b,
                  offsets_[row] - offsets_[node.first],
                  offsets_[column] - offsets_[node.first],
                  offsets_[row + 1] - offsets_[row],
                  offsets_[column + 1] - offsets_[column],
                  p <= q};
      by_node[node_of[column]].emplace_back(row, entry);
    }
  }
  // rows beyond the pivots lie one after another in the front
  std::vector<int> place(order_.size());
  for (std::size_t n = 0; n < fronts_.size(); ++n) {
    int next = fronts_[n].num_pivots;
    for (const std::int32_t p : tree_.nodes[n].rows) {
      place[p] = next;
      next += offsets_[p + 1] - offsets_[p];
    }
    for (auto& [row, entry] : by_node[n]) {
      if (row >= tree_.nodes[n].end) entry.row = place[row];
      fronts_[n].entries.push_back(entry);
    }
  }
}

void SupernodalCholesky::find_runs() {
  std::vector<int> place(order_.size());
  for (std::size_t n = 0; n < fronts_.size(); ++n) {
    const Supernode& node = tree_.nodes[n];
    for (auto p = node.first; p < node.end; ++p) place[p] = offsets_[p] - offsets_[node.first];
    int next = fronts_[n].num_pivots;
    for (const std::int32_t p : node.rows) {
      place[p] = next;
      next += offsets_[p + 1] - offsets_[p];
    }
    for (const std::int32_t child : fronts_[n].children) {
      std::vector<Run>& runs = fronts_[child].runs;
      int from = 0;
      for (const std::int32_t p : tree_.nodes[child].rows) {
        const int size = offsets_[p + 1] - offsets_[p];
        if (!runs.empty() && runs.back().to + runs.back().length == place[p]) {
          runs.back().length += size;
        } else {
          runs.push_back({from, place[p], size});
        }
        from += size;
      }
    }
  }
}

// An update lives from the elimination of its supernode to that of the parent; the last ones of the
// subtrees, which run at the same time, to the end.
void SupernodalCholesky::place_updates() {
  std::int64_t begin = 0;
  const auto place = [&](const auto& nodes) {
    Places places(begin);
    for (const std::int32_t n : nodes) {
      Front& front = fronts_[n];
      front.update = places.take(update_size(front.num_rows));
      for (const std::int32_t child : front.children) {
        if (fronts_[child].update >= begin) places.give_back(fronts_[child].update);
      }
    }
    begin = places.end();
  };
  for (const SupernodeTree::Range& subtree : tree_.subtrees) {
    std::vector<std::int32_t> nodes;
    for (auto n = subtree.begin; n < subtree.end; ++n) nodes.push_back(n);
    place(nodes);
  }
  place(tree_.top);
  updates_.resize(begin);
}

// Where row 0 of a column would stand; its rows begin with those of its strip.
double* SupernodalCholesky::update_column(std::int32_t n, int column) {
  const Front& front = fronts_[n];
  const int strip = column / kStrip;
  const std::int64_t height = strip_height(front.num_rows, strip);
  return updates_.data() + front.update + strip_begin(front.num_rows, strip) +
         (column - strip * kStrip) * height - strip * kStrip;
}

// S and the children's updates.
void SupernodalCholesky::assemble(std::int32_t n, const SchurSystem& system) {
  const Front& front = fronts_[n];
  const std::int64_t height = front.height();
  std::fill_n(panel(n), height * front.num_pivots, 0.0);
  std::fill_n(updates_.data() + front.update, update_size(front.num_rows), 0.0);
  for (const Entry& entry : front.entries) {
    const double* block = system.blocks()[entry.block].values;
    for (int a = 0; a < entry.num_columns; ++a) {
      double* out = panel(n) + (entry.column + a) * height + entry.row;
      for (int r = 0; r < entry.num_rows; ++r) {
        out[r] = entry.transposed ? block[a * kRow + r] : block[r * kRow + a];
      }
    }
  }
  for (const std::int32_t child : front.children) add_child(child, n);
}

void SupernodalCholesky::add_child(std::int32_t child, std::int32_t parent) {
  const Front& from = fronts_[child];
  const Front& to = fronts_[parent];
  for (auto first = from.runs.begin(); first != from.runs.end(); ++first) {
    for (int k = 0; k < first->length; ++k) {
      const int column = first->to + k;
      const double* in = update_column(child, first->from + k);
      double* out = column < to.num_pivots
                        ? panel(parent) + std::int64_t{column} * to.height()
                        : update_column(parent, column - to.num_pivots) - to.num_pivots;
      for (int r = k; r < first->length; ++r) out[first->to + r] += in[first->from + r];
      for (auto run = first + 1; run != from.runs.end(); ++run) {
        for (int r = 0; r < run->length; ++r) out[run->to + r] += in[run->from + r];
      }
    }
  }
}

// L of the pivots and the rows, then the update −= L_rows L_rowsᵀ, the triangle above the diagonal
// of its strips too. `run` shares out the parts, each of which is one call.
template <typename RunParts>
bool SupernodalCholesky::eliminate(std::int32_t n, const RunParts& run) {
  const Front& front = fronts_[n];
  const int height = front.height();
  const auto at = [&](int row, int column) {
    return panel(n) + std::int64_t{column} * height + row;
  };
  for (int first = 0; first < front.num_pivots; first += kPanel) {
    const int width = std::min(kPanel, front.num_pivots - first);
    int info = 0;
    dpotrf_("L", &width, at(first, first), &height, &info);
    bool is_definite = info == 0;  // OpenBLAS compares pivots with <= 0: a NaN goes through
    for (int k = first; k < first + width; ++k) is_definite &= std::isfinite(*at(k, k));
    if (!is_definite) return false;
    const int rest = first + width;
    run(num_parts(height - rest, kRows), [&](int part) {
      const int row = rest + part * kRows;
      const int count = std::min(kRows, height - row);
      dtrsm_("R", "L", "T", "N", &count, &width, &kOne, at(first, first), &height, at(row, first),
             &height);
    });
    run(num_parts(front.num_pivots - rest, kStrip), [&](int part) {
      const int column = rest + part * kStrip;
      const int count = std::min(kStrip, front.num_pivots - column);
      const int rows = height - column;
      dgemm_("N", "T", &rows, &count, &width, &kMinusOne, at(column, first), &height,
             at(column, first), &height, &kOne, at(column, column), &height);
    });
  }
  run(num_parts(front.num_rows, kStrip), [&](int part) {
    const int column = part * kStrip;
    const int count = std::min(kStrip, front.num_rows - column);
    const int rows = strip_height(front.num_rows, part);
    const double* L = at(front.num_pivots + column, 0);
    dgemm_("N", "T", &rows, &count, &front.num_pivots, &kMinusOne, L, &height, L, &height, &kOne,
           update_column(n, column) + column, &rows);
  });
  return true;
}

bool SupernodalCholesky::factor(const SchurSystem& system) {
  pool_.run(static_cast<int>(tree_.subtrees.size()), [&](int task) {
    const SupernodeTree::Range& subtree = tree_.subtrees[task];
    bool is_definite = true;
    for (auto n = subtree.begin; n < subtree.end && is_definite; ++n) {
      assemble(n, system);
      is_definite = eliminate(n, Alone{});
    }
    subtree_is_definite_[task] = is_definite ? 1 : 0;
  });
  for (const unsigned char is_definite : subtree_is_definite_) {
    if (is_definite == 0) return false;
  }
  const auto together = [&](int count, const auto& task) { pool_.run(count, task); };
  for (const std::int32_t n : tree_.top) {
    assemble(n, system);
    if (!eliminate(n, together)) return false;
  }
  return true;
}

void SupernodalCholesky::solve(double* x) {
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const int i = order_[p];
    std::copy_n(x + cameras_.offset(i), cameras_.size(i), x_.data() + offsets_[p]);
  }
  const auto rows_of = [&](std::size_t n, auto&& use) {  // use(x, place among the rows)
    double* rows = work_.data();
    for (const std::int32_t p : tree_.nodes[n].rows) {
      for (int k = offsets_[p]; k < offsets_[p + 1]; ++k) use(x_[k], *rows++);
    }
  };
  for (std::size_t n = 0; n < fronts_.size(); ++n) {
    const Front& front = fronts_[n];
    const int height = front.height();
    const double* L = panel(static_cast<std::int32_t>(n));
    double* pivots = x_.data() + offsets_[tree_.nodes[n].first];
    dtrsv_("L", "N", "N", &front.num_pivots, L, &height, pivots, &kStep);
    if (front.num_rows == 0) continue;
    std::fill_n(work_.data(), front.num_rows, 0.0);
    dgemv_("N", &front.num_rows, &front.num_pivots, &kMinusOne, L + front.num_pivots, &height,
           pivots, &kStep, &kOne, work_.data(), &kStep);
    rows_of(n, [](double& value, double change) { value += change; });
  }
  for (std::size_t n = fronts_.size(); n-- > 0;) {
    const Front& front = fronts_[n];
    const int height = front.height();
    const double* L = panel(static_cast<std::int32_t>(n));
    double* pivots = x_.data() + offsets_[tree_.nodes[n].first];
    if (front.num_rows > 0) {
      rows_of(n, [](double value, double& out) { out = value; });
      dgemv_("T", &front.num_rows, &front.num_pivots, &kMinusOne, L + front.num_pivots, &height,
             work_.data(), &kStep, &kOne, pivots, &kStep);
    }
    dtrsv_("L", "T", "N", &front.num_pivots, L, &height, pivots, &kStep);
  }
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const int i = order_[p];
    std::copy_n(x_.data() + offsets_[p], cameras_.size(i), x + cameras_.offset(i));
  }
}

}  // namespace raylign::native
