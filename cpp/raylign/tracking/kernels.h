// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/image/gradient.h"
#include "raylign/residuals/photometric.h"
#include "raylign/robust/loss.h"

/// The inner loop of direct alignment: one pass over the points of a keyframe gives the cost and
/// the normal equations at a pose. Plain C over raw arrays in float, compiled for several
/// instruction sets (base/clones.h); the scalar twin is evaluate_point (point.h), on the same
/// definition of the residuals (residuals/photometric.h). No Eigen here.
namespace raylign::tracking {

/// Points come in groups of this many; the last group of a tile is filled up with points that
/// project nowhere.
inline constexpr int kLanes = 8;
inline constexpr int kPoseColumns = 7;   ///< [υ; ω; σ]
inline constexpr int kMaxColumns = 8;    ///< photometric: [υ; ω], a, b; depth: [υ; ω; σ]
inline constexpr int kMaxTriangle = 36;  ///< of 8 columns, upper, row by row

/// Inverse depth of the target, its gradient, and the variance of the 2x2 pixels from here to the
/// right and below; variance < 0: those four are no basis for interpolation.
struct alignas(16) DepthCell {
  float D;
  float du;
  float dv;
  float variance;
};

/// Arrays over the points, padded tile by tile to kLanes, 32-byte aligned. Padding has D = NaN.
struct PointArrays {
  const float* ray_x;
  const float* ray_y;
  const float* D;
  const float* V;
  const float* I;
  const float* g_u;
  const float* g_v;
};

/// Target image and depth of one level, of the same size; `depth` may be null.
struct TargetArrays {
  const GradientCell* cells;
  const DepthCell* depth;
  int width;
  int height;
};

/// 1/σ² per point at which a cost is taken; 0: the point had no residual there.
struct PrecisionArrays {
  float* photometric;
  float* depth;
};

/// What stays the same during a pass.
struct PassSettings {
  WarpPose<float> pose;
  float gain;             ///< e^a
  float b;                ///< grey levels
  float host_variance;    ///< σ_h²
  float target_variance;  ///< e^{2a} σ_t²
  bool exact_noise;       ///< the target's noise times bilinear_noise_factor
  bool esm;               ///< mean of the target's and the keyframe's gradient
  float roll_cos, roll_sin;
  bool with_brightness;  ///< columns a, b
  float depth_gate;      ///< |r_d| / D_t beyond which the target shows another surface
  bool depth_gradient;   ///< ∇D_t in the depth residual's derivatives
  bool with_scale;       ///< column σ of the depth residual
  bool freeze;           ///< weights from `reference`, too, where it has them
  const Loss* loss;
  float photometric_scale;  ///< residuals are normalised by scale · σ
  float depth_scale;
  const float* reference_photometric;  ///< 1/σ² of the state that a trial is compared with, or null
  const float* reference_depth;
};

/// Sums over points of one term; H and g of ½ Σ ρ(n²) by iteratively re-weighted least squares.
struct TermSums {
  double H[kMaxTriangle] = {};
  double g[kMaxColumns] = {};
  double rho = 0.0;              ///< Σ ρ, at this pose's σ
  double rho_reference = 0.0;    ///< Σ ρ, at the reference's σ
  double count = 0.0;            ///< points with a residual
  double weight = 0.0;           ///< Σ ρ′
  double weighted_square = 0.0;  ///< Σ ρ′ n²
};

struct PassSums {
  TermSums photometric;
  TermSums depth;
  double good = 0.0;   ///< points with r² < 40² + |∇I_t|² / 4
  double usage = 0.0;  ///< Σ min(1, Z_h / Z')
};

/// Points of a tile are [begin, end) of the arrays; the last `end − begin − count` are padding.
struct Tile {
  std::int64_t begin;
  std::int64_t end;
  int count;
};

/// What a tile says about the fit; for the block-wise covariance and the status.
struct TileSums {
  float g_photometric[kMaxColumns];
  float g_depth[kMaxColumns];
  float count;
  /// Of points whose partner, another point of the tile, has a residual, too: how many there are,
  /// how many agree (r² < 9 σ_r²), and how many would agree with the target at their partner's
  /// place.
  float pairs, agree, agree_by_chance;
};

/// The points of tiles that follow one another: adds to `sums`, writes 1/σ² of this pose to
/// `precisions` and, where `tile_sums` is not null, what each tile says.
void evaluate(const PointArrays& points,
              const TargetArrays& target,
              const PassSettings& settings,
              const Tile* tiles,
              int num_tiles,
              const PrecisionArrays& precisions,
              PassSums& sums,
              TileSums* tile_sums);

}  // namespace raylign::tracking
