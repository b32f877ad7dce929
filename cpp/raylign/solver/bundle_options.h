// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/robust/loss.h"
#include "raylign/solver/options.h"

namespace raylign {

/// Which engine solves.
enum class Backend {
  AUTO,    ///< NATIVE where it has what the call asks for, else CERES; Summary::backend_reason
  CERES,   ///< Ceres Solver with hand-written Jacobians: every option
  NATIVE,  ///< raylign's own Schur-complement engine: XYZ and homogeneous points, at most three
           ///< free intrinsics per camera; fast, same bits on any number of threads
};

/// How a camera pose moves. The cost, the optimum and the undamped Gauss-Newton step are the same
/// for all; the damped trajectory is not.
enum class PoseParametrization {
  SE3,         ///< T_cw ← exp(ξ) T_cw, ξ = [υ; ω]: left perturbation
  QUATERNION,  ///< q ← exp(ω) q, t ← t + δt
  ANGLE_AXIS,  ///< ω ← ω + δω, t ← t + δt: additive, as Ceres' BAL example
};

enum class PointParametrization {
  XYZ,
  HOMOGENEOUS,    ///< unit 4-vector [x; w]: points at infinity are ordinary points
  INVERSE_DEPTH,  ///< (α, β, ρ) in the frame of the first camera that sees the point
};

/// How NATIVE keeps the Jacobian between the passes of an iteration. All arithmetic is in double
/// either way, and the minimum is the same: the gradient is never rounded.
enum class JacobianStorage {
  AUTO,    ///< least squares: none, computed again; else FLOAT above a million observations
  DOUBLE,  ///< 96 bytes per observation
  FLOAT,   ///< 48 bytes; DOUBLE from the moment on when steps suffer (Summary::jacobian_storage)
};

/// How a bundle adjustment is solved (what is held fixed: BundleConfig).
struct BundleOptions {
  Backend backend = Backend::AUTO;
  PoseParametrization pose_parametrization = PoseParametrization::SE3;
  PointParametrization point_parametrization = PointParametrization::XYZ;
  Loss loss;
  LmOptions lm;
  LinearSolverOptions linear_solver;
  JacobianStorage jacobian_storage = JacobianStorage::AUTO;  ///< NATIVE only.
  bool parity = false;  ///< NATIVE: take the steps of Ceres, one by one, instead of better ones.

  void validate() const;
};

std::string to_string(Backend backend);
std::string to_string(PoseParametrization parametrization);
std::string to_string(PointParametrization parametrization);
std::string to_string(JacobianStorage storage);

}  // namespace raylign
