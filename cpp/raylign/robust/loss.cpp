// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/robust/loss.h"

#include <algorithm>
#include <array>
#include <charconv>
#include <cmath>
#include <string_view>

#include "raylign/base/error.h"

namespace raylign {
namespace {

// Each law in the form that does not cancel near s = 0; comparisons are written so that NaN comes
// out.

LossValue huber(double s, double a) {
  if (s <= a * a) return {s, 1.0, 0.0};
  const double r = std::sqrt(s);
  return {2.0 * a * r - a * a, a / r, -a / (2.0 * s * r)};
}

LossValue soft_l1(double s, double a) {
  const double root = std::sqrt(1.0 + s / (a * a));
  return {2.0 * s / (root + 1.0), 1.0 / root, -1.0 / (2.0 * a * a * root * root * root)};
}

LossValue cauchy(double s, double b) {
  const double w = 1.0 / (1.0 + s / b);
  return {b * std::log1p(s / b), w, -w * w / b};
}

LossValue arctan(double s, double b) {
  const double x = s / b;
  const double w = 1.0 / (1.0 + x * x);
  return {b * std::atan(x), w, -2.0 * x * w * w / b};
}

LossValue tukey(double s, double a) {
  const double x = s / (a * a);
  if (x > 1.0) return {a * a / 3.0, 0.0, 0.0};
  const double y = 1.0 - x;
  return {s * (1.0 - x + x * x / 3.0), y * y, -2.0 * y / (a * a)};
}

LossValue geman_mcclure(double s, double a) {
  const double w = 1.0 / (1.0 + s / (a * a));
  return {s * w, w * w, -2.0 * w * w * w / (a * a)};
}

struct NamedType {
  LossType type;
  std::string_view name;
};

constexpr std::array<NamedType, 8> kNames = {{{LossType::TRIVIAL, "trivial"},
                                              {LossType::HUBER, "huber"},
                                              {LossType::SOFT_L1, "soft_l1"},
                                              {LossType::CAUCHY, "cauchy"},
                                              {LossType::ARCTAN, "arctan"},
                                              {LossType::TUKEY, "tukey"},
                                              {LossType::GEMAN_MCCLURE, "geman_mcclure"},
                                              {LossType::STUDENT_T, "student_t"}}};

[[noreturn]] void fail_parse(const std::string& text, const std::string& reason) {
  std::string names;
  for (const NamedType& named : kNames)
    names += (names.empty() ? "" : ", ") + std::string(named.name);
  throw OptionsError("loss must be type[:scale[:degrees_of_freedom]] with type one of " + names +
                     "; got \"" + text + "\": " + reason);
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> fields(1);
  for (const char c : text) {
    if (c == separator) {
      fields.emplace_back();
    } else {
      fields.back() += c;
    }
  }
  return fields;
}

double parse_number(const std::string& field, const std::string& text) {
  double value = 0.0;
  const char* end = field.data() + field.size();
  const auto result = std::from_chars(field.data(), end, value);
  if (result.ec != std::errc() || result.ptr != end) {
    fail_parse(text, "\"" + field + "\" is not a number");
  }
  return value;
}

// The bound keeps a² and s / a² inside the range of double.
void require_positive(const char* field, double value) {
  require_option(value >= 1e-100 && value <= 1e100, field, "> 0 and within [1e-100, 1e100]", value);
}

}  // namespace

LossValue Loss::evaluate(double squared_norm) const {
  const double s = squared_norm;
  const double a = scale;
  switch (type) {
    case LossType::TRIVIAL:
      return {s, 1.0, 0.0};
    case LossType::HUBER:
      return huber(s, a);
    case LossType::SOFT_L1:
      return soft_l1(s, a);
    case LossType::CAUCHY:
      return cauchy(s, a * a);
    case LossType::ARCTAN:
      return arctan(s, a * a);
    case LossType::TUKEY:
      return tukey(s, a);
    case LossType::GEMAN_MCCLURE:
      return geman_mcclure(s, a);
    case LossType::STUDENT_T:
      return cauchy(s, degrees_of_freedom * a * a);  // the same family: b = ν a²
  }
  return {s, 1.0, 0.0};
}

void Loss::validate() const {
  require_positive("Loss.scale", scale);
  require_positive("Loss.degrees_of_freedom", degrees_of_freedom);
}

std::string to_string(LossType type) {
  for (const NamedType& named : kNames) {
    if (named.type == type) return std::string(named.name);
  }
  return "unknown";
}

const std::vector<LossType>& all_loss_types() {
  static const std::vector<LossType> types = [] {
    std::vector<LossType> all;
    for (const NamedType& named : kNames) all.push_back(named.type);
    return all;
  }();
  return types;
}

Loss parse_loss(const std::string& text) {
  const std::vector<std::string> fields = split(text, ':');
  const auto named = std::find_if(kNames.begin(), kNames.end(),
                                  [&](const NamedType& n) { return n.name == fields[0]; });
  if (named == kNames.end()) fail_parse(text, "unknown type \"" + fields[0] + "\"");
  const std::size_t max_fields = named->type == LossType::STUDENT_T ? 3 : 2;
  if (fields.size() > max_fields) fail_parse(text, "too many fields");
  Loss loss;
  loss.type = named->type;
  if (fields.size() > 1) loss.scale = parse_number(fields[1], text);
  if (fields.size() > 2) loss.degrees_of_freedom = parse_number(fields[2], text);
  loss.validate();
  return loss;
}

}  // namespace raylign
