// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <cstring>
#include <string>

#include "raylign/base/eigen.h"

/// What every class of problems asks of its arrays. `field` is the full name, "BalProblem.cameras".
namespace raylign {

/// Throws ShapeError when `rows` is not what `other` has.
void check_rows(const std::string& field,
                std::int64_t rows,
                const std::string& other,
                std::int64_t expected);
/// Throws ShapeError when 32-bit indices cannot count the rows.
void check_count(const std::string& field, std::int64_t rows);
/// Throws ShapeError for an index outside [0, count).
void check_index(const std::string& field, const Rows<std::int32_t, 1>& index, std::int64_t count);

/// Throws ShapeError unless T is [R t; 0 1], finite, with R right-handed and orthonormal to
/// kRotationTolerance.
void check_rigid(const std::string& field, const Matrix4& T);
/// Largest entry of |RᵀR − I|: what poses that went through float32 have.
inline constexpr double kRotationTolerance = 1e-5;

/// Bitwise equality: 0.0 and −0.0 differ, a NaN equals the same NaN.
template <typename Table>
bool same_bits(const Table& a, const Table& b) {
  if (a.rows() != b.rows() || a.cols() != b.cols()) return false;
  const std::size_t bytes = static_cast<std::size_t>(a.size()) * sizeof(typename Table::Scalar);
  return bytes == 0 || std::memcmp(a.data(), b.data(), bytes) == 0;
}

}  // namespace raylign
