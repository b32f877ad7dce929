// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/sparse_cholesky.h"

#include <cholmod.h>

#include <algorithm>
#include <limits>
#include <new>

namespace raylign::native {
namespace {

// CHOLMOD's settings and workspace: silent, supernodal.
class Workspace {
 public:
  Workspace() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
    common_.supernodal = CHOLMOD_SUPERNODAL;
    common_.final_ll = 1;
    common_.quick_return_if_not_posdef = 1;
  }
  ~Workspace() { cholmod_finish(&common_); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  cholmod_common* get() { return &common_; }
  cholmod_common* operator->() { return &common_; }

 private:
  cholmod_common common_;
};

struct Sparse {
  Workspace& workspace;
  cholmod_sparse* get = nullptr;
  ~Sparse() { cholmod_free_sparse(&get, workspace.get()); }
};

struct Factor {
  Workspace& workspace;
  cholmod_factor* get = nullptr;
  ~Factor() { cholmod_free_factor(&get, workspace.get()); }
};

int* ints(void* memory) { return static_cast<int*>(memory); }

// The lower triangle of the graph of moving cameras; numbers: camera → node.
cholmod_sparse* make_graph(const SchurPattern& pattern,
                           const std::vector<std::int32_t>& nodes,
                           std::size_t num_nodes,
                           cholmod_common* common) {
  cholmod_sparse* graph = cholmod_allocate_sparse(num_nodes, num_nodes, pattern.num_blocks(), 1, 1,
                                                  -1, CHOLMOD_PATTERN, common);
  if (graph == nullptr) throw std::bad_alloc();
  int* starts = ints(graph->p);
  int* rows = ints(graph->i);
  starts[0] = 0;
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    if (pattern.active[i] == 0) continue;
    int next = starts[nodes[i]];
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      rows[next++] = nodes[pattern.columns[b]];
    }
    starts[nodes[i] + 1] = next;
  }
  return graph;
}

}  // namespace

bool has_sparse_cholesky() { return true; }

SparseOrdering order_cameras(const SchurPattern& pattern) {
  std::vector<std::int32_t> nodes(pattern.num_cameras(), -1);
  std::vector<std::int32_t> moving;
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    if (pattern.active[i] == 0) continue;
    nodes[i] = static_cast<std::int32_t>(moving.size());
    moving.push_back(i);
  }
  SparseOrdering best;
  if (moving.empty()) return best;
  Workspace workspace;
  workspace->supernodal = CHOLMOD_SIMPLICIAL;  // no values, no supernodes: counts only
  workspace->nmethods = 1;
  const Sparse graph{workspace, make_graph(pattern, nodes, moving.size(), workspace.get())};
  for (const int method : {CHOLMOD_AMD, CHOLMOD_METIS}) {
    workspace->method[0].ordering = method;
    const Factor factor{workspace, cholmod_analyze(graph.get, workspace.get())};
    if (factor.get == nullptr) continue;
    constexpr double kSize = 9.0;  // columns per camera
    const double flops = workspace->fl * kSize * kSize * kSize;
    if (!best.cameras.empty() && flops >= best.flops) continue;
    best.method = method == CHOLMOD_AMD ? "amd" : "metis";
    best.flops = flops;
    best.nonzeros = workspace->lnz * kSize * kSize;
    best.cameras.clear();
    for (std::size_t p = 0; p < moving.size(); ++p) {
      best.cameras.push_back(moving[ints(factor.get->Perm)[p]]);
    }
  }
  if (best.cameras.empty()) throw std::bad_alloc();
  return best;
}

namespace {

// S in the order of elimination, lower triangle by columns: "natural, lower" is what CHOLMOD
// factors without a copy.
class SparseCholesky : public SchurFactor {
 public:
  SparseCholesky(const CameraBlocks& cameras,
                 const SchurPattern& pattern,
                 const std::vector<std::int32_t>& order);
  ~SparseCholesky() override;
  bool factor(const SchurSystem& system) override;
  void solve(double* x) override;

 private:
  // Block of S below the diagonal of a column of cameras, and whether it is held transposed.
  struct Entry {
    std::int64_t block;
    std::int32_t position;  // of its row camera in the order
    bool transposed;        // stored as (column camera, row camera)
  };

  void find_entries(const SchurPattern& pattern);
  void allocate();
  void fill(const SchurSystem& system);

