// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/scene/bal_problem.h"

namespace raylign {

/// A similarity as a 4x4 matrix S_ab = [s R, t; 0, 1], s > 0: p_a = s R p_b + t.

/// The problem seen from new world coordinates X' = S_nw X. Every predicted pixel stays what it
/// was: depths grow by s, R' = R_cw Rᵀ, t' = s t_cw − R' t. Pixels, intrinsics, indices and colours
/// are copied verbatim, and so are the angle-axis vectors when R is the identity. Throws ShapeError
/// if S_nw is not a similarity (to 1e-9).
BalProblem transform(const BalProblem& problem, const Matrix4& S_nw);

/// Inverse of a similarity matrix. Throws ShapeError if S_ab is not one.
Matrix4 inverse_similarity(const Matrix4& S_ab);

/// Where the points are, whatever outliers say.
struct SceneExtent {
  Vector3 center = Vector3::Zero();  ///< Coordinate-wise median of the finite points.
  double deviation = 0.0;            ///< Median L1 distance from it, scene units; 0 without points.
};
SceneExtent scene_extent(const BalProblem& problem);

/// A problem in well-scaled coordinates and the way back: transform(problem,
/// inverse_similarity(S_nw)).
struct NormalizedProblem {
  BalProblem problem;
  Matrix4 S_nw;  ///< normalised coordinates from world coordinates; rotation = identity.
};

/// Moves the coordinate-wise median of the points to the origin and scales the median L1 distance
/// from it to `extent`, as BAL's reference code does (Agarwal et al. 2010; Ceres' bal_problem.cc).
/// The way back is exact to rounding, not to the bit. A scene without extent, or with
/// one beyond the range of double, is only moved. Throws OptionsError if extent is not finite and >
/// 0.
NormalizedProblem normalize(const BalProblem& problem, double extent = 100.0);

/// World-to-camera poses, row-major 4x4 each, (C, 16): p_c = T_cw p_w, camera axes of the file (−z
/// ahead).
Rows<double, 16> camera_poses(const BalProblem& problem);

}  // namespace raylign
