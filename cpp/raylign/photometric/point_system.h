// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"

namespace raylign {

/// Column of each free coordinate but those of the points.
struct PatchColumns {
  std::vector<PoseEmbedding> embeddings;       ///< (M,) ξ = E δ
  std::vector<int> poses;                      ///< (M,) first column of δ
  std::vector<std::array<int, 2>> brightness;  ///< (M,) of a, b; −1: held
  std::vector<std::array<int, 4>> intrinsics;  ///< rows of PatchScene::intrinsics; −1: held
  std::int64_t size = 0;
};
PatchColumns patch_columns(const PatchScene& scene, const PatchConstraints& constraints);

/// Where noise has the same σ everywhere.
enum class NoiseSite {
  RESIDUAL,  ///< in r, as a fitted law has it
  IMAGE,     ///< in the grey values, of which r has gain times as much; rows are divided by it
};

/// Matrices with as many rows or columns as a point has free coordinates.
using PointColumns = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, Eigen::Dynamic, 3>;
using PointBlock = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, 3, 3>;

/// Normal equations of one point, from rows j = ∂r/∂(columns, point) of its pixels and weights
/// w = ρ′. L: columns that the point's edges have to do with; d: its free coordinates.
struct PointSystem {
  std::vector<int> columns;  ///< (L,) of PatchColumns
  Eigen::MatrixXd H;         ///< (L, L) Σ w j jᵀ
  PointColumns W;            ///< (L, d)
  PointBlock V;              ///< (d, d)
  PointBlock prior;          ///< (d, d) part of V
  /// Σ w j r, without that of the prior.
  Eigen::VectorXd gradient;                              ///< (L,)
  Eigen::Matrix<double, -1, 1, 0, 3, 1> point_gradient;  ///< (d,)
  /// What gradients of variance 1 per pixel of the image, in each direction, add to H, W and V. Not
  /// of the host, where the patch has the same noise.
  Eigen::MatrixXd steep_H;
  PointColumns steep_W;
  PointBlock steep_V;
  /// Σ_v s √w j of each pixel over the images that are not the host: what noise of the patch does.
  /// s = 1, or 1 / gain for NoiseSite::IMAGE.
  Eigen::MatrixXd shared;                              ///< (n, L)
  PointColumns shared_point;                           ///< (n, d)
  std::array<double, PatchPattern::kMaxPixels> views;  ///< Σ_v s² over the same
  /// √w j in the host image, which shows its own patch without noise; no rows without such an edge.
  Eigen::MatrixXd host;     ///< (n or 0, L)
  PointColumns host_point;  ///< (n or 0, d)
};

/// Weights of the pixels of an edge at its residuals: ρ′ of r_n², or of ‖r‖² of the patch; 0 where
/// masked.
std::array<double, PatchPattern::kMaxPixels> pixel_weights(const PatchEdge& edge,
                                                           const EdgeSample& sample,
                                                           int num_pixels,
                                                           const Loss& loss,
                                                           LossScope scope);

/// Builds the systems of points one after the other, in double, from evaluate_edge.
class PointSystemBuilder {
 public:
  /// All three must outlive the builder. Edges that are not seen do not count.
  PointSystemBuilder(const PatchScene& scene,
                     const PatchColumns& columns,
                     const PatchConstraints& constraints,
                     const Loss& loss,
                     LossScope scope,
                     NoiseSite site = NoiseSite::RESIDUAL);

  const PointSystem& build(std::int64_t point);

 private:
  static constexpr int kMaxColumns = 24;  // of two images: pose, intrinsics, a, b
  struct EdgeRows {
    Eigen::Matrix<double, Eigen::Dynamic, 1, 0, PatchPattern::kMaxPixels, 1> residual;  // √w r
    bool is_host = false;
    double s = 1.0;  // as in PointSystem
    std::array<bool, PatchPattern::kMaxPixels> counts;
    int num_columns = 0;
    double steepness = 0.0;                       // Σ w (gain / px per pixel of the level)²
    Eigen::Matrix<double, 2, kMaxColumns> moves;  // of (u, v), by column
    RowMajor<2, 3> point_moves;
    std::array<int, kMaxColumns> columns;  // of PatchColumns, then of the point's system
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, PatchPattern::kMaxPixels, kMaxColumns>
        camera;  // (n, kMaxColumns) √w j, num_columns of them
    Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, 0, PatchPattern::kMaxPixels, 3> point;
  };

  bool fill(std::int64_t point, const PatchEdge& edge, int num_free, EdgeRows& rows) const;
  void fill_motion(std::int32_t j,
                   std::int32_t h,
                   const EdgeSample& sample,
                   const EdgeMotion& motion,
                   EdgeRows& rows) const;
  void fill_brightness(std::int32_t j,
                       std::int32_t h,
                       const EdgeSample& sample,
                       EdgeRows& rows) const;
  void add(const EdgeRows& rows);
  void add_prior(std::int64_t point, int num_free);

  const PatchScene& scene_;
  const PatchColumns& columns_;
  const PatchConstraints& constraints_;
  const Loss loss_;
  const LossScope scope_;
  const NoiseSite site_;
  std::vector<Matrix3> priors_;  // (N,) or empty
  std::vector<int> local_;       // column of the point's system, −1: none
  std::vector<EdgeRows> edges_;
  PointSystem system_;
};

}  // namespace raylign
