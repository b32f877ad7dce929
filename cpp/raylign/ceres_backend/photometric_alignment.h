// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/camera/pinhole.h"
#include "raylign/image/gradient.h"
#include "raylign/robust/loss.h"
#include "raylign/solver/options.h"

namespace raylign::ceres_backend {

/// A keyframe point with the σ_r at which it is held: Ceres minimises one cost, and a σ that is
/// computed anew at every pose minimises none.
struct PhotometricPoint {
  double ray_x, ray_y;  ///< K⁻¹(u, v, 1)
  double D;
  double I;
  double sigma;
};

struct PhotometricAlignment {
  Matrix4 T_th = Matrix4::Identity();
  double cost = -1.0;  ///< ½ Σ ρ(r² / σ²)
  bool converged = false;
};

/// Direct alignment on one level as a Ceres problem, one scalar block per point: the oracle of the
/// tracker's own optimiser, on the same residual (residuals/photometric.h) and with the same
/// gradient, the interpolated central differences. Moves T_th = exp(ξ) T_init; no brightness. A
/// point that leaves the image keeps no residual.
PhotometricAlignment align_photometric(const std::vector<PhotometricPoint>& points,
                                       const PlaneView<GradientCell>& target,
                                       const PinholeCamera& camera,
                                       const Matrix4& T_init,
                                       const Loss& loss,
                                       const LmOptions& options);

}  // namespace raylign::ceres_backend
