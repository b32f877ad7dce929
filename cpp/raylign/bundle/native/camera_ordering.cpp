// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_ordering.h"

#include <cholmod.h>

#include <algorithm>
#include <new>

namespace raylign::native {
namespace {

// CHOLMOD's settings and workspace: silent, and counts alone.
class Workspace {
 public:
  Workspace() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
    common_.supernodal = CHOLMOD_SIMPLICIAL;  // no values, no supernodes
    common_.nmethods = 1;
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

}  // namespace raylign::native
