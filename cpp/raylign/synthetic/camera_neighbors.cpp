// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/camera_neighbors.h"

#include <algorithm>
#include <cmath>

namespace raylign {
namespace {

constexpr double kMinViewCosine = -0.1;  // cameras that look apart share nothing
constexpr double kCamerasPerCell = 8.0;

}  // namespace

void NeighborList::sort_up_to(std::size_t count) {
  const auto better = [](const Candidate& a, const Candidate& b) {
    return a.score != b.score ? a.score < b.score : a.camera < b.camera;
  };
  count = std::min(count, size());
  std::partial_sort(candidates_.begin() + num_sorted_, candidates_.begin() + count,
                    candidates_.end(), better);
  num_sorted_ = count;
}

CameraNeighbors::CameraNeighbors(const BalScene& scene, double max_distance)
    : cameras_(scene.cameras()),
      max_distance_(max_distance),
      distance_scale_(0.5 * scene.viewing_distance()) {
  Vector2 low = cameras_[0].center.head<2>();
  Vector2 high = low;
  for (const SceneCamera& camera : cameras_) {
    low = low.cwiseMin(camera.center.head<2>());
    high = high.cwiseMax(camera.center.head<2>());
  }
  origin_ = low;
  const Vector2 extent = (high - low).cwiseMax(1.0);
  cell_size_ = std::sqrt(extent.prod() * kCamerasPerCell / static_cast<double>(cameras_.size()));
  for (int axis = 0; axis < 2; ++axis)
    size_[axis] = static_cast<int>(extent[axis] / cell_size_) + 1;
  // Counting sort by cell.
  cell_begin_.assign(static_cast<std::size_t>(size_[0]) * size_[1] + 1, 0);
  std::vector<std::int32_t> cell_of(cameras_.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    cell_of[i] = cell_coordinate(cameras_[i].center.y(), 1) * size_[0] +
                 cell_coordinate(cameras_[i].center.x(), 0);
    ++cell_begin_[cell_of[i] + 1];
  }
  for (std::size_t i = 1; i < cell_begin_.size(); ++i) cell_begin_[i] += cell_begin_[i - 1];
  std::vector<std::int32_t> next(cell_begin_.begin(), cell_begin_.end() - 1);
  cell_cameras_.resize(cameras_.size());
  for (std::size_t i = 0; i < cameras_.size(); ++i) {
    cell_cameras_[next[cell_of[i]]++] = static_cast<std::int32_t>(i);
  }
}

int CameraNeighbors::cell_coordinate(double value, int axis) const {
  const int cell = static_cast<int>(std::floor((value - origin_[axis]) / cell_size_));
  return std::clamp(cell, 0, size_[axis] - 1);
}

void CameraNeighbors::append_cell(int camera, int x, int y, NeighborList& list) const {
  const SceneCamera& reference = cameras_[camera];
  const int cell = y * size_[0] + x;
  for (int k = cell_begin_[cell]; k < cell_begin_[cell + 1]; ++k) {
    const std::int32_t other = cell_cameras_[k];
    if (other == camera) continue;
    const double cosine = cameras_[other].R_cw.row(2).dot(reference.R_cw.row(2));
    if (cosine < kMinViewCosine) continue;
    const double distance = (cameras_[other].center - reference.center).norm() / distance_scale_;
    list.candidates_.push_back({distance * distance + 4.0 * (1.0 - cosine), other});
  }
}

void CameraNeighbors::append_cell_ring(int camera, int ring, NeighborList& list) const {
  const int cx = cell_coordinate(cameras_[camera].center.x(), 0);
  const int cy = cell_coordinate(cameras_[camera].center.y(), 1);
  for (int y = std::max(0, cy - ring); y <= std::min(size_[1] - 1, cy + ring); ++y) {
    const bool full_row = std::abs(y - cy) == ring;
    const int step = full_row || ring == 0 ? 1 : 2 * ring;
    for (int x = cx - ring; x <= cx + ring; x += step) {
      if (x >= 0 && x < size_[0]) append_cell(camera, x, y, list);
    }
  }
}

void CameraNeighbors::query(int camera, NeighborList& list) const {
  list.candidates_.clear();
  list.num_sorted_ = 0;
  const int max_ring = std::max(size_[0], size_[1]);
  bool enough = false;
  for (int ring = 0; ring <= max_ring && !enough; ++ring) {
    if ((ring - 1) * cell_size_ > 2.0 * max_distance_) break;
    // One ring more than needed: the corners of the square are farther than its sides.
    enough = list.candidates_.size() > NeighborList::kMaxSize;
    append_cell_ring(camera, ring, list);
  }
}

}  // namespace raylign
