// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/base/thread_pool.h"
#include "raylign/tracking/frame.h"
#include "raylign/tracking/kernels.h"
#include "raylign/tracking/keyframe.h"
#include "raylign/tracking/options.h"

namespace raylign::tracking {

/// What alignment estimates.
struct PoseState {
  Matrix4 T_th = Matrix4::Identity();
  double a = 0.0;
  double b = 0.0;
};

/// The terms' residuals are divided by these beside σ, and the depth term's cost is multiplied.
struct TermScales {
  double photometric_scale = 1.0;
  double depth_scale = 1.0;
  double depth_weight = 1.0;
};

/// What a pass leaves beside its sums: 1/σ² per point of both terms, padded as the points are, and
/// where it was asked for a row of sums per tile.
struct PassBuffers {
  std::vector<float> photometric;
  std::vector<float> depth;
  std::vector<TileSums> tiles;
  std::vector<PassSums> bands;  ///< the summands of the sums, from top to bottom
};

/// Memory of a pass; kept between levels and frames.
struct Workspace {
  PassBuffers buffers[2];
};

/// Runs the kernel over all points of a level, on several threads; the bits of the sums do not
/// depend on their number.
class PointPass {
 public:
  PointPass(const Keyframe& keyframe,
            const Frame& target,
            int level,
            const TrackingOptions& options,
            ThreadPool& pool,
            Workspace& workspace);

  /// 1/σ² and, `with_tiles`, the tiles' sums go to `out`; with `reference` the sums hold the cost
  /// at its σ², too.
  PassSums run(const PoseState& state,
               const TermScales& scales,
               const PassBuffers* reference,
               PassBuffers& out,
               bool with_tiles = false);

  /// Rows of the target are read at these twists per unit of s (tracking/shutter.h) from now on.
  void set_sweep(const Vector6& host, const Vector6& target) {
    host_sweep_ = host;
    target_sweep_ = target;
    is_swept_ = !host.isZero(0.0) || !target.isZero(0.0);
  }
  /// The left twist of T_th that the sweep gives each band.
  std::vector<Vector6> band_twists(const Matrix4& T_th,
                                   const Vector6& host_sweep,
                                   const Vector6& target_sweep) const;

  int level() const { return level_; }
  int num_points() const { return points_.num_points(); }
  double mean_inverse_depth() const { return points_.mean_inverse_depth(); }
  bool has_depth_term() const { return target_.depth != nullptr; }
  Workspace& workspace() { return workspace_; }
  PassSettings settings(const PoseState& state, const TermScales& scales) const;

 private:
  // Tiles [begin, end) make a task: a band of the image with about a thousand points.
  struct Band {
    std::size_t begin;
    std::size_t end;
    double row;  ///< of the keyframe, in its middle
  };

  void make_bands();

  const PointList& points_;
  TargetArrays target_;
  PinholeCamera camera_;
  PinholeCamera host_camera_;
  int host_width_;
  int host_height_;
  int level_;
  const TrackingOptions& options_;
  ThreadPool& pool_;
  Workspace& workspace_;
  std::vector<Band> bands_;
  Vector6 host_sweep_ = Vector6::Zero();
  Vector6 target_sweep_ = Vector6::Zero();
  bool is_swept_ = false;
};

}  // namespace raylign::tracking
