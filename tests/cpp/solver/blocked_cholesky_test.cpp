// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/blocked_cholesky.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <limits>

#include "raylign/base/blas_threads.h"
#include "raylign/solver/cholesky_kernels.h"

namespace raylign {
namespace {

// Positive definite, none of its blocks alike.
Eigen::MatrixXd positive_definite(int n) {
  const Eigen::MatrixXd waves = Eigen::MatrixXd::NullaryExpr(
      n, 40, [](Eigen::Index i, Eigen::Index k) { return std::sin(0.37 * (i + 1) * (k + 1)); });
  Eigen::MatrixXd A = waves * waves.transpose();
  A.diagonal().array() += 1.0;
  return A;
}

class Cholesky : public testing::TestWithParam<int> {
 protected:
  const ScopedSingleThreadedBlas single_threaded_blas_;
  const Eigen::MatrixXd A_ = positive_definite(GetParam());
  const int n_ = GetParam();
};

TEST_P(Cholesky, EqualsEigensOnAnyNumberOfThreads) {
  const Eigen::MatrixXd expected = A_.llt().matrixL();
  Eigen::MatrixXd first;
  for (const int num_threads : {1, 2, 4}) {
    ThreadPool pool(num_threads);
    Eigen::MatrixXd L = A_;
    ASSERT_TRUE(factor_cholesky(L.data(), n_, pool));
    L.triangularView<Eigen::StrictlyUpper>().setZero();
    EXPECT_LT((L - expected).cwiseAbs().maxCoeff(), 1e-11 * expected.cwiseAbs().maxCoeff());
    if (num_threads == 1) first = L;
    EXPECT_TRUE(L == first) << num_threads;
  }
}

TEST_P(Cholesky, DoesNotMindWhatStandsAboveTheDiagonal) {
  ThreadPool pool(1);
  Eigen::MatrixXd expected = A_;
  ASSERT_TRUE(factor_cholesky(expected.data(), n_, pool));
  Eigen::MatrixXd L = A_;
  L.triangularView<Eigen::StrictlyUpper>().setConstant(std::numeric_limits<double>::quiet_NaN());
  ASSERT_TRUE(factor_cholesky(L.data(), n_, pool));
  for (int k = 0; k < n_; ++k) EXPECT_EQ(L.col(k).tail(n_ - k), expected.col(k).tail(n_ - k));
}

TEST_P(Cholesky, SolvesInRegisters) {
  ThreadPool pool(1);
  Eigen::MatrixXd L = A_;
  ASSERT_TRUE(factor_cholesky(L.data(), n_, pool));
  const Eigen::VectorXd x = Eigen::VectorXd::LinSpaced(n_, -1.0, 2.0);
  Eigen::VectorXd b = A_ * x;
  solve_in_registers(L.data(), n_, b.data());
  EXPECT_LT((b - x).norm(), 1e-9 * x.norm());
}

TEST_P(Cholesky, SaysWhenThereIsNone) {
  ThreadPool pool(2);
  for (const int k : {0, n_ / 2, n_ - 1}) {
    for (const double bad : {-1.0, std::numeric_limits<double>::quiet_NaN()}) {
      Eigen::MatrixXd L = A_;
      L(k, k) = bad;
      EXPECT_FALSE(factor_cholesky(L.data(), n_, pool)) << k << " " << bad;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(Sizes,
                         Cholesky,
                         testing::Values(1, 8, 31, 33, 130, 441, kMinBlocked, kMinBlocked + 131));

}  // namespace
}  // namespace raylign
