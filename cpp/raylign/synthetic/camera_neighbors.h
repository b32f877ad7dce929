// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <vector>

#include "raylign/synthetic/bal_scene.h"

namespace raylign {

/// Cameras that may share points with one camera, best first: near and looking the same way; ties
/// by index. Sorted only as far as it is read.
class NeighborList {
 public:
  static constexpr std::size_t kMaxSize = 1024;

  std::size_t size() const { return std::min(candidates_.size(), kMaxSize); }
  std::int32_t operator[](std::size_t i) {
    if (i >= num_sorted_) sort_up_to(4 * (i + 16));
    return candidates_[i].camera;
  }

 private:
  friend class CameraNeighbors;
  struct Candidate {
    double score;
    std::int32_t camera;
  };

  void sort_up_to(std::size_t count);

  std::vector<Candidate> candidates_;
  std::size_t num_sorted_ = 0;
};

/// Finds neighbours. A grid in the ground plane keeps a query independent of the number of cameras.
class CameraNeighbors {
 public:
  CameraNeighbors(const BalScene& scene, double max_distance);

  /// Replaces `list` by the neighbours of `camera`, without itself.
  void query(int camera, NeighborList& list) const;

 private:
  int cell_coordinate(double value, int axis) const;
  void append_cell_ring(int camera, int ring, NeighborList& list) const;
  void append_cell(int camera, int x, int y, NeighborList& list) const;

  const std::vector<SceneCamera>& cameras_;
  double max_distance_;
  double distance_scale_;
  double cell_size_ = 1.0;
  Vector2 origin_ = Vector2::Zero();
  int size_[2] = {1, 1};
  std::vector<std::int32_t> cell_begin_;  // cell i: cell_cameras_[cell_begin_[i] … [i + 1])
  std::vector<std::int32_t> cell_cameras_;
};

}  // namespace raylign
