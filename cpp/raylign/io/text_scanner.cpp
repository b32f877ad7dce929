// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/text_scanner.h"

#include <algorithm>
#include <charconv>
#include <cmath>
#include <cstring>
#include <string_view>
#include <utility>

#include "raylign/base/error.h"

namespace raylign {
namespace {

constexpr std::size_t kBufferSize = std::size_t{1} << 18;
// A double needs at most 17 digits; files with more than 1000 characters per number are not
// problems.
constexpr std::ptrdiff_t kMaxTokenSize = 1024;
constexpr std::size_t kShownTokenSize = 40;

bool is_blank(char c) { return c == ' ' || (c >= '\t' && c <= '\r'); }

void append_printable(std::string& text, char c) {
  if (c >= ' ' && c <= '~') {
    text += c;
    return;
  }
  constexpr char kHex[] = "0123456789abcdef";
  const auto byte = static_cast<unsigned char>(c);
  text += {'\\', 'x', kHex[byte >> 4], kHex[byte & 15]};
}

// Decimal exponent of the first significant digit of a number that from_chars has
// understood: 12.5e-3 has 1 + (−3), 0.00125 has −3. Clamped far outside the range of double.
std::int64_t decimal_magnitude(const char* token, const char* end) {
  constexpr std::int64_t kClamp = 1000000;
  const char* exponent_mark = std::find_if(token, end, [](char c) { return c == 'e' || c == 'E'; });
  const char* point = std::find(token, exponent_mark, '.');
  const char* digit =
      std::find_if(token, exponent_mark, [](char c) { return c >= '1' && c <= '9'; });
  const std::int64_t position = digit < point ? point - digit - 1 : point - digit;
  if (exponent_mark == end) return position;
  const char* first = exponent_mark + 1;
  if (first != end && *first == '+') ++first;
  std::int64_t exponent = 0;
  const auto result = std::from_chars(first, end, exponent);
  if (result.ec == std::errc::result_out_of_range) exponent = *first == '-' ? -kClamp : kClamp;
  return position + std::clamp(exponent, -kClamp, kClamp);
}

// from_chars reports overflow and underflow alike.
bool is_underflow(const char* token, const char* end) { return decimal_magnitude(token, end) < 0; }

std::from_chars_result convert(const char* begin, const char* end, std::int64_t& value) {
  return std::from_chars(begin, end, value);
}

std::from_chars_result convert(const char* begin, const char* end, double& value) {
  std::from_chars_result result = std::from_chars(begin, end, value);
  if (result.ec == std::errc::result_out_of_range && is_underflow(begin, result.ptr)) {
    value = *begin == '-' ? -0.0 : 0.0;
    result.ec = std::errc();
  }
  return result;
}

bool is_finite(std::int64_t) { return true; }
bool is_finite(double value) { return std::isfinite(value); }

}  // namespace

TextScanner::TextScanner(std::unique_ptr<ByteSource> source, std::string name)
    : source_(std::move(source)),
      name_(std::move(name)),
      buffer_(kBufferSize),
      cursor_(buffer_.data()),
      end_(cursor_),
      token_(cursor_) {
  refill();
  if (std::string_view(cursor_, end_ - cursor_).substr(0, 3) == "\xEF\xBB\xBF") {
    fail("", "starts with a UTF-8 byte-order mark; save it as plain ASCII text");
  }
}

// Moves the unread tail to the front and fills the rest, so that a whole token always lies in the
// buffer.
void TextScanner::refill() {
  const std::size_t kept = end_ - cursor_;
  std::memmove(buffer_.data(), cursor_, kept);
  std::size_t filled = kept;
  while (filled < buffer_.size() && !exhausted_) {
    const std::size_t count = source_->read(buffer_.data() + filled, buffer_.size() - filled);
    exhausted_ = count == 0;
    filled += count;
    bytes_read_ += static_cast<std::int64_t>(count);
  }
  cursor_ = buffer_.data();
  end_ = cursor_ + filled;
  if (bytes_read_ > text_limit_) {
    fail("", "the text is longer than the counts in its first line can need");
  }
}

bool TextScanner::skip_blanks() {
  while (true) {
    while (cursor_ != end_ && is_blank(*cursor_)) {
      line_ += *cursor_ == '\n' ? 1 : 0;
      ++cursor_;
    }
    if (end_ - cursor_ > kMaxTokenSize || exhausted_) break;
    const bool at_token = cursor_ != end_;
    refill();
    if (at_token) break;
  }
  token_ = cursor_;
  return cursor_ != end_;
}

template <typename T>
TokenStatus TextScanner::read_number(T& value) {
  if (!skip_blanks()) return TokenStatus::END_OF_TEXT;
  const char* begin = cursor_;
  if (*begin == '+' && end_ - begin > 1 && begin[1] != '-')
    ++begin;  // from_chars knows no plus sign
  const std::from_chars_result result = convert(begin, end_, value);
  if (result.ec == std::errc::invalid_argument) return TokenStatus::MALFORMED;
  const bool whole_token = result.ptr == end_ || is_blank(*result.ptr);
  if (!whole_token || result.ptr - token_ > kMaxTokenSize) return TokenStatus::MALFORMED;
  if (result.ec == std::errc::result_out_of_range) return TokenStatus::OUT_OF_RANGE;
  if (!is_finite(value)) return TokenStatus::NOT_FINITE;
  cursor_ = result.ptr;
  return TokenStatus::OK;
}

TokenStatus TextScanner::read_integer(std::int64_t& value) { return read_number(value); }

TokenStatus TextScanner::read_real(double& value) { return read_number(value); }

bool TextScanner::at_end() { return !skip_blanks(); }

std::string TextScanner::token() const {
  std::string text = "'";
  const char* c = token_;
  for (; c != end_ && !is_blank(*c) && c - token_ < static_cast<std::ptrdiff_t>(kShownTokenSize);
       ++c) {
    append_printable(text, *c);
  }
  const bool shortened = c != end_ && !is_blank(*c);
  return text + (shortened ? "…'" : "'");
}

void TextScanner::fail(const std::string& field, const std::string& reason) const {
  throw FormatError(name_, line_, field, reason);
}

}  // namespace raylign
