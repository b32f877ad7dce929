// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_problem.h"

#include <gtest/gtest.h>

#include <limits>
#include <string>

#include "raylign/base/error.h"
#include "support/small_problem.h"

namespace raylign::test {
namespace {

std::string shape_error(const BalProblem& problem) {
  try {
    problem.validate();
  } catch (const ShapeError& error) {
    return error.what();
  }
  return "";
}

TEST(BalProblem, ValidProblemsPass) {
  EXPECT_EQ(shape_error(small_problem()), "");
  EXPECT_EQ(shape_error(BalProblem{}), "");
}

TEST(BalProblem, LengthsMustAgree) {
  BalProblem problem = small_problem(5, 40);
  problem.camera_index.conservativeResize(199);
  EXPECT_EQ(shape_error(problem), "BalProblem.camera_index has 199 rows, but observations has 200");
  problem = small_problem(5, 40);
  problem.point_index.conservativeResize(0);
  EXPECT_NE(shape_error(problem).find("point_index has 0 rows"), std::string::npos);
  problem = small_problem(5, 40);
  problem.colors.setZero(39, 3);
  EXPECT_NE(shape_error(problem).find("colors has 39 rows"), std::string::npos);
}

TEST(BalProblem, IndicesMustBeInRange) {
  for (const std::int32_t bad : {-1, 5, std::numeric_limits<std::int32_t>::max(),
                                 std::numeric_limits<std::int32_t>::min()}) {
    BalProblem problem = small_problem(5, 40);
    problem.camera_index[17] = bad;
    EXPECT_EQ(shape_error(problem),
              "BalProblem.camera_index[17] is " + std::to_string(bad) + ", not in [0, 5)");
  }
  BalProblem problem = small_problem(5, 40);
  problem.point_index[199] = 40;
  EXPECT_EQ(shape_error(problem), "BalProblem.point_index[199] is 40, not in [0, 40)");
}

TEST(BalProblem, EqualityIsBitwiseOverEveryArray) {
  const BalProblem problem = small_problem();
  EXPECT_TRUE(problem == small_problem());
  BalProblem other = problem;
  other.cameras(0, 8) = -other.cameras(0, 8);
  EXPECT_TRUE(problem != other);
  other = problem;
  other.colors.setZero(problem.num_points(), 3);
  EXPECT_TRUE(problem != other);
  other = problem;
  other.camera_index[3] ^= 1;
  EXPECT_TRUE(problem != other);

  BalProblem a = problem;
  BalProblem b = problem;
  a.points(0, 0) = 0.0;
  b.points(0, 0) = -0.0;
  EXPECT_TRUE(a != b);
  a.points(0, 0) = b.points(0, 0) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_TRUE(a == b);
}

}  // namespace
}  // namespace raylign::test
