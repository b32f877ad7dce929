// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <algorithm>
#include <limits>
#include <unordered_map>
#include <utility>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/io/bal.h"
#include "raylign/io/byte_source.h"
#include "raylign/io/text_scanner.h"
#include "raylign/scene/bal_statistics.h"

namespace raylign {
namespace {

constexpr int kCameraSize = 9;
constexpr int kPointSize = 3;
constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max();
constexpr std::int64_t kMinObservationBytes = 8;  // "0 0 0 0\n"
constexpr std::int64_t kMinNumberBytes = 2;       // "0\n"
// Most that a number with its blanks may take on average inside a compressed file, and room for the
// header.
constexpr std::int64_t kMaxNumberBytes = 64;
constexpr std::int64_t kHeaderBytes = std::int64_t{1} << 16;
constexpr Eigen::Index kFirstRows = 4096;

constexpr const char* kCameraFields[kCameraSize] = {
    "rotation x",   "rotation y", "rotation z", "translation x", "translation y", "translation z",
    "focal length", "k1",         "k2"};
constexpr const char* kPointFields[kPointSize] = {"x", "y", "z"};

struct Counts {
  std::int64_t cameras = 0;
  std::int64_t points = 0;
  std::int64_t observations = 0;

  // At most 9·2³¹ + 3·2³¹ + 8·2³¹: no overflow.
  std::int64_t parameters() const { return kCameraSize * cameras + kPointSize * points; }
  std::int64_t min_bytes() const {
    return kMinObservationBytes * observations + kMinNumberBytes * parameters() - 1;
  }
  std::int64_t max_bytes() const {
    return kHeaderBytes + kMaxNumberBytes * (4 * observations + parameters());
  }
};

// Line of each observation in a few bytes: nearly always one per line, so only the places where the
// distance between line and position changes are kept.
class LineMap {
 public:
  void record(std::int64_t position, std::int64_t line) {
    const std::int64_t offset = line - position;
    if (runs_.empty() || runs_.back().second != offset) runs_.emplace_back(position, offset);
  }
  std::int64_t line_of(std::int64_t position) const {
    const auto after =
        std::upper_bound(runs_.begin(), runs_.end(), position,
                         [](std::int64_t value, const auto& run) { return value < run.first; });
    return std::prev(after)->second + position;
  }

 private:
  std::vector<std::pair<std::int64_t, std::int64_t>> runs_;
};

// Reads one problem from one scanner, section by section.
class BalReader {
 public:
  BalReader(TextScanner& scanner, DuplicatePolicy duplicates)
      : scanner_(scanner), duplicates_(duplicates) {}

  BalProblem read() {
    read_header();
    read_observations();
    read_table(problem_.cameras, counts_.cameras, kCameraFields, "camera");
    read_table(problem_.points, counts_.points, kPointFields, "point");
    if (!scanner_.at_end()) {
      scanner_.fail("end of file",
                    "expected nothing after the last point, got " + scanner_.token());
    }
    resolve_duplicates();
    return std::move(problem_);
  }

 private:
  void read_header() {
    counts_.cameras = read_count("number of cameras");
    counts_.points = read_count("number of points");
    counts_.observations = read_count("number of observations");
    if (counts_.min_bytes() > scanner_.source().max_size()) {
      scanner_.fail("header", "declares " + std::to_string(counts_.cameras) + " cameras, " +
                                  std::to_string(counts_.points) + " points and " +
                                  std::to_string(counts_.observations) +
                                  " observations, which take at least " +
                                  std::to_string(counts_.min_bytes()) +
                                  " bytes; the text has no more than " +
                                  std::to_string(scanner_.source().max_size()));
    }
    if (!scanner_.source().size_is_exact()) scanner_.set_text_limit(counts_.max_bytes());
  }

  std::int64_t read_count(const char* field) {
    std::int64_t count = 0;
    const TokenStatus status = scanner_.read_integer(count);
    if (status == TokenStatus::END_OF_TEXT) {
      scanner_.fail(field, "the text ends inside the header: three counts are expected");
    }
    if (status == TokenStatus::MALFORMED) {
      scanner_.fail(field, "expected an integer, got " + scanner_.token());
    }
    if (status != TokenStatus::OK || count < 1 || count > kMaxCount) {
      scanner_.fail(field, "must be between 1 and " + std::to_string(kMaxCount) + ", got " +
                               scanner_.token());
    }
    return count;
  }

  void read_observations() {
    for (std::int64_t i = 0; i < counts_.observations; ++i) {
      make_room(problem_.camera_index, i, counts_.observations);
      make_room(problem_.point_index, i, counts_.observations);
      make_room(problem_.observations, i, counts_.observations);
      problem_.camera_index[i] = read_index("camera index", i, counts_.cameras, "cameras");
      lines_.record(i, scanner_.line());
      problem_.point_index[i] = read_index("point index", i, counts_.points, "points");
      problem_.observations(i, 0) = read_real("u", "observation", i, counts_.observations);
      problem_.observations(i, 1) = read_real("v", "observation", i, counts_.observations);
    }
  }

  template <typename Table, std::size_t Cols>
  void read_table(Table& table,
                  std::int64_t count,
                  const char* const (&fields)[Cols],
                  const char* record) {
    for (std::int64_t i = 0; i < count; ++i) {
      make_room(table, i, count);
      for (std::size_t k = 0; k < Cols; ++k) table(i, k) = read_real(fields[k], record, i, count);
    }
  }

