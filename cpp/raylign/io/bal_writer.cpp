// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <charconv>
#include <cmath>
#include <limits>
#include <utility>

#include "raylign/base/error.h"
#include "raylign/io/bal.h"

namespace raylign {
namespace {

constexpr std::size_t kFlushSize = std::size_t{1} << 20;
constexpr int kCameraSize = 9;
constexpr int kPointSize = 3;

template <typename T>
void append_number(std::string& text, T value) {
  char digits[32];
  const std::to_chars_result result = std::to_chars(digits, digits + sizeof(digits), value);
  text.append(digits, result.ptr);
}

}  // namespace

BalWriter::BalWriter(std::unique_ptr<ByteSink> sink,
                     std::int64_t num_cameras,
                     std::int64_t num_points,
                     std::int64_t num_observations)
    : sink_(std::move(sink)),
      num_cameras_(num_cameras),
      num_points_(num_points),
      num_observations_(num_observations) {
  for (const std::int64_t count : {num_cameras, num_points, num_observations}) {
    if (count >= 1 && count <= std::numeric_limits<std::int32_t>::max()) continue;
    throw FormatError(
        sink_->name(), 0, "header",
        "a BAL file holds 1 to 2147483647 cameras, points and observations each, got " +
            std::to_string(num_cameras) + ", " + std::to_string(num_points) + ", " +
            std::to_string(num_observations));
  }
  buffer_.reserve(kFlushSize + 1024);
  append_number(buffer_, num_cameras_);
  buffer_ += ' ';
  append_number(buffer_, num_points_);
  buffer_ += ' ';
  append_number(buffer_, num_observations_);
  buffer_ += '\n';
}

void BalWriter::begin_record(std::int64_t& written, std::int64_t announced, const char* kind) {
  const bool observations_done = observations_written_ == num_observations_;
  const bool cameras_done = cameras_written_ == num_cameras_;
  const bool in_order = &written == &observations_written_ ||
                        (observations_done && (&written == &cameras_written_ || cameras_done));
  if (!in_order || written == announced) {
    throw Error("BalWriter: " + std::string(kind) + " " + std::to_string(written) + " of " +
                std::to_string(announced) +
                " is out of turn; all observations come first, then all cameras, then all points");
  }
  ++written;
}

void BalWriter::add_observation(std::int64_t camera, std::int64_t point, double u, double v) {
  begin_record(observations_written_, num_observations_, "observation");
  append_index(camera, num_cameras_, "camera index");
  buffer_ += ' ';
  append_index(point, num_points_, "point index");
  buffer_ += "     ";
  append_real(u, "observation", observations_written_ - 1);
  buffer_ += ' ';
  append_real(v, "observation", observations_written_ - 1);
  buffer_ += '\n';
  flush_if_full();
}

void BalWriter::add_camera(const double* parameters) {
  begin_record(cameras_written_, num_cameras_, "camera");
  append_parameters(parameters, kCameraSize, "camera", cameras_written_ - 1);
}

void BalWriter::add_point(const double* p_w) {
  begin_record(points_written_, num_points_, "point");
  append_parameters(p_w, kPointSize, "point", points_written_ - 1);
}

void BalWriter::finish() {
  if (points_written_ != num_points_ || cameras_written_ != num_cameras_ ||
      observations_written_ != num_observations_) {
    throw Error("BalWriter: finished after " + std::to_string(observations_written_) + " of " +
                std::to_string(num_observations_) + " observations, " +
                std::to_string(cameras_written_) + " of " + std::to_string(num_cameras_) +
                " cameras, " + std::to_string(points_written_) + " of " +
                std::to_string(num_points_) + " points");
  }
  sink_->write(buffer_);
  buffer_.clear();
  sink_->finish();
}

void BalWriter::append_parameters(const double* values,
                                  int count,
                                  const char* kind,
                                  std::int64_t record) {
  for (int k = 0; k < count; ++k) {
    append_real(values[k], kind, record);
    buffer_ += '\n';
  }
  flush_if_full();
}

void BalWriter::append_real(double value, const char* kind, std::int64_t record) {
  if (!std::isfinite(value)) {
    throw FormatError(sink_->name(), 0, std::string(kind) + " " + std::to_string(record),
                      "cannot be written: " + format_double(value) + " is not finite");
  }
  append_number(buffer_, value);  // shortest text that reads back to the same bits
}

void BalWriter::append_index(std::int64_t value, std::int64_t count, const char* kind) {
  if (value < 0 || value >= count) {
    throw FormatError(
        sink_->name(), 0,
        std::string(kind) + " of observation " + std::to_string(observations_written_ - 1),
        "cannot be written: " + std::to_string(value) + " is not in [0, " + std::to_string(count) +
            ")");
  }
  append_number(buffer_, value);
}

void BalWriter::flush_if_full() {
  if (buffer_.size() < kFlushSize) return;
  sink_->write(buffer_);
  buffer_.clear();
}

namespace {

void write_to(const BalProblem& problem, std::unique_ptr<ByteSink> sink) {
  BalWriter writer(std::move(sink), problem.num_cameras(), problem.num_points(),
                   problem.num_observations());
  for (Eigen::Index i = 0; i < problem.num_observations(); ++i) {
    writer.add_observation(problem.camera_index[i], problem.point_index[i],
                           problem.observations(i, 0), problem.observations(i, 1));
  }
  for (Eigen::Index c = 0; c < problem.num_cameras(); ++c) {
    writer.add_camera(problem.cameras.row(c).data());
  }
  for (Eigen::Index p = 0; p < problem.num_points(); ++p) {
    writer.add_point(problem.points.row(p).data());
  }
  writer.finish();
}

}  // namespace

void write_bal(const BalProblem& problem, const std::string& path) {
  problem.validate();
  write_to(problem, open_byte_sink(path));
}

std::string format_bal(const BalProblem& problem) {
  problem.validate();
  std::string text;
  write_to(problem, make_string_sink(&text));
  return text;
}

}  // namespace raylign
