// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/solver_costs.h"

#include <gtest/gtest.h>

#include <cmath>

namespace raylign::native {
namespace {

SolveMethod choose(const SolveCounts& counts) { return cheapest(predict_costs(counts)); }

TEST(SolverCosts, FactorASmallSDensely) {
  EXPECT_EQ(choose({32e3, 441.0, 160e3, 1225.0, 0.0, 0.0}), SolveMethod::DENSE);
}

// 1778 cameras, two laps: a factor would take longer than all the rest.
TEST(SolverCosts, IterateOnTheSOfALongStreet) {
  EXPECT_EQ(choose({5e6, 16002.0, 23.2e6, 123e3, 37e9, 34e6}), SolveMethod::EXPLICIT_CG);
}

TEST(SolverCosts, FactorAStreetSparsely) {  // 1000 cameras, one lap: 1 GF against 243
  EXPECT_EQ(choose({1.68e6, 9000.0, 8.75e6, 64e3, 1e9, 3e6}), SolveMethod::SPARSE);
}

TEST(SolverCosts, IterateOnACollectionThatNoFactorFits) {  // 1778 cameras, half of all pairs
  const SolveCounts counts{5.58e6, 16002.0, 63e6, 890e3, 0.0, 0.0};
  EXPECT_EQ(choose(counts), SolveMethod::MATRIX_FREE_CG);
  EXPECT_TRUE(std::isinf(predict_costs(counts)[static_cast<int>(SolveMethod::DENSE)]));
}

TEST(SolverCosts, ManyIterationsSpeakForAFactor) {
  SolveCounts counts{360e3, 2250.0, 1.55e6, 6919.0, 0.5e9, 0.6e6};
  counts.cg_iterations = 1.0;
  const double one = predict_costs(counts)[static_cast<int>(SolveMethod::EXPLICIT_CG)];
  counts.cg_iterations = 500.0;
  EXPECT_GT(predict_costs(counts)[static_cast<int>(SolveMethod::EXPLICIT_CG)], one);
  EXPECT_EQ(choose(counts), SolveMethod::SPARSE);
}

TEST(SolverCosts, SayWhatWasWeighed) {
  const SolveCosts costs = predict_costs({32e3, 441.0, 160e3, 1225.0, 0.0, 0.0});
  const std::string text = explain(cheapest(costs), costs);
  EXPECT_EQ(text.find("dense Cholesky predicted"), 0u) << text;
  EXPECT_NE(text.find("against conjugate gradients on S"), std::string::npos) << text;
  EXPECT_EQ(text.find("sparse"), std::string::npos) << text;  // there was none
}

}  // namespace
}  // namespace raylign::native
