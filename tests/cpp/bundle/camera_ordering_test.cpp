// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_ordering.h"

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <numeric>

#include "raylign/bundle/native/camera_graph.h"
#include "raylign/bundle/native/elimination_tree.h"
#include "raylign/bundle/native/minimum_degree.h"
#include "raylign/bundle/native/nested_dissection.h"
#include "raylign/synthetic/bal.h"

namespace raylign::native {
namespace {

constexpr int kHeld = 7;  // a camera that does not move

SchurPattern make_pattern(SyntheticBalKind kind, int num_cameras) {
  SyntheticBalOptions options;
  options.kind = kind;
  options.num_cameras = num_cameras;
  options.num_points = 30 * num_cameras;
  options.seed = 3;
  const Layout layout(synthetic_bal(options).problem);
  std::vector<unsigned char> active(num_cameras, 1);
  active[kHeld] = 0;
  return {layout, active};
}

std::vector<std::int32_t> natural_order(const CameraGraph& graph) {
  std::vector<std::int32_t> order(graph.num_nodes());
  std::iota(order.begin(), order.end(), 0);
  return order;
}

// Entries of the factor, found by eliminating the graph node by node.
Eigen::MatrixXi eliminated(const CameraGraph& graph, const std::vector<std::int32_t>& order) {
  Eigen::MatrixXi full = Eigen::MatrixXi::Zero(graph.num_nodes(), graph.num_nodes());
  for (std::int32_t n = 0; n < graph.num_nodes(); ++n) {
    for (auto e = graph.starts[n]; e < graph.starts[n + 1]; ++e) full(n, graph.neighbours[e]) = 1;
  }
  Eigen::MatrixXi factor(full.rows(), full.cols());
  for (Eigen::Index p = 0; p < full.rows(); ++p) {
    for (Eigen::Index q = 0; q < full.rows(); ++q) factor(p, q) = full(order[p], order[q]);
  }
  for (Eigen::Index p = 0; p < factor.rows(); ++p) {
    for (Eigen::Index i = p + 1; i < factor.rows(); ++i) {
      for (Eigen::Index k = p + 1; k < factor.rows(); ++k) {
        if (factor(i, p) != 0 && factor(k, p) != 0) factor(i, k) = 1;
      }
    }
  }
  return factor.triangularView<Eigen::Lower>();
}

class CameraOrdering : public testing::TestWithParam<SyntheticBalKind> {
 protected:
  SchurPattern pattern_ = make_pattern(GetParam(), 60);
  CameraGraph graph_{pattern_};
};

TEST_P(CameraOrdering, GraphHasTheBlocksOfMovingCameras) {
  ASSERT_EQ(graph_.num_nodes(), pattern_.num_cameras() - 1);
  std::int64_t num_blocks = 0;
  for (std::int32_t n = 0; n < graph_.num_nodes(); ++n) {
    const auto begin = graph_.neighbours.begin() + graph_.starts[n];
    const auto end = graph_.neighbours.begin() + graph_.starts[n + 1];
    EXPECT_TRUE(std::is_sorted(begin, end));
    EXPECT_EQ(std::count(begin, end, n), 1);
    for (auto neighbour = begin; neighbour != end; ++neighbour) {
      const auto [i, k] = std::minmax(graph_.cameras[n], graph_.cameras[*neighbour]);
      const std::int32_t block = pattern_.find(i, k);
      num_blocks += pattern_.columns[block] == k ? 1 : 0;
    }
  }
  EXPECT_EQ(num_blocks, 2 * pattern_.num_blocks() - graph_.num_nodes());
}

TEST_P(CameraOrdering, CountsWhatEliminationFills) {
  for (const auto& order :
       {natural_order(graph_), minimum_degree(graph_), nested_dissection(graph_)}) {
    if (order.empty()) continue;  // a build without CHOLMOD
    const EliminationTree tree(graph_, order);
    const Eigen::MatrixXi factor = eliminated(graph_, order);
    for (Eigen::Index p = 0; p < factor.cols(); ++p) {
      EXPECT_EQ(tree.counts[p], factor.col(p).sum());
      Eigen::Index parent = p + 1;
      while (parent < factor.rows() && factor(parent, p) == 0) ++parent;
      EXPECT_EQ(tree.parents[p], parent < factor.rows() ? parent : -1);
    }
  }
}

TEST_P(CameraOrdering, PostorderKeepsTheFillAndMakesSubtreesRangesTheLongestLast) {
  const EliminationTree tree(graph_, natural_order(graph_));
  const auto order = tree.postorder();  // of nodes in their natural order
  const EliminationTree again(graph_, order);
  std::vector<std::int32_t> first(order.size());
  std::iota(first.begin(), first.end(), 0);
  for (std::size_t p = 0; p < order.size(); ++p) {
    EXPECT_EQ(again.counts[p], tree.counts[order[p]]);
    const std::int32_t parent = again.parents[p];
    EXPECT_EQ(parent < 0 ? -1 : order[parent], tree.parents[order[p]]);
    if (parent < 0) continue;
    first[parent] = std::min(first[parent], first[p]);
    if (static_cast<std::int32_t>(p) + 1 < parent) continue;  // the last of its siblings
    for (std::size_t q = 0; q < p; ++q) {
      EXPECT_TRUE(again.parents[q] != parent || again.counts[q] <= again.counts[p]);
    }
  }
  std::vector<std::int32_t> size(order.size(), 1);
  for (std::size_t p = 0; p < order.size(); ++p) {
    EXPECT_EQ(first[p] + size[p], static_cast<std::int32_t>(p) + 1);
    if (again.parents[p] >= 0) size[again.parents[p]] += size[p];
  }
  EXPECT_EQ(again.postorder(), natural_order(graph_));
}

TEST_P(CameraOrdering, NamesEachMovingCameraOnceAndCountsNineColumnsForIt) {
  const SparseOrdering found = order_cameras(pattern_);
  auto sorted = found.cameras;
  std::sort(sorted.begin(), sorted.end());
  EXPECT_EQ(sorted, graph_.cameras);
  std::vector<std::int32_t> nodes;
  for (const std::int32_t camera : found.cameras) nodes.push_back(camera - (camera > kHeld));
  const Eigen::VectorXd counts =
      eliminated(graph_, nodes).cast<double>().colwise().sum().transpose();
  EXPECT_DOUBLE_EQ(found.flops, 729.0 * counts.squaredNorm());
  EXPECT_DOUBLE_EQ(found.nonzeros, 81.0 * counts.sum());
  EXPECT_EQ(EliminationTree(graph_, nodes).postorder(), natural_order(graph_));
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         CameraOrdering,
                         testing::Values(SyntheticBalKind::STREET, SyntheticBalKind::ORBIT));

double flops(const CameraGraph& graph, const std::vector<std::int32_t>& order) {
  double sum = 0.0;
  for (const double count : EliminationTree(graph, order).counts) sum += count * count;
  return 729.0 * sum;
}

TEST(CameraOrderingOf, AStreetIsTheCheaperOneAndSavesWork) {
  const SchurPattern pattern = make_pattern(SyntheticBalKind::STREET, 200);
  const CameraGraph graph(pattern);
  const double natural = flops(graph, natural_order(graph));
  const double by_degree = flops(graph, minimum_degree(graph));
  const auto dissected = nested_dissection(graph);
  const double by_dissection = dissected.empty() ? by_degree : flops(graph, dissected);
  EXPECT_LT(by_degree, 0.6 * natural);
  EXPECT_LT(by_dissection, 0.6 * natural);
  const SparseOrdering found = order_cameras(pattern);
  EXPECT_EQ(found.flops, std::min(by_degree, by_dissection));
  EXPECT_STREQ(found.method, by_dissection < by_degree ? "metis" : "amd");
}

TEST(CameraOrderingOf, NoMovingCameraIsEmpty) {
  const auto none = SchurPattern::diagonal({0, 0});
  EXPECT_TRUE(order_cameras(none).cameras.empty());
  EXPECT_EQ(order_cameras(SchurPattern::diagonal({0, 1})).cameras, (std::vector<std::int32_t>{1}));
}

}  // namespace
}  // namespace raylign::native
