// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/supernodal_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <limits>

#include "bundle/reference.h"
#include "raylign/bundle/native/camera_ordering.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/parametrization/constants.h"
#include "raylign/synthetic/bal.h"
#include "support/named_rng.h"

namespace raylign::native {
namespace {

BundleConfig held_config() {
  BundleConfig config;
  config.constant_cameras = {4, 5};
  config.constant_intrinsics = {5, 7, 8};
  return config;
}

// A formed S and the order of its cameras.
struct Formed {
  Formed(SyntheticBalKind kind, int num_cameras, bool held)
      : Formed(problem(kind, num_cameras), held) {}
  Formed(const BalProblem& scene, bool held)
      : native(scene, resolve_constants(scene, held ? held_config() : BundleConfig{}), {}) {
    native.linearize();
    system.form(native.damped(1e-4));
    order = order_cameras(system.pattern()).cameras;
  }
  static BalProblem problem(SyntheticBalKind kind, int num_cameras) {
    SyntheticBalOptions options;
    options.kind = kind;
    options.num_cameras = num_cameras;
    options.num_points = 30 * num_cameras;
    options.seed = 11;
    return synthetic_bal(options).problem;
  }
  Eigen::VectorXd random_columns() const {
    auto rng = test::make_rng("columns");
    Eigen::VectorXd b(native.cameras().num_columns());
    for (double& x : b) x = rng.normal();
    return b;
  }
  SupernodalCholesky factor(ThreadPool& pool) const {
    return {native.cameras(), system.pattern(), order, pool};
  }

  ReprojectionProblem native;
  SchurSystem system{{native.layout(), native.cameras(), native.pool()},
                     SchurPattern(native.layout(), moving_cameras(native.cameras()))};
  std::vector<std::int32_t> order;
};

class SupernodalCholeskyOf : public testing::TestWithParam<std::pair<SyntheticBalKind, bool>> {};

TEST_P(SupernodalCholeskyOf, SolvesAsEigenDoes) {
  Formed s(GetParam().first, 90, GetParam().second);
  ThreadPool pool(1);
  SupernodalCholesky factor = s.factor(pool);
  for (int repeat = 0; repeat < 2; ++repeat) {  // nothing is left of the first time
    ASSERT_TRUE(factor.factor(s.system));
    const Eigen::MatrixXd S = test::dense_schur(s.system);
    const Eigen::VectorXd b = s.random_columns();
    Eigen::VectorXd x = b;
    factor.solve(x.data());
    const Eigen::VectorXd e = x - S.llt().solve(b);
    EXPECT_LT(e.dot(S * e), 1e-20 * x.dot(S * x));
  }
}

TEST_P(SupernodalCholeskyOf, HasTheSameBitsOnAnyNumberOfThreads) {
  Formed s(GetParam().first, 90, GetParam().second);
  std::vector<Eigen::VectorXd> solutions;
  for (const int num_threads : {1, 2, 4}) {
    ThreadPool pool(num_threads);
    SupernodalCholesky factor = s.factor(pool);
    ASSERT_TRUE(factor.factor(s.system));
    solutions.push_back(s.random_columns());
    factor.solve(solutions.back().data());
    EXPECT_EQ(solutions.back(), solutions.front());
  }
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         SupernodalCholeskyOf,
                         testing::Values(std::pair(SyntheticBalKind::STREET, false),
                                         std::pair(SyntheticBalKind::STREET, true),
                                         std::pair(SyntheticBalKind::ORBIT, false)));

TEST(SupernodeTree, CutsAStreetIntoSubtreesThatKnowNothingOfEachOther) {
  const Formed s(SyntheticBalKind::STREET, 200, false);
  const SupernodeTree tree(s.system.pattern(), s.order);
  EXPECT_GT(tree.subtrees.size(), 4u);
  EXPECT_FALSE(tree.top.empty());
  std::vector<int> owner(tree.nodes.size(), -1);
  for (std::size_t t = 0; t < tree.subtrees.size(); ++t) {
    for (auto n = tree.subtrees[t].begin; n < tree.subtrees[t].end; ++n) {
      EXPECT_EQ(owner[n], -1);
      owner[n] = static_cast<int>(t);
    }
  }
  std::int32_t next = 0;
  for (std::size_t n = 0; n < tree.nodes.size(); ++n) {
    const Supernode& node = tree.nodes[n];
    EXPECT_EQ(node.first, next);  // every camera once
    next = node.end;
    EXPECT_EQ(owner[n] < 0, std::count(tree.top.begin(), tree.top.end(), n) == 1);
    if (node.parent < 0) continue;
    EXPECT_GT(node.parent, static_cast<std::int32_t>(n));
    EXPECT_TRUE(owner[node.parent] == owner[n] || owner[node.parent] < 0);
  }
  EXPECT_EQ(next, static_cast<std::int32_t>(s.order.size()));
}

TEST(SupernodalCholesky, RefusesWhatIsNotPositiveDefinite) {
  Formed s(SyntheticBalKind::STREET, 60, false);
  ThreadPool pool(2);
  SupernodalCholesky factor = s.factor(pool);
  s.system.form(s.native.damped(-1.0));
  EXPECT_FALSE(factor.factor(s.system));
  s.system.form(s.native.damped(std::numeric_limits<double>::quiet_NaN()));
  EXPECT_FALSE(factor.factor(s.system));
  s.system.form(s.native.damped(1e-4));
  EXPECT_TRUE(factor.factor(s.system));
}

}  // namespace
}  // namespace raylign::native
