// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/keyframe.h"

#include <algorithm>
#include <cmath>
#include <cstring>
#include <functional>
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

std::uint32_t pixel_of(std::uint64_t candidate) { return ~static_cast<std::uint32_t>(candidate); }

}  // namespace

// A level of a frame as points are chosen from it.
struct PointList::Source {
  Source(const Frame& frame, int level, const KeyframeOptions& options)
      : cells(frame.gradients(level)),
        D(frame.depth().inverse_depth(level)),
        V(frame.depth().variance(level)),
        camera(frame.camera(level)),
        width(cells.width()),
        height(cells.height()),
        side(block_side(level, options)),
        columns((width + side - 1) / side),
        rows((height + side - 1) / side),
        spacing(options.spacing),
        min_score(static_cast<float>(options.min_gradient * options.min_gradient)) {}

  float score(int u, int v) const {
    const GradientCell& cell = cells.at(u, v);
    return cell.du * cell.du + cell.dv * cell.dv;
  }
  // written so that NaN fails
  bool is_candidate(int u, int v) const {
    const GradientCell& cell = cells.at(u, v);
    const float s = score(u, v);
    const float sum = s + cell.value;
    return static_cast<bool>(static_cast<int>(V.at(u, v) > 0.0F) &
                             static_cast<int>(s >= min_score) &
                             static_cast<int>(sum - sum == 0.0F));
  }
  // The first column of a tile that is on the grid of candidates and inside the border.
  int first_u(int column) const {
    const int first = std::max(column * side, 1);
    return (first + spacing - 1) / spacing * spacing;
  }

  const GradientImage& cells;
  const Plane<float>& D;
  const Plane<float>& V;
  PinholeCamera camera;
  int width, height;
  int side, columns, rows;
  int spacing;
  float min_score;
};

PointList::PointList(const Frame& frame, int level, const KeyframeOptions& options) {
  const Source source(frame, level, options);
  std::vector<int> counts(static_cast<std::size_t>(source.columns) * source.rows, 0);
  count_candidates(source, counts);
  const int quota = options.max_points > 0 ? tile_quota(counts, options.max_points)
                                           : std::numeric_limits<int>::max();
  make_tiles(counts, quota);
  if (num_points_ == 0) return;
  std::vector<Candidate> candidates;
  std::size_t tile = 0;
  for (int row = 0; row < source.rows; ++row) {
    for (int column = 0; column < source.columns; ++column) {
      if (counts[static_cast<std::size_t>(row) * source.columns + column] == 0) continue;
      collect(source, row, column, candidates);
      const auto count = static_cast<std::size_t>(tiles_[tile].count);
      if (candidates.size() > count) {
        // the strongest, of equals the first
        std::nth_element(candidates.begin(),
                         candidates.begin() + static_cast<std::ptrdiff_t>(count), candidates.end(),
                         std::greater<>());
        candidates.resize(count);
        std::sort(candidates.begin(), candidates.end(),
                  [](Candidate a, Candidate b) { return pixel_of(a) < pixel_of(b); });
      }
      fill(source, tiles_[tile++].begin, candidates);
    }
  }
  mean_inverse_depth_ /= num_points_;
}

void PointList::count_candidates(const Source& source, std::vector<int>& counts) {
  // the outermost pixels have no central difference
  for (int v = 1; v < source.height - 1; ++v) {
    const float* V = source.V.row(v);
    for (int u = 1; u < source.width - 1; ++u) num_with_depth_ += V[u] > 0.0F ? 1 : 0;
    if (v % source.spacing != 0) continue;
    int* row = counts.data() + static_cast<std::ptrdiff_t>(v / source.side) * source.columns;
    for (int column = 0; column < source.columns; ++column) {
      const int end = std::min((column + 1) * source.side, source.width - 1);
      int count = 0;
      for (int u = source.first_u(column); u < end; u += source.spacing) {
        count += source.is_candidate(u, v) ? 1 : 0;
      }
      row[column] += count;
    }
  }
}

void PointList::make_tiles(const std::vector<int>& counts, int quota) {
  std::int64_t size = 0;
  for (const int candidates : counts) {
    if (candidates == 0) continue;
    const int count = std::min(candidates, quota);
    const std::int64_t padded = (std::int64_t{count} + kLanes - 1) / kLanes * kLanes;
    tiles_.push_back({size, size + padded, count});
    size += padded;
    num_points_ += count;
  }
  pixels_.assign(static_cast<std::size_t>(size), -1);
  for (auto& groups : groups_) groups.assign(static_cast<std::size_t>(size / kLanes), Group{});
  if (size == 0) return;
  std::fill(array(INVERSE_DEPTH), array(INVERSE_DEPTH) + size, NAN);  // padding lands nowhere
  std::fill(array(VARIANCE), array(VARIANCE) + size, 1.0F);
}

void PointList::collect(const Source& source,
                        int row,
                        int column,
                        std::vector<Candidate>& candidates) {
  candidates.clear();
  const int v_end = std::min((row + 1) * source.side, source.height - 1);
  const int u_end = std::min((column + 1) * source.side, source.width - 1);
  for (int v = std::max(row * source.side, 1); v < v_end; ++v) {
    if (v % source.spacing != 0) continue;
    for (int u = source.first_u(column); u < u_end; u += source.spacing) {
      if (!source.is_candidate(u, v)) continue;
      // a positive float's bits are in its order
      const float score = source.score(u, v);
      std::uint32_t bits = 0;
      std::memcpy(&bits, &score, sizeof(bits));
      const auto pixel = static_cast<std::uint32_t>(v * source.width + u);
      candidates.push_back(Candidate{bits} << 32U | (~pixel & 0xffffffffU));
    }
  }
}

void PointList::fill(const Source& source,
                     std::int64_t i,
                     const std::vector<Candidate>& candidates) {
  for (const Candidate candidate : candidates) {
    const auto pixel = static_cast<int>(pixel_of(candidate));
    const int u = pixel % source.width;
    const int v = pixel / source.width;
    const GradientCell& cell = source.cells.at(u, v);
    pixels_[static_cast<std::size_t>(i)] = pixel;
    array(RAY_X)[i] = static_cast<float>((u - source.camera.cx()) / source.camera.fx());
    array(RAY_Y)[i] = static_cast<float>((v - source.camera.cy()) / source.camera.fy());
    array(INVERSE_DEPTH)[i] = source.D.at(u, v);
    array(VARIANCE)[i] = source.V.at(u, v);
    array(INTENSITY)[i] = cell.value;
    array(GRADIENT_U)[i] = cell.du;
    array(GRADIENT_V)[i] = cell.dv;
    mean_inverse_depth_ += static_cast<double>(source.D.at(u, v));
    ++i;
  }
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
