// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/keyframe.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "raylign/base/error.h"

namespace raylign {
namespace {

using tracking::kLanes;

enum Array { RAY_X, RAY_Y, INVERSE_DEPTH, VARIANCE, INTENSITY, GRADIENT_U, GRADIENT_V };

int block_side(int level, const KeyframeOptions& options) {
  return level <= 1 ? options.block_size : options.block_size / 2;
}

// The largest number of points per tile that keeps the sum within the budget.
int tile_quota(std::vector<int> counts, int budget) {
  std::sort(counts.begin(), counts.end());
  long long left = budget;
  for (std::size_t i = 0; i < counts.size(); ++i) {
    const auto remaining = static_cast<long long>(counts.size() - i);
    if (counts[i] * remaining > left) return static_cast<int>(left / remaining);
    left -= counts[i];
  }
  return std::numeric_limits<int>::max();
}

}  // namespace

PointList::PointList(const Frame& frame, int level, const KeyframeOptions& options) {
  std::vector<std::vector<Candidate>> candidates = find_candidates(frame, level, options);
  if (options.max_points > 0) {
    std::vector<int> counts;
    for (const auto& tile : candidates) counts.push_back(static_cast<int>(tile.size()));
    const auto quota = static_cast<std::size_t>(tile_quota(counts, options.max_points));
    for (auto& tile : candidates) {
      if (tile.size() <= quota) continue;
      const auto stronger = [](const Candidate& a, const Candidate& b) {
        return a.score > b.score || (a.score == b.score && a.pixel < b.pixel);
      };
      std::nth_element(tile.begin(), tile.begin() + static_cast<std::ptrdiff_t>(quota), tile.end(),
                       stronger);
      tile.resize(quota);
      std::sort(tile.begin(), tile.end(),
                [](const Candidate& a, const Candidate& b) { return a.pixel < b.pixel; });
    }
  }
  fill(frame, level, candidates);
}

std::vector<std::vector<PointList::Candidate>> PointList::find_candidates(
    const Frame& frame, int level, const KeyframeOptions& options) {
  const GradientImage& cells = frame.gradients(level);
  const Plane<float>& D = frame.depth().inverse_depth(level);
  const Plane<float>& V = frame.depth().variance(level);
  const int width = cells.width();
  const int height = cells.height();
  const int side = block_side(level, options);
  const int columns = (width + side - 1) / side;
  const int rows = (height + side - 1) / side;
  std::vector<std::vector<Candidate>> tiles(static_cast<std::size_t>(columns) * rows);
  const auto minimum = static_cast<float>(options.min_gradient * options.min_gradient);
  // the outermost pixels have no central difference
  for (int v = 1; v < height - 1; ++v) {
    if (v % options.spacing != 0) continue;
    const std::size_t row = static_cast<std::size_t>(v / side) * columns;
    for (int u = 1; u < width - 1; ++u) {
      if (!(V.at(u, v) > 0.0F) || !(D.at(u, v) > 0.0F)) continue;
      ++num_with_depth_;
      if (u % options.spacing != 0) continue;
      const GradientCell& cell = cells.at(u, v);
      const float score = cell.du * cell.du + cell.dv * cell.dv;
      if (!(score >= minimum) || !std::isfinite(score + cell.value)) continue;
      tiles[row + static_cast<std::size_t>(u / side)].push_back({score, v * width + u});
    }
  }
  return tiles;
}

void PointList::fill(const Frame& frame,
                     int level,
                     const std::vector<std::vector<Candidate>>& candidates) {
  std::int64_t size = 0;
  for (const auto& tile : candidates) {
    if (tile.empty()) continue;
    const auto count = static_cast<std::int64_t>(tile.size());
    const std::int64_t padded = (count + kLanes - 1) / kLanes * kLanes;
    tiles_.push_back({size, size + padded, static_cast<int>(count)});
    size += padded;
    num_points_ += static_cast<int>(count);
  }
  pixels_.assign(static_cast<std::size_t>(size), -1);
  for (auto& groups : groups_) groups.assign(static_cast<std::size_t>(size / kLanes), Group{});
  if (size == 0) return;
  const PinholeCamera camera = frame.camera(level);
  const GradientImage& cells = frame.gradients(level);
  const Plane<float>& D = frame.depth().inverse_depth(level);
  const Plane<float>& V = frame.depth().variance(level);
  const int width = cells.width();
  std::fill(array(INVERSE_DEPTH), array(INVERSE_DEPTH) + size, NAN);  // padding lands nowhere
  std::fill(array(VARIANCE), array(VARIANCE) + size, 1.0F);
  std::size_t t = 0;
  for (const auto& tile : candidates) {
    if (tile.empty()) continue;
    std::int64_t i = tiles_[t++].begin;
    for (const Candidate& candidate : tile) {
      const int u = candidate.pixel % width;
      const int v = candidate.pixel / width;
      const GradientCell& cell = cells.at(u, v);
      pixels_[static_cast<std::size_t>(i)] = candidate.pixel;
      array(RAY_X)[i] = static_cast<float>((u - camera.cx()) / camera.fx());
      array(RAY_Y)[i] = static_cast<float>((v - camera.cy()) / camera.fy());
      array(INVERSE_DEPTH)[i] = D.at(u, v);
      array(VARIANCE)[i] = V.at(u, v);
      array(INTENSITY)[i] = cell.value;
      array(GRADIENT_U)[i] = cell.du;
      array(GRADIENT_V)[i] = cell.dv;
      mean_inverse_depth_ += static_cast<double>(D.at(u, v));
      ++i;
    }
  }
  mean_inverse_depth_ /= num_points_;
}

tracking::PointArrays PointList::arrays() const {
  return {array(RAY_X),     array(RAY_Y),      array(INVERSE_DEPTH), array(VARIANCE),
          array(INTENSITY), array(GRADIENT_U), array(GRADIENT_V)};
}

Keyframe::Keyframe(std::shared_ptr<const Frame> frame, const KeyframeOptions& options)
    : frame_(std::move(frame)), options_(options) {
  options_.validate();
  if (frame_ == nullptr || !frame_->has_depth()) {
    throw ShapeError("a keyframe needs a frame with inverse depth");
  }
  levels_.resize(static_cast<std::size_t>(frame_->num_levels()));
}

const PointList& Keyframe::points(int level) const {
  const std::lock_guard<std::mutex> lock(mutex_);
  std::unique_ptr<PointList>& points = levels_[static_cast<std::size_t>(level)];
  if (points == nullptr) points = std::make_unique<PointList>(*frame_, level, options_);
  return *points;
}

}  // namespace raylign
