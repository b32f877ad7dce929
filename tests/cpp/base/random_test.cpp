// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/random.h"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <set>

namespace raylign {
namespace {

// First outputs of SplitMix64 from state 1234567, as its author's C program prints them.
TEST(Random, SplitMixMatchesTheReference) {
  std::uint64_t state = 1234567;
  EXPECT_EQ(splitmix64(state), 6457827717110365317ULL);
  EXPECT_EQ(splitmix64(state), 3203168211198807973ULL);
  EXPECT_EQ(splitmix64(state), 9817491932198370423ULL);
}

TEST(Random, StreamsAreTheirNames) {
  RandomStream a(7, "points", 3, 1);
  RandomStream b(7, "points", 3, 1);
  for (int i = 0; i < 100; ++i) EXPECT_EQ(a.bits(), b.bits());
}

TEST(Random, EveryPartOfTheNameMatters) {
  std::set<std::uint64_t> first;
  for (std::uint64_t seed : {0, 1}) {
    for (const char* name : {"a", "b", "ab", ""}) {
      for (std::uint64_t index : {0, 1, 2}) {
        for (std::uint64_t sub : {0, 1}) first.insert(RandomStream(seed, name, index, sub).bits());
      }
    }
  }
  EXPECT_EQ(first.size(), 2u * 4u * 3u * 2u);
}

// These values are the contract: shipped data sets are functions of them.
TEST(Random, ValuesAreFrozen) {
  RandomStream random(0, "golden", 0);
  EXPECT_EQ(random.bits(), 10751489697660842207ULL);
  EXPECT_EQ(random.uniform(), 0.52501560531484037);
  EXPECT_EQ(random.normal(), 1.5544419757330659);
  EXPECT_EQ(random.below(1000), 298u);
}

TEST(Random, UniformMoments) {
  RandomStream random(11, "uniform");
  constexpr int kCount = 200000;
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < kCount; ++i) {
    const double u = random.uniform();
    ASSERT_GE(u, 0.0);
    ASSERT_LT(u, 1.0);
    sum += u;
    squares += u * u;
  }
  // Five standard errors.
  EXPECT_NEAR(sum / kCount, 0.5, 5.0 * std::sqrt(1.0 / 12.0 / kCount));
  EXPECT_NEAR(squares / kCount, 1.0 / 3.0, 5.0 * std::sqrt(4.0 / 45.0 / kCount));
}

TEST(Random, NormalMomentsAndTails) {
  RandomStream random(12, "normal");
  constexpr int kCount = 200000;
  std::array<double, 5> moments{};
  int outside_two = 0;
  for (int i = 0; i < kCount; ++i) {
    const double x = random.normal();
    double power = 1.0;
    for (double& moment : moments) moment += (power *= x) / kCount;
    outside_two += std::abs(x) > 2.0;
  }
  EXPECT_NEAR(moments[0], 0.0, 5.0 / std::sqrt(kCount));
  EXPECT_NEAR(moments[1], 1.0, 5.0 * std::sqrt(2.0 / kCount));
  EXPECT_NEAR(moments[2], 0.0, 5.0 * std::sqrt(15.0 / kCount));
  EXPECT_NEAR(moments[3], 3.0, 5.0 * std::sqrt(96.0 / kCount));
  EXPECT_NEAR(outside_two / double{kCount}, std::erfc(std::sqrt(2.0)), 0.003);
}

TEST(Random, BelowCoversItsRangeEvenly) {
  RandomStream random(13, "below");
  std::array<int, 7> counts{};
  for (int i = 0; i < 70000; ++i) ++counts.at(random.below(7));
  for (const int count : counts) EXPECT_NEAR(count, 10000, 500);
}

}  // namespace
}  // namespace raylign
