// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <gtest/gtest.h>

#include <Eigen/Core>
#include <algorithm>
#include <limits>

namespace raylign::test {

/// Largest |a − b| over max(1, largest |b|); NaN when either holds one.
template <typename A, typename B>
double scaled_error(const Eigen::MatrixBase<A>& a, const Eigen::MatrixBase<B>& b) {
  if (!a.allFinite() || !b.allFinite()) return std::numeric_limits<double>::quiet_NaN();
  return (a - b).cwiseAbs().maxCoeff() / std::max(1.0, b.cwiseAbs().maxCoeff());
}

/// EXPECT_TRUE(is_near(actual, expected, 1e-12)): prints both on failure. Relative to the largest
/// expected entry, absolute when that is below 1. NaN is never near.
template <typename A, typename B>
testing::AssertionResult is_near(const Eigen::MatrixBase<A>& actual,
                                 const Eigen::MatrixBase<B>& expected,
                                 double tolerance) {
  const double error = scaled_error(actual, expected);
  if (error <= tolerance) return testing::AssertionSuccess();
  const Eigen::IOFormat format(Eigen::FullPrecision);
  return testing::AssertionFailure() << "error " << error << " > " << tolerance << "\nactual\n"
                                     << actual.format(format) << "\nexpected\n"
                                     << expected.format(format);
}

/// The same relative to the largest expected entry, however small it is.
template <typename A, typename B>
testing::AssertionResult is_relatively_near(const Eigen::MatrixBase<A>& actual,
                                            const Eigen::MatrixBase<B>& expected,
                                            double tolerance) {
  const double size = expected.cwiseAbs().maxCoeff();
  return is_near(actual / size, expected / size, tolerance);
}

}  // namespace raylign::test
