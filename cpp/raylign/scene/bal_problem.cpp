// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_problem.h"

#include <cstring>
#include <limits>
#include <string>

#include "raylign/base/error.h"

namespace raylign {
namespace {

void check_rows(const char* name, std::int64_t rows, const char* other, std::int64_t expected) {
  if (rows == expected) return;
  throw ShapeError("BalProblem." + std::string(name) + " has " + std::to_string(rows) +
                   " rows, but " + other + " has " + std::to_string(expected));
}

void check_count(const char* name, std::int64_t rows) {
  if (rows <= std::numeric_limits<std::int32_t>::max()) return;
  throw ShapeError("BalProblem." + std::string(name) + " has " + std::to_string(rows) +
                   " rows; indices are 32-bit, so 2147483647 is the most");
}

void check_index(const char* name, const Rows<std::int32_t, 1>& index, std::int64_t count) {
  for (Eigen::Index i = 0; i < index.size(); ++i) {
    if (index[i] >= 0 && index[i] < count) continue;
    throw ShapeError("BalProblem." + std::string(name) + "[" + std::to_string(i) + "] is " +
                     std::to_string(index[i]) + ", not in [0, " + std::to_string(count) + ")");
  }
}

template <typename Table>
bool same_bits(const Table& a, const Table& b) {
  if (a.rows() != b.rows()) return false;
  const std::size_t bytes = static_cast<std::size_t>(a.size()) * sizeof(typename Table::Scalar);
  return bytes == 0 || std::memcmp(a.data(), b.data(), bytes) == 0;
}

}  // namespace

void BalProblem::validate() const {
  check_count("cameras", num_cameras());
  check_count("points", num_points());
  check_rows("camera_index", camera_index.rows(), "observations", num_observations());
  check_rows("point_index", point_index.rows(), "observations", num_observations());
  if (colors.rows() != 0) check_rows("colors", colors.rows(), "points", num_points());
  check_index("camera_index", camera_index, num_cameras());
  check_index("point_index", point_index, num_points());
}

bool operator==(const BalProblem& a, const BalProblem& b) {
  return same_bits(a.camera_index, b.camera_index) && same_bits(a.point_index, b.point_index) &&
         same_bits(a.cameras, b.cameras) && same_bits(a.points, b.points) &&
         same_bits(a.observations, b.observations) && same_bits(a.colors, b.colors);
}

bool operator!=(const BalProblem& a, const BalProblem& b) { return !(a == b); }

}  // namespace raylign
