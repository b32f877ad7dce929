// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <memory>
#include <string>
#include <vector>

#include "raylign/io/byte_source.h"

namespace raylign {

enum class TokenStatus {
  OK,
  END_OF_TEXT,   ///< Only blanks were left.
  MALFORMED,     ///< Not a number of the asked kind, or longer than a number can be.
  OUT_OF_RANGE,  ///< A number, but too large for the type.
  NOT_FINITE,    ///< "nan", "inf" and their spellings.
};

/// Splits a byte source into numbers separated by blanks (space, \t, \n, \v, \f, \r), through a
/// fixed buffer; independent of the locale (std::from_chars). Numbers are decimal: "1.5", "-2",
/// "+3e-4"; hexadecimal floats, decimal commas and digits that run into other characters are
/// MALFORMED.
class TextScanner {
 public:
  /// Throws FormatError if the text starts with a UTF-8 byte-order mark.
  TextScanner(std::unique_ptr<ByteSource> source, std::string name);

  TokenStatus read_integer(std::int64_t& value);
  /// Doubles come out correctly rounded; below the smallest denormal they become a zero of their
  /// sign.
  TokenStatus read_real(double& value);

  /// 1-based line of the last token, or of the end of the text.
  std::int64_t line() const { return line_; }
  /// The last token for a message: quoted, shortened, unprintable bytes as \xNN.
  std::string token() const;
  /// True when nothing but blanks is left; otherwise token() is what comes next.
  bool at_end();

  const ByteSource& source() const { return *source_; }
  const std::string& name() const { return name_; }

  /// Gives up with a FormatError once the source has yielded more bytes than this.
  void set_text_limit(std::int64_t bytes) { text_limit_ = bytes; }

  [[noreturn]] void fail(const std::string& field, const std::string& reason) const;

 private:
  template <typename T>
  TokenStatus read_number(T& value);
  bool skip_blanks();
  void refill();

  std::unique_ptr<ByteSource> source_;
  std::string name_;
  std::vector<char> buffer_;
  const char* cursor_;
  const char* end_;
  const char* token_;
  std::int64_t line_ = 1;
  std::int64_t bytes_read_ = 0;
  std::int64_t text_limit_ = std::numeric_limits<std::int64_t>::max();
  bool exhausted_ = false;
};

}  // namespace raylign
