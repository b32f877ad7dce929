// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>

namespace raylign {

using Vector2 = Eigen::Vector2d;
using Vector3 = Eigen::Vector3d;
using Vector4 = Eigen::Vector4d;
using Vector6 = Eigen::Matrix<double, 6, 1>;
using Vector7 = Eigen::Matrix<double, 7, 1>;
using Matrix3 = Eigen::Matrix3d;
using Matrix4 = Eigen::Matrix4d;
using Matrix6 = Eigen::Matrix<double, 6, 6>;
using Matrix7 = Eigen::Matrix<double, 7, 7>;

/// Fixed-size Jacobian block, row-major as Ceres and NumPy want it.
template <int R, int C>
using RowMajor = Eigen::Matrix<double, R, C, (C == 1 ? Eigen::ColMajor : Eigen::RowMajor)>;

/// Table with a run-time number of rows, one record per row (C order): the layout of a NumPy (N,
/// Cols) array.
template <typename Scalar, int Cols>
using Rows =
    Eigen::Matrix<Scalar, Eigen::Dynamic, Cols, (Cols == 1 ? Eigen::ColMajor : Eigen::RowMajor)>;

}  // namespace raylign