  // A text of known size was checked against the counts: all rows at once. Otherwise grow with what
  // has come, so that a small compressed file with large counts costs little.
  template <typename Table>
  void make_room(Table& table, Eigen::Index row, Eigen::Index count) const {
    if (row < table.rows()) return;
    const Eigen::Index rows = scanner_.source().size_is_exact()
                                  ? count
                                  : std::min(count, std::max(kFirstRows, 2 * table.rows()));
    table.conservativeResize(rows, Eigen::NoChange);
  }

  std::int32_t read_index(const char* field, std::int64_t i, std::int64_t count, const char* what) {
    std::int64_t value = 0;
    const TokenStatus status = scanner_.read_integer(value);
    if (status == TokenStatus::OK && value >= 0 && value < count) {
      return static_cast<std::int32_t>(value);
    }
    if (status == TokenStatus::OK || status == TokenStatus::OUT_OF_RANGE) {
      scanner_.fail(field_of(field, "observation", i),
                    "must be between 0 and " + std::to_string(count - 1) +
                        " (the header declares " + std::to_string(count) + " " + what + "), got " +
                        scanner_.token());
    }
    fail_number(status, "an integer", field, "observation", i, counts_.observations);
  }

  double read_real(const char* field, const char* record, std::int64_t i, std::int64_t count) {
    double value = 0.0;
    const TokenStatus status = scanner_.read_real(value);
    if (status != TokenStatus::OK) fail_number(status, "a number", field, record, i, count);
    return value;
  }

  static std::string field_of(const char* field, const char* record, std::int64_t i) {
    return std::string(field) + " of " + record + " " + std::to_string(i);
  }

  [[noreturn]] void fail_number(TokenStatus status,
                                const char* expected,
                                const char* field,
                                const char* record,
                                std::int64_t i,
                                std::int64_t count) const {
    std::string reason = std::string("expected ") + expected + ", got " + scanner_.token();
    if (status == TokenStatus::END_OF_TEXT) {
      reason =
          "the text ends here; the header declares " + std::to_string(count) + " " + record + "s";
    } else if (status == TokenStatus::NOT_FINITE) {
      reason = "must be finite, got " + scanner_.token();
    } else if (status == TokenStatus::OUT_OF_RANGE) {
      reason = "too large for a double: " + scanner_.token();
    }
    scanner_.fail(field_of(field, record, i), reason);
  }

  void resolve_duplicates() {
    if (duplicates_ == DuplicatePolicy::KEEP) return;
    const std::vector<DuplicateObservation> duplicates = duplicate_observations(problem_);
    if (duplicates.empty()) return;
    if (duplicates_ == DuplicatePolicy::ERROR) fail_duplicate(duplicates.front());
    if (duplicates_ == DuplicatePolicy::MEAN) average_into_first(duplicates);
    remove_repeats(duplicates);
  }

  [[noreturn]] void fail_duplicate(const DuplicateObservation& duplicate) const {
    throw FormatError(scanner_.name(), lines_.line_of(duplicate.repeat),
                      "observation " + std::to_string(duplicate.repeat),
                      "repeats camera " + std::to_string(problem_.camera_index[duplicate.repeat]) +
                          ", point " + std::to_string(problem_.point_index[duplicate.repeat]) +
                          " of observation " + std::to_string(duplicate.first) + " on line " +
                          std::to_string(lines_.line_of(duplicate.first)) +
                          "; choose duplicates = first, mean or keep to read it all the same");
  }

  void average_into_first(const std::vector<DuplicateObservation>& duplicates) {
    std::unordered_map<std::int64_t, double> seen;  // running mean: no overflow of a sum
    for (const auto& [first, repeat] : duplicates) {
      const double count = ++seen.emplace(first, 1.0).first->second;
      problem_.observations.row(first) +=
          (problem_.observations.row(repeat) / count - problem_.observations.row(first) / count);
    }
  }

  void remove_repeats(const std::vector<DuplicateObservation>& duplicates) {
    auto next_repeat = duplicates.begin();
    std::int64_t kept = 0;
    for (std::int64_t i = 0; i < problem_.num_observations(); ++i) {
      if (next_repeat != duplicates.end() && next_repeat->repeat == i) {
        ++next_repeat;
        continue;
      }
      problem_.camera_index[kept] = problem_.camera_index[i];
      problem_.point_index[kept] = problem_.point_index[i];
      problem_.observations.row(kept) = problem_.observations.row(i);
      ++kept;
    }
    problem_.camera_index.conservativeResize(kept);
    problem_.point_index.conservativeResize(kept);
    problem_.observations.conservativeResize(kept, Eigen::NoChange);
  }

  TextScanner& scanner_;
  DuplicatePolicy duplicates_;
  Counts counts_;
  BalProblem problem_;
  LineMap lines_;
};

BalProblem read_from(std::unique_ptr<ByteSource> source,
                     const std::string& name,
                     DuplicatePolicy duplicates) {
  TextScanner scanner(std::move(source), name);
  return BalReader(scanner, duplicates).read();
}

}  // namespace

DuplicatePolicy parse_duplicate_policy(const std::string& name) {
  if (name == "error") return DuplicatePolicy::ERROR;
  if (name == "first") return DuplicatePolicy::FIRST;
  if (name == "mean") return DuplicatePolicy::MEAN;
  if (name == "keep") return DuplicatePolicy::KEEP;
  throw OptionsError("duplicates must be error, first, mean or keep, got '" + name + "'");
}

BalProblem read_bal(const std::string& path, DuplicatePolicy duplicates) {
  return read_from(open_byte_source(path), path, duplicates);
}

BalProblem parse_bal(std::string_view bytes, const std::string& name, DuplicatePolicy duplicates) {
  return read_from(make_byte_source(bytes, name), name, duplicates);
}

}  // namespace raylign
