// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <mutex>
#include <vector>

#include "raylign/tracking/frame.h"
#include "raylign/tracking/kernels.h"
#include "raylign/tracking/options.h"

namespace raylign {

/// The points of a keyframe on one level, Ω_D, tile by tile.
class PointList {
 public:
  using Tile = tracking::Tile;

  PointList(const Frame& frame, int level, const KeyframeOptions& options);

  int num_points() const { return num_points_; }
  /// Pixels with depth inside the border, points or not.
  int num_with_depth() const { return num_with_depth_; }
  std::int64_t padded_size() const { return static_cast<std::int64_t>(pixels_.size()); }
  const std::vector<Tile>& tiles() const { return tiles_; }
  /// v · width + u of each point, −1 for padding.
  const std::vector<std::int32_t>& pixels() const { return pixels_; }
  tracking::PointArrays arrays() const;
  double mean_inverse_depth() const { return mean_inverse_depth_; }

 private:
  // As aligned as the kernel's loads need it.
  struct alignas(32) Group {
    float values[tracking::kLanes];
  };
  static constexpr int kNumArrays = 7;

  struct Source;
  /// The bits of the squared gradient, then those of ~pixel: the larger, the better.
  using Candidate = std::uint64_t;

  float* array(int k) { return groups_[k].empty() ? nullptr : groups_[k].front().values; }
  const float* array(int k) const {
    return groups_[k].empty() ? nullptr : groups_[k].front().values;
  }
  void count_candidates(const Source& source, std::vector<int>& counts);
  void make_tiles(const std::vector<int>& counts, int quota);
  static void collect(const Source& source,
                      int row,
                      int column,
                      std::vector<Candidate>& candidates);
  void fill(const Source& source, std::int64_t i, const std::vector<Candidate>& candidates);

  std::vector<Tile> tiles_;
  std::vector<std::int32_t> pixels_;
  std::vector<Group> groups_[kNumArrays];
  int num_points_ = 0;
  int num_with_depth_ = 0;
  double mean_inverse_depth_ = 0.0;
};

/// K = (I, D, V) of LSD-SLAM §3.3: a frame with depth, and its points per level. Point lists are
/// built when a level is first tracked on; safe from several threads.
class Keyframe {
 public:
  /// Throws ShapeError when the frame has no depth map, OptionsError.
  explicit Keyframe(std::shared_ptr<const Frame> frame, const KeyframeOptions& options = {});

  const Frame& frame() const { return *frame_; }
  const std::shared_ptr<const Frame>& shared_frame() const { return frame_; }
  const KeyframeOptions& options() const { return options_; }
  int num_levels() const { return frame_->num_levels(); }
  const PointList& points(int level) const;

 private:
  std::shared_ptr<const Frame> frame_;
  KeyframeOptions options_;
  mutable std::vector<std::unique_ptr<PointList>> levels_;
  mutable std::mutex mutex_;
};

}  // namespace raylign
