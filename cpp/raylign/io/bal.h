// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <string_view>

#include "raylign/io/byte_sink.h"
#include "raylign/scene/bal_problem.h"

/// Bundle Adjustment in the Large text files (https://grail.cs.washington.edu/projects/bal):
///   <cameras> <points> <observations>
///   <camera index> <point index> <u> <v>     one line per observation
///   <parameter>                              nine lines per camera, then three lines per point
namespace raylign {

/// What to do with a second observation of the same point by the same camera.
enum class DuplicatePolicy {
  ERROR,  ///< FormatError: they count twice in the cost, which is seldom meant.
  FIRST,  ///< Keep the first.
  MEAN,   ///< Average the pixels into the first.
  KEEP,   ///< Keep all: what the file says, as Ceres would sum them.
};

/// "error", "first", "mean", "keep"; throws OptionsError for anything else.
DuplicatePolicy parse_duplicate_policy(const std::string& name);

/// Reads a BAL file: plain, gzip or bzip2, told apart by content. Whitespace of any kind and CRLF
/// are fine.
///
/// Memory: the arrays of the result and 256 KiB; the counts of the first line are compared with
/// what the file can hold before anything is allocated. Throws FormatError naming file, line and
/// field for everything that is not a complete, finite, consistent problem.
BalProblem read_bal(const std::string& path, DuplicatePolicy duplicates = DuplicatePolicy::ERROR);

/// The same for bytes in memory (plain or compressed); `name` stands for the file in messages.
BalProblem parse_bal(std::string_view bytes,
                     const std::string& name = "<memory>",
                     DuplicatePolicy duplicates = DuplicatePolicy::ERROR);

/// Writes a BAL file piece by piece in bounded memory. Call the adders in the order of the format
/// (observations, cameras, points) and as often as announced, then finish(); otherwise Error, and
/// the target stays as it was. Numbers are the shortest decimals that read back to the same bits.
/// The colours of a BalProblem have no place in the format.
class BalWriter {
 public:
  /// `sink` gets the text; the counts must be in [1, 2³¹ − 1] (what the reader accepts), else
  /// FormatError.
  BalWriter(std::unique_ptr<ByteSink> sink,
            std::int64_t num_cameras,
            std::int64_t num_points,
            std::int64_t num_observations);

  /// The indices must be in range and all numbers finite; throws FormatError naming the record.
  void add_observation(std::int64_t camera, std::int64_t point, double u, double v);
  void add_camera(const double* parameters);  ///< 9 numbers
  void add_point(const double* p_w);          ///< 3 numbers
  /// Flushes and puts the finished file in place.
  void finish();

 private:
  void begin_record(std::int64_t& written, std::int64_t announced, const char* kind);
  void append_parameters(const double* values, int count, const char* kind, std::int64_t record);
  void append_real(double value, const char* kind, std::int64_t record);
  void append_index(std::int64_t value, std::int64_t count, const char* kind);
  void flush_if_full();

  std::unique_ptr<ByteSink> sink_;
  std::string buffer_;
  std::int64_t num_cameras_;
  std::int64_t num_points_;
  std::int64_t num_observations_;
  std::int64_t cameras_written_ = 0;
  std::int64_t points_written_ = 0;
  std::int64_t observations_written_ = 0;
};

/// Writes `problem` to `path`, compressed when the name ends in .gz or .bz2. The text goes to a
/// temporary file beside the target, which is renamed at the end: a failure leaves the old file as
/// it was. Reading it back gives bit-equal arrays (colours excepted). Throws ShapeError for an
/// inconsistent problem, FormatError for a number that is not finite, an empty problem, or a target
/// that cannot be written.
void write_bal(const BalProblem& problem, const std::string& path);

/// The text that write_bal would write, uncompressed.
std::string format_bal(const BalProblem& problem);

}  // namespace raylign
