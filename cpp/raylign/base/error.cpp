// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/error.h"

#include <charconv>
#include <cmath>
#include <utility>

namespace raylign {
namespace {

std::string compose(const std::string& file,
                    std::int64_t line,
                    const std::string& field,
                    const std::string& reason) {
  std::string text = file;
  if (line > 0) text += ":" + std::to_string(line);
  text += ": ";
  if (!field.empty()) text += field + ": ";
  return text + reason;
}

}  // namespace

FormatError::FormatError(std::string file, std::int64_t line, std::string field, std::string reason)
    : Error(compose(file, line, field, reason)),
      file_(std::move(file)),
      line_(line),
      field_(std::move(field)),
      reason_(std::move(reason)) {}

std::string format_double(double value) {
  if (std::isnan(value)) return "nan";  // never "-nan": the sign of NaN means nothing
  char buffer[32];
  constexpr double kLargestPlainInteger = 1e15;  // 100000, not 1e+05
  if (value == std::trunc(value) && std::abs(value) < kLargestPlainInteger) {
    const auto plain =
        std::to_chars(buffer, buffer + sizeof(buffer), static_cast<std::int64_t>(value));
    return std::string(buffer, plain.ptr);
  }
  const auto result = std::to_chars(buffer, buffer + sizeof(buffer), value);
  return std::string(buffer, result.ptr);
}

void require_option(bool ok, const char* field, const char* rule, double value) {
  if (!ok)
    throw OptionsError(std::string(field) + " must be " + rule + ", got " + format_double(value));
}

}  // namespace raylign
