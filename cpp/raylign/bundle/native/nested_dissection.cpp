// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/nested_dissection.h"

#include <cholmod.h>

namespace raylign::native {
namespace {

// CHOLMOD's settings and workspace: silent.
class Workspace {
 public:
  Workspace() {
    cholmod_start(&common_);
    common_.print = 0;
    common_.error_handler = nullptr;
  }
  ~Workspace() { cholmod_finish(&common_); }
  Workspace(const Workspace&) = delete;
  Workspace& operator=(const Workspace&) = delete;
  cholmod_common* get() { return &common_; }

 private:
  cholmod_common common_;
};

// CHOLMOD's view of the graph; its interface has no const.
cholmod_sparse view(std::vector<std::int32_t>& starts,
                    std::vector<std::int32_t>& neighbours,
                    std::int32_t num_nodes) {
  cholmod_sparse sparse{};
  sparse.nrow = sparse.ncol = num_nodes;
  sparse.nzmax = neighbours.size();
  sparse.p = starts.data();
  sparse.i = neighbours.data();
  sparse.stype = -1;  // reads the entries below the diagonal
  sparse.itype = CHOLMOD_INT;
  sparse.xtype = CHOLMOD_PATTERN;
  sparse.dtype = CHOLMOD_DOUBLE;
  sparse.sorted = sparse.packed = 1;
  return sparse;
}

}  // namespace

std::vector<std::int32_t> nested_dissection(const CameraGraph& graph) {
  auto starts = graph.starts;
  auto neighbours = graph.neighbours;
  cholmod_sparse sparse = view(starts, neighbours, graph.num_nodes());
  std::vector<std::int32_t> order(graph.num_nodes());
  Workspace workspace;
  const int found = cholmod_metis(&sparse, nullptr, 0, 0, order.data(), workspace.get());
  if (found == 0) order.clear();
  return order;
}

}  // namespace raylign::native
