// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/minimum_degree.h"

#include <Eigen/OrderingMethods>
#include <Eigen/SparseCore>

namespace raylign::native {

std::vector<std::int32_t> minimum_degree(const CameraGraph& graph) {
  using Matrix = Eigen::SparseMatrix<float, Eigen::ColMajor, std::int32_t>;
  const std::int32_t n = graph.num_nodes();
  const std::vector<float> ones(graph.neighbours.size(), 1.0F);
  const Eigen::Map<const Matrix> matrix(n, n, static_cast<std::int32_t>(ones.size()),
                                        graph.starts.data(), graph.neighbours.data(), ones.data());
  Eigen::AMDOrdering<std::int32_t>::PermutationType order;
  Eigen::AMDOrdering<std::int32_t>()(matrix.selfadjointView<Eigen::Lower>(), order);
  return {order.indices().begin(), order.indices().end()};
}

}  // namespace raylign::native
