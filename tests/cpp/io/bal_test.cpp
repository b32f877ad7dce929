// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/bal.h"

#include <gtest/gtest.h>

#include <clocale>
#include <cstdlib>
#include <filesystem>
#include <limits>
#include <memory>
#include <string>

#include "raylign/base/error.h"
#include "raylign/scene/bal_statistics.h"
#include "support/small_problem.h"

// The malformed classes, each with line and field, are in tests/python/test_io_bal.py.
namespace raylign::test {
namespace {

namespace fs = std::filesystem;

fs::path scratch(const char* name) { return fs::path(testing::TempDir()) / name; }

const FormatError& error_of(const std::string& text) {
  static std::unique_ptr<FormatError> caught;
  try {
    parse_bal(text, "problem.txt");
    caught = std::make_unique<FormatError>("", -1, "accepted", "accepted");
  } catch (const FormatError& error) {
    caught = std::make_unique<FormatError>(error);
  }
  return *caught;
}

std::string with_zeros(const std::string& head, int count) {
  std::string text = head;
  for (int i = 0; i < count; ++i) text += "0\n";
  return text;
}

TEST(Bal, RoundTripIsBitEqual) {
  BalProblem problem = small_problem();
  problem.points(0, 0) = -0.0;
  problem.points(0, 1) = std::numeric_limits<double>::denorm_min();
  problem.points(0, 2) = -std::numeric_limits<double>::max();
  EXPECT_TRUE(parse_bal(format_bal(problem)) == problem);
  for (const char* name : {"round_trip.txt", "round_trip.txt.gz", "round_trip.txt.bz2"}) {
    const std::string path = scratch(name).string();
    write_bal(problem, path);
    EXPECT_TRUE(read_bal(path) == problem) << name;
  }
}

TEST(Bal, ErrorsNameFileLineAndField) {
  const FormatError& error = error_of(with_zeros("1 1 1\n0 7 1.0 2.0\n", 12));
  EXPECT_EQ(error.file(), "problem.txt");
  EXPECT_EQ(error.line(), 2);
  EXPECT_EQ(error.field(), "point index of observation 0");
  EXPECT_EQ(error.reason(), "must be between 0 and 0 (the header declares 1 points), got '7'");
  EXPECT_EQ(error_of(with_zeros("1 1 1\n0 0 1.0 2.0\n", 11) + "      ").field(), "z of point 0");
}

TEST(Bal, ImpossibleCountsAreRefusedBeforeAnythingIsAllocated) {
  for (const char* text :
       {"2147483647 2147483647 2147483647\n", "1 1 2147483647\n0 0 1 1\n", "2147483648 1 1\n",
        "999999999999999999 1 1\n", "1e18 1 1\n", "0 1 1\n", "1 -1 1\n", "1 1"}) {
    EXPECT_EQ(error_of(text).line(), 1) << text;
  }
}

TEST(Bal, DuplicatePolicies) {
  const std::string text = with_zeros("1 2 4\n0 0 1 10\n0 1 7 8\n0 0 2 20\n0 0 6 60\n", 15);
  const FormatError& error = error_of(text);
  EXPECT_EQ(error.line(), 4);
  EXPECT_EQ(error.field(), "observation 2");
  EXPECT_EQ(parse_bal(text, "", DuplicatePolicy::KEEP).num_observations(), 4);
  const BalProblem first = parse_bal(text, "", DuplicatePolicy::FIRST);
  ASSERT_EQ(first.num_observations(), 2);
  EXPECT_EQ(first.observations(0, 0), 1.0);
  EXPECT_EQ(first.observations(1, 1), 8.0);
  const BalProblem mean = parse_bal(text, "", DuplicatePolicy::MEAN);
  EXPECT_DOUBLE_EQ(mean.observations(0, 0), 3.0);
  EXPECT_DOUBLE_EQ(mean.observations(0, 1), 30.0);
  EXPECT_THROW(parse_duplicate_policy("last"), OptionsError);
}

TEST(BalWriter, KeepsTheOrderAndTheCounts) {
  const double numbers[9] = {};
  std::string text;
  BalWriter writer(make_string_sink(&text), 1, 1, 1);
  EXPECT_THROW(writer.add_camera(numbers), Error);
  EXPECT_THROW(writer.finish(), Error);
  writer.add_observation(0, 0, 1.0, 2.0);
  EXPECT_THROW(writer.add_observation(0, 0, 1.0, 2.0), Error);
  EXPECT_THROW(writer.add_point(numbers), Error);
  writer.add_camera(numbers);
  writer.add_point(numbers);
  EXPECT_TRUE(text.empty());
  writer.finish();
  EXPECT_EQ(parse_bal(text).observations(0, 1), 2.0);
}

TEST(BalWriter, RefusesWhatTheReaderWouldRefuse) {
  std::string text;
  EXPECT_THROW(BalWriter(make_string_sink(&text), 0, 1, 1), FormatError);
  EXPECT_THROW(BalWriter(make_string_sink(&text), 1, 1, std::int64_t{1} << 31), FormatError);
  BalWriter writer(make_string_sink(&text), 2, 3, 9);
  EXPECT_THROW(writer.add_observation(2, 0, 0.0, 0.0), FormatError);
  EXPECT_THROW(writer.add_observation(0, -1, 0.0, 0.0), FormatError);
  EXPECT_THROW(writer.add_observation(0, 0, std::numeric_limits<double>::quiet_NaN(), 0.0),
               FormatError);
}

TEST(Bal, DecimalCommaLocale) {
  const std::string before = std::setlocale(LC_ALL, nullptr);
  const bool found = std::setlocale(LC_ALL, "de_DE.UTF-8") != nullptr;
  if (!found) GTEST_SKIP() << "locale de_DE.UTF-8 is not installed";
  const BalProblem problem = small_problem();
  const bool equal = parse_bal(format_bal(problem)) == problem;
  std::setlocale(LC_ALL, before.c_str());
  EXPECT_TRUE(equal);
}

TEST(Bal, RealProblemsStartWithTheKnownCosts) {
  const char* folder = std::getenv("RAYLIGN_DATA");
  const fs::path bal = fs::path(folder != nullptr ? folder : RAYLIGN_SHARED_DATA_DIR) / "bal";
  if (!fs::exists(bal)) GTEST_SKIP() << "third-party data not found: " << bal;
  const BalProblem ladybug = read_bal((bal / "problem-49-7776-pre.txt").string());
  EXPECT_NEAR(reprojection_cost(ladybug), 8.509125e5, 1.0);
  EXPECT_EQ(statistics(ladybug).num_behind_camera, 31);
  const BalProblem trafalgar = read_bal((bal / "problem-21-11315-pre.txt").string());
  EXPECT_NEAR(reprojection_cost(trafalgar), 4.413239e6, 1.0);
}

}  // namespace
}  // namespace raylign::test
