// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/photometric/point_system.h"

namespace raylign {

/// A⁺ of a symmetric positive semidefinite A: the inverse, or where A is singular after scaling its
/// diagonal to one, the inverse on what is left.
struct SymmetricInverse {
  Eigen::MatrixXd inverse;
  int nullity = 0;
};
SymmetricInverse invert_symmetric(const Eigen::MatrixXd& A);

/// A point eliminated from its system.
struct ReducedPoint {
  explicit ReducedPoint(const PointSystem& system);

  PointBlock V_inverse;  ///< (d, d)
  PointColumns Y;        ///< (L, d) W V⁻¹
  int nullity = 0;       ///< directions that the point's edges do not determine
};

/// δX = A δ_p + G δ_c: how a world point follows its own coordinates and those of `columns`.
struct WorldPointMotion {
  PointColumns A;     ///< (3, d)
  Eigen::MatrixXd G;  ///< (3, L)
};
WorldPointMotion world_point_motion(const PatchScene& scene,
                                    const PatchColumns& columns,
                                    const PointSystem& system,
                                    std::int64_t point);

/// Covariance of all poses, (6M, 6M), from that of the columns.
Eigen::MatrixXd pose_covariance(const PatchColumns& columns, const Eigen::MatrixXd& covariance);

/// Adds a point's (L, L) to the rows and columns that it stands for.
void scatter(const std::vector<int>& columns, const Eigen::MatrixXd& block, Eigen::MatrixXd& sum);
/// The opposite.
Eigen::MatrixXd gather(const std::vector<int>& columns, const Eigen::MatrixXd& matrix);

}  // namespace raylign
