// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>

namespace raylign {

/// Base of every exception that raylign throws on purpose. Python: `raylign.Error(RuntimeError)`.
class Error : public std::runtime_error {
 public:
  using std::runtime_error::runtime_error;
};

/// An option is out of range or two options contradict each other. Python: also a `ValueError`.
class OptionsError : public Error {
 public:
  using Error::Error;
};

/// Array shapes, dtypes or index ranges disagree. Python: also a `ValueError`.
class ShapeError : public Error {
 public:
  using Error::Error;
};

/// A file is not what its format promises. Python: also a `ValueError`, with the same four
/// attributes.
class FormatError : public Error {
 public:
  /// @param file   path as the caller gave it, or a name for a stream ("<stream>")
  /// @param line   1-based line, 0 if the error belongs to no line (an empty file, a missing tail)
  /// @param field  what was being read, e.g. "camera index of observation 17"
  /// @param reason what was wrong and what was expected, e.g. "got 49, the header declares 49
  /// cameras"
  FormatError(std::string file, std::int64_t line, std::string field, std::string reason);

  const std::string& file() const { return file_; }
  std::int64_t line() const { return line_; }
  const std::string& field() const { return field_; }
  const std::string& reason() const { return reason_; }

 private:
  std::string file_;
  std::int64_t line_;
  std::string field_;
  std::string reason_;
};

/// Shortest decimal text that reads back as the same double; integers without exponent.
std::string format_double(double value);

/// Throws OptionsError("LmOptions.initial_lambda must be > 0, got -1") unless `ok`.
void require_option(bool ok, const char* field, const char* rule, double value);

}  // namespace raylign
