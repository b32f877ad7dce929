// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/problem_checks.h"

#include <Eigen/LU>
#include <limits>

#include "raylign/base/error.h"

namespace raylign {

void check_rows(const std::string& field,
                std::int64_t rows,
                const std::string& other,
                std::int64_t expected) {
  if (rows == expected) return;
  throw ShapeError(field + " has " + std::to_string(rows) + " rows, but " + other + " has " +
                   std::to_string(expected));
}

void check_count(const std::string& field, std::int64_t rows) {
  if (rows <= std::numeric_limits<std::int32_t>::max()) return;
  throw ShapeError(field + " has " + std::to_string(rows) +
                   " rows; indices are 32-bit, so 2147483647 is the most");
}

void check_index(const std::string& field, const Rows<std::int32_t, 1>& index, std::int64_t count) {
  for (Eigen::Index i = 0; i < index.size(); ++i) {
    if (index[i] >= 0 && index[i] < count) continue;
    throw ShapeError(field + "[" + std::to_string(i) + "] is " + std::to_string(index[i]) +
                     ", not in [0, " + std::to_string(count) + ")");
  }
}

void check_rigid(const std::string& field, const Matrix4& T) {
  const Matrix3 R = T.topLeftCorner<3, 3>();
  const bool rigid =
      T.allFinite() && T.row(3) == Vector4::UnitW().transpose() && R.determinant() > 0.0 &&
      (R.transpose() * R - Matrix3::Identity()).cwiseAbs().maxCoeff() <= kRotationTolerance;
  if (!rigid) throw ShapeError(field + " is not a rigid transform [R t; 0 0 0 1]");
}

}  // namespace raylign
