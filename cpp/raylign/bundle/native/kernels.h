// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/robust/loss.h"

/// The inner loops of the native engine: plain C over raw arrays, compiled for several instruction
/// sets and chosen at run time. No Eigen here: its inline functions would be shared with units that
/// are compiled for another instruction set.
///
/// Notation as in docs/theory/native-engine.md: A = ∂r/∂X (2×3), also −∂r/∂c; a = X − c; I =
/// ∂r/∂(f, k1, k2); F = [a × A | −A | I], row by row, the 2×9 Jacobian of the canonical camera
/// tangent [ω; δc; δ(f, k1, k2)]. Robust weights √ρ′ are in A, I and r. Homogeneous points:
/// a = x̃ − w̃ c, F = [a × A | −w̃ A | I], and E = ∂r/∂δ takes the place of A in what concerns the
/// point (point_kinds.h); for XYZ points E is A. Cameras other than BAL: I holds the columns of up
/// to three parameters that may move (camera_kinds.h).
namespace raylign::native {

/// Nine numbers of a camera in a row of twelve: three AVX2 registers, one and a half of AVX-512.
inline constexpr int kRow = 12;
/// A 9×9 block in such rows.
inline constexpr int kBlock = 9 * kRow;

struct alignas(32) Block {
  double values[kBlock];
};

/// A camera as the kernels read it; R_cw by rows, c = −Rᵀt.
struct CameraPacket {
  double R[9];
  double t[3];
  double c[3];
  double intrinsics[9];       ///< in the order of the camera class, as many as it has
  double max_radius_squared;  ///< RADTAN: where its distortion folds back
  std::int32_t columns[3];    ///< parameter of each column of I, −1: none; BAL has 0, 1, 2
};

/// What one observation contributes to J; by rows. Numbers are double, or one for each of several
/// observations.
template <typename T>
struct JacobianOf {
  T A[6];
  T I[6];
};
using ObservationJacobian = JacobianOf<double>;

/// The same rounded once, in half the memory; everything but the gradient is made of the rounded
/// numbers, in double, so that S stays positive semidefinite and keeps its gauge directions.
struct RoundedJacobian {
  float A[6];
  float I[6];
};

/// J of all observations: in `rounded`, or in `exact` where that is null; where both are, J is
/// computed again wherever it is needed, which takes the same time and no memory (least squares
/// only: it has no weights).
struct Jacobians {
  ObservationJacobian* exact;
  RoundedJacobian* rounded;
};

/// H = Σ EᵀE as (xx, xy, xz, yy, yz, zz) and g = Σ Eᵀr of a landmark.
template <typename T>
struct LandmarkBlockOf {
  T H[6];
  T g[3];
};
using LandmarkBlock = LandmarkBlockOf<double>;

/// The upper triangle of W = L⁻ᵀ, L Lᵀ = H + λD, as (xx, xy, xz, yy, yz, zz); row and column of a
/// held coordinate are zero, and all of it when there is no factor.
template <typename T>
struct LandmarkFactorOf {
  T W[6];
};
using LandmarkFactor = LandmarkFactorOf<double>;

/// H and g of a camera in the canonical tangent.
struct CameraSums {
  Block U;
  alignas(32) double g[kRow];
};

/// What a camera is; CameraModel without its headers.
enum class CameraKind { BAL, PINHOLE, RADTAN };

/// How a landmark lies in X.
enum class PointKind {
  XYZ,          ///< (L, 3)
  HOMOGENEOUS,  ///< (L, 4), unit vectors [x̃; w̃] in the frame of the cameras' packets
};

/// The observations of a window by one camera; they begin where those of the visit before end.
struct CameraVisit {
  std::int32_t camera;
  std::int32_t end;  ///< counted from the window's first
};

/// The data that every kernel walks along; `landmark` indexes starts, X and the blocks. See Layout.
struct Observations {
  const std::int64_t* starts;
  const std::int32_t* camera;
  const double* uv;
  const std::int64_t* windows;  ///< first landmark of each window
  const std::int32_t* places;
  const CameraVisit* visits;
  const std::int64_t* window_visits;
  PointKind point_kind = PointKind::XYZ;
  CameraKind camera_kind = CameraKind::BAL;
};

/// F and r of one observation: two rows of eight, the ninth of each, r.
struct alignas(64) CameraRows {
  double F[2][8];
  double tail[2];
  double r[2];
};

/// A state of the problem: everything that a residual is made of. Pointers into the caller's
/// arrays.
struct State {
  Observations observations;
  const CameraPacket* packets;  ///< (C,)
  const double* X;              ///< (L, 3) or (L, 4)
  const Loss* loss;             ///< null: least squares
};

/// Where `linearize` writes.
struct LinearizationTables {
  Jacobians J;            ///< (N,)
  LandmarkBlock* blocks;  ///< (L,)
  CameraSums* cameras;    ///< added to; of cameras from `first_camera` on
  std::int32_t first_camera;
  CameraRows* scratch;  ///< (Layout::max_window(),), one per thread
};

/// Windows [begin, end): writes J, H and g, adds to the cameras' sums. Returns ½ Σ ρ(‖r‖²), NaN
/// when a point lies in a camera's plane.
double linearize(const State& state,
                 std::int64_t begin,
                 std::int64_t end,
                 const LinearizationTables& out);

/// The two bodies of `linearize`, by the width of their vectors, for the tests; it takes the one
/// that the machine runs faster.
using Linearize = decltype(linearize);
Linearize* narrow_linearize();
Linearize* wide_linearize();  ///< null where there is no AVX-512

/// A linearised and damped problem: all that S is made of. Pointers into the caller's arrays.
struct DampedProblem {
  Observations observations;
  const CameraPacket* packets;     ///< (C,)
  const double* X;                 ///< (L, 3)
  Jacobians J;                     ///< (N,)
  const LandmarkBlock* landmarks;  ///< (L,)
  const LandmarkFactor* factors;   ///< (L,) of the damped landmarks
  const CameraSums* cameras;       ///< (C,)
  const double* damping;           ///< added to the diagonal of S, by the user's columns
  int linearization;               ///< which one: rises by one whenever J is computed again
  bool tight = false;              ///< the step shall be exact
};

}  // namespace raylign::native
