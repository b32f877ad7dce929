// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/synthetic/bal_options.h"

namespace raylign {

/// Observations of a run of points, in file order: by point, then by camera.
struct SyntheticObservationChunk {
  std::vector<std::int32_t> camera_index;
  std::vector<std::int32_t> point_index;
  std::vector<Vector2> observations;  ///< px, with noise and outliers
  std::vector<std::uint8_t> inlier;   ///< 0: a uniform pixel instead of a measurement
};

/// A run of points.
struct SyntheticPointChunk {
  std::vector<Vector3> truth;        ///< world frame, m
  std::vector<Vector3> start;        ///< perturbed
  std::vector<std::uint8_t> colors;  ///< 3 per point, RGB
};

/// A synthetic BAL problem of any size, in pieces: a few bytes per point are kept (what the first
/// pass found), the rest is drawn again from the seed when asked for. Chunk sizes do not change a
/// bit.
///
/// The constructor plans: it draws every point once to know the exact counts, which a BAL file
/// states first. Throws OptionsError when the options contradict themselves or the scene cannot
/// give what they ask (too many observations wanted; a camera that shares nothing with the others).
class SyntheticBalStream {
 public:
  explicit SyntheticBalStream(const SyntheticBalOptions& options);
  ~SyntheticBalStream();
  SyntheticBalStream(SyntheticBalStream&&) noexcept;
  SyntheticBalStream& operator=(SyntheticBalStream&&) noexcept;

  const SyntheticBalOptions& options() const;
  std::int64_t num_observations() const;

  Rows<double, 9> true_cameras() const;   ///< (C, 9)
  Rows<double, 9> start_cameras() const;  ///< (C, 9) perturbed

  /// Replaces `chunk` by the observations of the next `max_points` points; false when there are
  /// none left.
  bool next_observations(std::int64_t max_points, SyntheticObservationChunk& chunk);
  /// Replaces `chunk` by the next `max_points` points; false when there are none left.
  bool next_points(std::int64_t max_points, SyntheticPointChunk& chunk);

 private:
  struct State;
  std::unique_ptr<State> state_;
};

}  // namespace raylign
