// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/pattern.h"

#include <gtest/gtest.h>

#include <limits>

#include "raylign/base/error.h"

namespace raylign {
namespace {

TEST(PatchPattern, SquareRunsByColumnsFromMinusHalfItsSide) {
  const PatchPattern four = PatchPattern::square(4);
  ASSERT_EQ(four.size(), 16);
  for (int n = 0; n < 16; ++n) {
    EXPECT_EQ(four.offsets[n][0], n / 4 - 2);
    EXPECT_EQ(four.offsets[n][1], n % 4 - 2);
  }
  EXPECT_EQ(PatchPattern::square(3).offsets.front()[0], -1.0);
  EXPECT_EQ(PatchPattern::square(5).offsets.back()[1], 2.0);
}

TEST(PatchPattern, ParsesEveryNameAndRefusesOthers) {
  for (const char* name : {"3x3", "4x4", "5x5", "spread8"}) {
    EXPECT_EQ(PatchPattern::parse(name).name, name);
    EXPECT_NO_THROW(PatchPattern::parse(name).validate());
  }
  EXPECT_EQ(PatchPattern::parse("spread8").size(), 8);
  for (const char* name : {"", "4x5", "6x6", "4X4"}) {
    EXPECT_THROW(PatchPattern::parse(name), OptionsError) << name;
  }
}

TEST(PatchPattern, KnowsTheSquareOfFourWhateverItsName) {
  PatchPattern pattern = PatchPattern::square(4);
  pattern.name = "custom";
  EXPECT_TRUE(pattern.is_square4());
  EXPECT_TRUE(pattern == PatchPattern::square(4));
  std::swap(pattern.offsets[0], pattern.offsets[1]);  // the same pixels in another order
  EXPECT_FALSE(pattern.is_square4());
  EXPECT_FALSE(PatchPattern::square(5).is_square4());
}

TEST(PatchPattern, RefusesNoPixelTooManyAndNotFinite) {
  PatchPattern pattern;
  EXPECT_THROW(pattern.validate(), OptionsError);
  pattern.offsets.assign(PatchPattern::kMaxPixels, {0.5, -3.25});
  EXPECT_NO_THROW(pattern.validate());
  pattern.offsets.push_back({0.0, 0.0});
  EXPECT_THROW(pattern.validate(), OptionsError);
  pattern = PatchPattern::square(3);
  pattern.offsets[4][1] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(pattern.validate(), OptionsError);
}

}  // namespace
}  // namespace raylign
