// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/native/image_columns.h"

namespace raylign::native {

/// The Gauss-Newton system of a scene at its state (robust weights ρ′, priors in it, no damping),
/// points eliminated.
struct ReducedInformation {
  ImageColumns columns;  ///< of S: which numbers of the images they are
  Eigen::MatrixXd S;     ///< (n, n)
  /// H⁻¹ of each point by itself, images held; zero for a point that is held or that H leaves
  /// free. Inverse depth: the first entry alone.
  std::vector<Matrix3> point_inverse;
  /// ∂point ∂images blocks: of point p, slots [slot_starts[p], slot_starts[p + 1]).
  std::vector<std::int64_t> slot_starts;
  std::vector<std::int32_t> slot_images;
  std::vector<double> W;  ///< (slots, 3, C), C = 8, or 12 with intrinsics

  int num_image_columns() const { return columns.with_intrinsics() ? 12 : 8; }
  /// H⁻¹ + H⁻¹ W Σ Wᵀ H⁻¹ of point p, Σ (n, n) a covariance of the free columns.
  Matrix3 point_covariance(std::int64_t p, const Eigen::MatrixXd& covariance) const;
};

/// `options`: its loss and scope count. Throws as solve_patches.
ReducedInformation reduced_information(const PatchScene& scene,
                                       const PatchConstraints& constraints,
                                       const PatchSolveOptions& options);

/// The largest entry of the diagonal of H, images' free columns and points: what the damping of the
/// original exercise starts from.
double max_diagonal(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options);

}  // namespace raylign::native