  const CameraBlocks& cameras_;
  std::vector<std::int32_t> order_;
  std::vector<int> offsets_;  // first column of each position
  std::vector<std::int64_t> starts_;
  std::vector<Entry> entries_;  // by position of the column, then of the row
  Workspace workspace_;
  cholmod_sparse* matrix_ = nullptr;
  cholmod_factor* factor_ = nullptr;
  cholmod_dense* rhs_ = nullptr;
  cholmod_dense* solution_ = nullptr;
  cholmod_dense* work_y_ = nullptr;
  cholmod_dense* work_e_ = nullptr;
};

SparseCholesky::SparseCholesky(const CameraBlocks& cameras,
                               const SchurPattern& pattern,
                               const std::vector<std::int32_t>& order)
    : cameras_(cameras), order_(order), offsets_{0} {
  for (const std::int32_t i : order_) offsets_.push_back(offsets_.back() + cameras.size(i));
  find_entries(pattern);
  allocate();
}

SparseCholesky::~SparseCholesky() {
  cholmod_free_sparse(&matrix_, workspace_.get());
  cholmod_free_factor(&factor_, workspace_.get());
  for (cholmod_dense** dense : {&rhs_, &solution_, &work_y_, &work_e_}) {
    cholmod_free_dense(dense, workspace_.get());
  }
}

void SparseCholesky::find_entries(const SchurPattern& pattern) {
  const auto count = static_cast<std::int32_t>(order_.size());
  std::vector<std::int32_t> position(pattern.num_cameras(), -1);
  for (std::int32_t p = 0; p < count; ++p) position[order_[p]] = p;
  starts_.assign(count + 1, 0);
  const auto visit = [&](auto&& use) {
    for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
      for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
        const std::int32_t p = position[i];
        const std::int32_t q = position[pattern.columns[b]];
        use(std::min(p, q), Entry{b, std::max(p, q), p <= q});
      }
    }
  };
  visit([&](std::int32_t column, const Entry&) { ++starts_[column + 1]; });
  for (std::int32_t p = 0; p < count; ++p) starts_[p + 1] += starts_[p];
  entries_.resize(starts_.back());
  std::vector<std::int64_t> next(starts_.begin(), starts_.end() - 1);
  visit([&](std::int32_t column, const Entry& entry) { entries_[next[column]++] = entry; });
  for (std::int32_t p = 0; p < count; ++p) {
    std::sort(entries_.begin() + starts_[p], entries_.begin() + starts_[p + 1],
              [](const Entry& a, const Entry& b) { return a.position < b.position; });
  }
}

// Column a of a camera holds rows a … of its own block, then the whole of the others.
void SparseCholesky::allocate() {
  const auto n = static_cast<std::size_t>(offsets_.back());
  std::size_t num_nonzeros = 0;
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const int size = offsets_[p + 1] - offsets_[p];
    for (auto e = starts_[p]; e < starts_[p + 1]; ++e) {
      const std::int32_t q = entries_[e].position;
      num_nonzeros += static_cast<std::size_t>(size) * (offsets_[q + 1] - offsets_[q]);
    }
    num_nonzeros -= static_cast<std::size_t>(size) * (size - 1) / 2;
  }
  matrix_ = cholmod_allocate_sparse(n, n, num_nonzeros, 1, 1, -1, CHOLMOD_REAL, workspace_.get());
  rhs_ = cholmod_allocate_dense(n, 1, n, CHOLMOD_REAL, workspace_.get());
  if (matrix_ == nullptr || rhs_ == nullptr) throw std::bad_alloc();
  int* starts = ints(matrix_->p);
  int* rows = ints(matrix_->i);
  int next = 0;
  for (std::size_t p = 0; p < order_.size(); ++p) {
    for (int column = offsets_[p]; column < offsets_[p + 1]; ++column) {
      starts[column] = next;
      for (auto e = starts_[p]; e < starts_[p + 1]; ++e) {
        const std::int32_t q = entries_[e].position;
        for (int row = std::max(offsets_[q], column); row < offsets_[q + 1]; ++row) {
          rows[next++] = row;
        }
      }
    }
  }
  starts[n] = next;
  workspace_->nmethods = 1;
  workspace_->method[0].ordering = CHOLMOD_NATURAL;
  workspace_->postorder = 0;  // the order of the cameras is one already
  factor_ = cholmod_analyze(matrix_, workspace_.get());
  if (factor_ == nullptr) throw std::bad_alloc();
}

void SparseCholesky::fill(const SchurSystem& system) {
  const int* starts = ints(matrix_->p);
  auto* values = static_cast<double*>(matrix_->x);
  for (std::size_t p = 0; p < order_.size(); ++p) {
    for (int column = offsets_[p]; column < offsets_[p + 1]; ++column) {
      const int a = column - offsets_[p];
      double* out = values + starts[column];
      for (auto e = starts_[p]; e < starts_[p + 1]; ++e) {
        const Entry& entry = entries_[e];
        const std::int32_t q = entry.position;
        const double* block = system.blocks()[entry.block].values;
        const int first = static_cast<std::size_t>(q) == p ? a : 0;
        const int last = offsets_[q + 1] - offsets_[q];
        for (int row = first; row < last; ++row) {
          *out++ = entry.transposed ? block[a * kRow + row] : block[row * kRow + a];
        }
      }
    }
  }
}

bool SparseCholesky::factor(const SchurSystem& system) {
  fill(system);
  const int done = cholmod_factorize(matrix_, factor_, workspace_.get());
  if (workspace_->status == CHOLMOD_OUT_OF_MEMORY) throw std::bad_alloc();
  return done != 0 && workspace_->status == CHOLMOD_OK && factor_->minor == factor_->n;
}

void SparseCholesky::solve(double* x) {
  auto* b = static_cast<double*>(rhs_->x);
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const int i = order_[p];
    std::copy_n(x + cameras_.offset(i), cameras_.size(i), b + offsets_[p]);
  }
  cholmod_solve2(CHOLMOD_A, factor_, rhs_, nullptr, &solution_, nullptr, &work_y_, &work_e_,
                 workspace_.get());
  if (solution_ == nullptr) throw std::bad_alloc();
  const auto* solution = static_cast<const double*>(solution_->x);
  for (std::size_t p = 0; p < order_.size(); ++p) {
    const int i = order_[p];
    std::copy_n(solution + offsets_[p], cameras_.size(i), x + cameras_.offset(i));
  }
}

}  // namespace

std::unique_ptr<SchurFactor> make_sparse_cholesky(const CameraBlocks& cameras,
                                                  const SchurPattern& pattern,
                                                  const SparseOrdering& ordering) {
  return std::make_unique<SparseCholesky>(cameras, pattern, ordering.cameras);
}

}  // namespace raylign::native
