// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>

/// The inner loops of the native photometric engine: plain C over raw arrays, compiled for several
/// instruction sets and chosen at run time. No Eigen here (base/clones.h).
///
/// Notation as in docs/theory/photometric.md. All pixels of an edge share the motion of (u, v), so
/// that with z = (δu, δv, δα, δβ), α = log gain and β = offset, a residual
/// r_n = s(α) (c_n − e^α I_n − β) changes by −f_n z, f_n = [g_n, q_n, s]: g_n = s e^α ∇I_n and
/// q_n = s e^α I_n + τ r_n, τ = −∂ log s / ∂α. An edge's part of the normal equations is
/// Fᵀ T F and −Fᵀ v, z = F δ: T = Σ w f fᵀ (4×4), v = Σ w r f.
namespace raylign::native {

/// Numbers of an image in the normal equations: ξ (6), a, b, then fx, fy, cx, cy when they move.
inline constexpr int kImageColumns = 8;
inline constexpr int kImageColumnsWithIntrinsics = 12;

/// An image as the kernels read it; R_cw by rows.
struct ImagePacket {
  double R[9];
  double t[3];
  double fx, fy, cx, cy;
  double gain, inverse_gain;  ///< e^a, e^−a
  double b;
};

/// patch_image.h's PatchPlane.
struct PlaneRef {
  const float* origin;
  std::ptrdiff_t stride;
  double max_u, max_v;
};

/// How pixels are read, and where the kernels know a shorter way.
enum class Reader {
  SQUARE_BSPLINE,  ///< 4x4 patches whose pixels share one fraction
  SQUARE_BILINEAR,
  BSPLINE,  ///< any pattern, any warp
  BILINEAR,
  CENTRAL_DIFFERENCE,  ///< of the original exercise, pixel coordinates in single precision
};

/// The robust law; LOG is Cauchy and Student's t: ρ(s) = k log(1 + s / k).
enum class Law { TRIVIAL, HUBER, LOG };

struct KernelEdge {
  std::int32_t image;
  std::int32_t plane;  ///< in PatchArrays::planes
  std::uint32_t mask;  ///< in the kernel's order of the pixels
  std::int16_t level;
  std::uint16_t slot;  ///< of its image among the point's, see PatchArrays::slot_starts
  float A[4];
  bool has_warp;  ///< A is not the identity
  bool is_alive;  ///< seen at the start of the solve, or counted whenever it is seen
};

/// What every kernel walks along; nothing of it changes during a solve but `is_alive`.
struct PatchArrays {
  int num_pixels;          ///< of the pattern
  int padded_pixels;       ///< its patches' rows: a multiple of 4
  const float* offsets_u;  ///< (padded_pixels,)
  const float* offsets_v;
  Reader reader;
  double min_depth;    ///< −infinity: points behind are seen, too
  double noise_ratio;  ///< κ of s = √((1 + κ) / (1 + κ e^{2α}))
  const PlaneRef* planes;
  const std::int64_t* starts;  ///< (N + 1,) first edge of each point
  const KernelEdge* edges;
  const float* patches;             ///< (N, padded_pixels), kernel's order
  const std::int32_t* hosts;        ///< (N,) −1: none
  const std::uint16_t* host_slots;  ///< (N,)
  const double* host_uv;            ///< (N, 2) px
  const std::int64_t* slot_starts;  ///< (N + 1,) first slot of each point
  const std::int32_t* slot_images;  ///< ascending per point: its images, the host's among them
  /// (edges,) or null: set once an edge is not seen; from then on it has no gradient. The original
  /// exercise's rule.
  unsigned char* was_out;
  bool inverse_depth;
  bool with_intrinsics;
  Law law;
  bool per_patch;    ///< the law sees ‖r‖² of an edge
  double law_scale;  ///< HUBER: a; LOG: k
};

/// What moves.
struct PatchStateArrays {
  const ImagePacket* images;
  const double* points;  ///< (N, 3), inverse depth: (N, 3) of which the first counts
};

/// H and g of a point: (xx, xy, xz, yy, yz, zz); inverse depth uses the first of each.
struct PointBlock {
  double H[6];
  double g[3];
};

/// What a pass over points adds up.
struct PatchSums {
  double cost = 0.0;
  std::int64_t num_seen = 0;  ///< alive edges that are seen
};

/// Where the normal equations go. C = kImageColumns(WithIntrinsics).
struct NormalArrays {
  PointBlock* points;                ///< (N,)
  double* W;                         ///< (slots, 3, C): ∂point ∂image block of each slot
  double* diagonal;                  ///< (M, C, C) added to
  double* cross;                     ///< (blocks, C, C) added to, or null when no point has a host
  double* gradient;                  ///< (M, C) added to
  const std::int64_t* block_starts;  ///< (M,) block of (i, i); (i, k), i <= k, at + k − i
};

/// Points [begin, end): cost, H, g, W. `edge_costs`: (edges,) or null: where the cost of each edge
/// goes, −1 when it is not seen. `left_costs`: what an edge costs that is not seen, (edges,) or
/// null: nothing.
PatchSums linearize_points(const PatchArrays& arrays,
                           const PatchStateArrays& state,
                           std::int64_t begin,
                           std::int64_t end,
                           const double* left_costs,
                           double* edge_costs,
                           const NormalArrays& out);

/// The cost alone.
PatchSums evaluate_points(const PatchArrays& arrays,
                          const PatchStateArrays& state,
                          std::int64_t begin,
                          std::int64_t end,
                          const double* left_costs);

}  // namespace raylign::native
