// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/text_scanner.h"

#include <gtest/gtest.h>

#include <cmath>
#include <string>
#include <utility>

#include "raylign/base/error.h"

namespace raylign::test {
namespace {

TextScanner scanner_of(std::string_view text) {
  return TextScanner(make_byte_source(text, "text"), "text");
}

std::pair<TokenStatus, double> real(std::string_view text) {
  double value = 0.0;
  TextScanner scanner = scanner_of(text);
  const TokenStatus status = scanner.read_real(value);
  return {status, value};
}

TokenStatus integer(std::string_view text) {
  std::int64_t value = 0;
  TextScanner scanner = scanner_of(text);
  return scanner.read_integer(value);
}

TEST(TextScanner, Reals) {
  EXPECT_EQ(real("1.5").second, 1.5);
  EXPECT_EQ(real("+1.5e1").second, 15.0);
  EXPECT_EQ(real(" \t\r\n-2.").second, -2.0);
  EXPECT_TRUE(std::signbit(real("-0").second));
  EXPECT_EQ(real("4.9e-324").second, 5e-324);
  for (const char* text : {"1e-400", "-1e-400", "0.000001e-330"}) {
    EXPECT_EQ(real(text).first, TokenStatus::OK) << text;
    EXPECT_EQ(real(text).second, 0.0) << text;
    EXPECT_EQ(std::signbit(real(text).second), text[0] == '-') << text;
  }
}

TEST(TextScanner, WhatIsNoReal) {
  for (const char* text :
       {"x", "1x", "1,5", "0x1p3", "--1", "+-1", "+", "-", ".", "1e", "1e+", "1.2.3"}) {
    EXPECT_EQ(real(text).first, TokenStatus::MALFORMED) << text;
  }
  for (const char* text : {"1e999", "-1e999", "123456e400"}) {
    EXPECT_EQ(real(text).first, TokenStatus::OUT_OF_RANGE) << text;
  }
  // The written exponent alone says nothing about the size.
  const std::string zeros(400, '0');
  EXPECT_EQ(real("1" + zeros + "e-10").first, TokenStatus::OUT_OF_RANGE);  // 1e390
  EXPECT_EQ(real("0." + zeros + "1e+5").second, 0.0);                      // 1e-396
  EXPECT_EQ(real("0." + zeros + "1e+5").first, TokenStatus::OK);
  EXPECT_EQ(real("1e99999999999999999999").first, TokenStatus::OUT_OF_RANGE);
  EXPECT_EQ(real("1e-99999999999999999999").second, 0.0);
  for (const char* text : {"nan", "-NaN", "inf", "+inf", "INFINITY"}) {
    EXPECT_EQ(real(text).first, TokenStatus::NOT_FINITE) << text;
  }
  EXPECT_EQ(real(" \n ").first, TokenStatus::END_OF_TEXT);
}

TEST(TextScanner, Integers) {
  EXPECT_EQ(integer("9223372036854775807"), TokenStatus::OK);
  EXPECT_EQ(integer("9223372036854775808"), TokenStatus::OUT_OF_RANGE);
  for (const char* text : {"1.0", "1e3", "0x10", "a", "+-1", "1-"}) {
    EXPECT_EQ(integer(text), TokenStatus::MALFORMED) << text;
  }
}

TEST(TextScanner, LinesAndTokensOfMessages) {
  TextScanner scanner = scanner_of("1\r\n\n2 a\x01long_token_of_more_than_forty_characters_in_all");
  double value = 0.0;
  EXPECT_EQ(scanner.read_real(value), TokenStatus::OK);
  EXPECT_EQ(scanner.line(), 1);
  EXPECT_EQ(scanner.read_real(value), TokenStatus::OK);
  EXPECT_EQ(scanner.line(), 3);
  EXPECT_EQ(scanner.read_real(value), TokenStatus::MALFORMED);
  EXPECT_EQ(scanner.token(), "'a\\x01long_token_of_more_than_forty_characte…'");
  EXPECT_FALSE(scanner.at_end());
}

// Blanks of every length put the tokens at every place relative to the end of the buffer.
TEST(TextScanner, TokensAcrossRefills) {
  for (int shift = 0; shift < 24; ++shift) {
    std::string text((1 << 18) - 12 + shift - 1024, ' ');
    for (int i = 0; i < 100; ++i) text += "123456.789012 ";
    TextScanner scanner = scanner_of(text);
    double value = 0.0;
    int count = 0;
    while (scanner.read_real(value) == TokenStatus::OK) {
      EXPECT_EQ(value, 123456.789012);
      ++count;
    }
    EXPECT_EQ(count, 100);
    EXPECT_TRUE(scanner.at_end());
  }
}

TEST(TextScanner, EndlessTokensAreMalformedWhereverTheyLie) {
  EXPECT_EQ(real(std::string(1024, '1') + " ").first, TokenStatus::OUT_OF_RANGE);
  EXPECT_EQ(real("0." + std::string(1022, '1')).first, TokenStatus::OK);
  EXPECT_EQ(real("0." + std::string(1023, '1')).first, TokenStatus::MALFORMED);
  EXPECT_EQ(real("0." + std::string(1 << 20, '1')).first, TokenStatus::MALFORMED);
}

TEST(TextScanner, ByteOrderMarkAndTextLimit) {
  EXPECT_THROW(scanner_of("\xEF\xBB\xBF"
                          "1"),
               FormatError);
  const std::string text(1 << 20, ' ');
  TextScanner scanner = scanner_of(text);
  scanner.set_text_limit(1 << 19);
  EXPECT_THROW(scanner.at_end(), FormatError);
}

}  // namespace
}  // namespace raylign::test
