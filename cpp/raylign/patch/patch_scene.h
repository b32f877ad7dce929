// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <limits>
#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/image/sample_points.h"
#include "raylign/patch/patch_image.h"
#include "raylign/patch/pattern.h"

namespace raylign {

/// A patch seen by an image. Everything here is chosen before a solve and held during it.
struct PatchEdge {
  std::int32_t image = 0;
  std::int32_t level = 0;                             ///< of the image's pyramid that is read
  std::uint32_t mask = ~0u;                           ///< bit n: pixel n of the pattern counts
  std::array<float, 4> A = {1.0f, 0.0f, 0.0f, 1.0f};  ///< pattern offset → px of `level`, by rows
};

/// T_cw as it moves (parametrization/pose_update.h).
struct PatchPose {
  Quaternion q = Quaternion::Identity();
  Vector3 t = Vector3::Zero();

  Matrix4 matrix() const;  ///< [R t; 0 1]
};

/// The problem that both engines minimise: poses, points, brightness and intrinsics such that the
/// images show, around the projections of each point, the point's patch:
///
///   r_n = s (c_n − (e^{a_j − a_h} I_j(u + A o_n) + e^{−a_h} (b_j − b_h))),   u = π(K, T_j X)
///
/// c_n: grey values of the patch, in the brightness of its host h; a_h = b_h = 0 for a patch
/// without host. s = √((1 + κ) / (1 + κ e^{2 (a_j − a_h)})), κ = noise_ratio: noise of the image is
/// multiplied by the gain, and s gives all residuals the variance that they have at gain one. u is
/// in px of level 0; level l is read at (u + ½) / 2^l − ½ + A o_n. c − (…) is photometric_residual
/// of residuals/photometric.h; docs/theory/photometric.md has the derivatives.
struct PatchScene {
  // What is given.
  PatchPattern pattern;
  SampleInterpolation interpolation = SampleInterpolation::CUBIC_BSPLINE;
  double min_depth = 1e-9;  ///< points nearer than this are not seen; −infinity: seen from behind
  /// κ >= 0: variance of the noise of I_j over that of c_n. 0: s = 1, plain differences.
  double noise_ratio = 0.0;
  std::vector<std::shared_ptr<const PatchImage>> images;  ///< (M,)
  std::vector<std::int64_t> starts;                       ///< (N + 1,) first edge of each point
  std::vector<PatchEdge> edges;                           ///< in the order of the points
  std::vector<float> patches;                             ///< (N, pattern.size()) c_n
  std::vector<std::int32_t> hosts;                        ///< (N,) image of the patch, −1: none
  Rows<double, 2> host_uv;                                ///< (N, 2) px, of points with a host

  // What may move.
  std::vector<PatchPose> poses;  ///< (M,)
  Rows<double, 2> brightness;    ///< (M, 2) a, b
  Rows<double, 4> intrinsics;    ///< (1, 4) of all images, or (M, 4): fx, fy, cx, cy
  /// (N, 3) world points; or, when `inverse_depth` holds, only the first column is read: 1 / z in
  /// the host's frame, on the ray through host_uv.
  Rows<double, 3> points;
  bool inverse_depth = false;

  std::int64_t num_points() const { return static_cast<std::int64_t>(hosts.size()); }
  std::int64_t num_edges() const { return static_cast<std::int64_t>(edges.size()); }
  std::int64_t num_images() const { return static_cast<std::int64_t>(images.size()); }
  std::int64_t intrinsics_row(std::int64_t image) const {
    return intrinsics.rows() == 1 ? 0 : image;
  }
  const float* patch(std::int64_t point) const { return patches.data() + point * pattern.size(); }
  /// Throws ShapeError when lengths or indices disagree, OptionsError for inverse depth without
  /// host.
  void validate() const;
};

/// X of point p in the world frame.
Vector3 world_point(const PatchScene& scene, std::int64_t p);

/// Brightness of an edge: the image's grey values are multiplied by gain, then offset is added.
struct EdgeBrightness {
  double gain = 1.0;       ///< e^{a_j − a_h}
  double offset = 0.0;     ///< e^{−a_h} (b_j − b_h)
  double host_gain = 1.0;  ///< e^{−a_h}
  double scale = 1.0;      ///< s
  double fall = 0.0;       ///< −∂ log s / ∂(a_j − a_h) = κ gain² / (1 + κ gain²)
};
EdgeBrightness edge_brightness(const PatchScene& scene, std::int64_t point, const PatchEdge& edge);

/// One edge evaluated in double, pixel by pixel: the reference that the kernels are tested against,
/// and what everything that is not in an inner loop uses.
struct EdgeSample {
  bool is_seen = false;  ///< in front, and every pixel inside its plane; else the rest is empty
  Vector3 q = Vector3::Zero();   ///< point in the camera frame
  Vector2 uv = Vector2::Zero();  ///< its projection, px of level 0
  EdgeBrightness brightness;
  std::array<double, PatchPattern::kMaxPixels> residual{};  ///< grey levels; 0 where masked
  std::array<double, PatchPattern::kMaxPixels> value{};     ///< gain · I_j
  /// −∂r/∂(u, v), s gain ∇I_j with respect to px of level 0.
  std::array<std::array<double, 2>, PatchPattern::kMaxPixels> gradient{};

  bool counts(const PatchEdge& edge, int n) const { return (edge.mask >> n & 1u) != 0u; }
  /// ∂r_n/∂(a_j, b_j) and ∂r_n/∂(a_h, b_h), of a pixel that counts.
  std::array<double, 2> by_brightness(int n) const;
  std::array<double, 2> by_host_brightness(int n) const;
};
EdgeSample evaluate_edge(const PatchScene& scene, std::int64_t point, const PatchEdge& edge);

/// How (u, v) of level 0 moves: the 2-row Jacobians that all pixels of an edge share.
struct EdgeMotion {
  RowMajor<2, 6> pose;        ///< ∂(u, v)/∂ξ_j, T_j ← exp(ξ) T_j
  RowMajor<2, 6> host_pose;   ///< ∂(u, v)/∂ξ_h; zero but for inverse depth
  RowMajor<2, 3> point;       ///< ∂(u, v)/∂X; inverse depth: first column ∂/∂ρ, the rest zero
  RowMajor<2, 4> intrinsics;  ///< ∂(u, v)/∂(fx, fy, cx, cy) of image j
  /// The same of the host, by its ray; zero but for inverse depth. One row of intrinsics for all
  /// images: the derivative is the sum of both.
  RowMajor<2, 4> host_intrinsics;
};
/// At a sample that is seen.
EdgeMotion edge_motion(const PatchScene& scene,
                       std::int64_t point,
                       const PatchEdge& edge,
                       const EdgeSample& sample);

}  // namespace raylign
