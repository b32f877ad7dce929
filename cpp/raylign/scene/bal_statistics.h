// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/scene/bundle_scene.h"

namespace raylign {

/// Order statistics of a list of counts; all zero for an empty list.
struct CountSummary {
  double min = 0.0;
  double median = 0.0;  ///< Mean of the two middle values when their number is even.
  double mean = 0.0;
  double max = 0.0;
};

/// What a problem looks like before anything is solved.
struct ProblemStatistics {
  std::int64_t num_cameras = 0;
  std::int64_t num_points = 0;
  std::int64_t num_observations = 0;
  CountSummary observations_per_camera;
  CountSummary observations_per_point;
  std::vector<std::int64_t> track_length_histogram;  ///< [k] = number of points seen k times.

  double cost = 0.0;          ///< ½ Σ ‖r‖², px².
  double rmse = 0.0;          ///< √(Σ ‖r‖² / (2 N)), px per coordinate.
  double median_error = 0.0;  ///< Median of ‖r‖, px.
  double max_error = 0.0;     ///< Maximum of ‖r‖, px.

  std::int64_t num_behind_camera = 0;       ///< Observations with depth <= 0.
  std::int64_t num_non_finite = 0;          ///< Observations whose residual is NaN or infinite.
  std::int64_t num_unobserved_cameras = 0;  ///< Cameras without an observation.
  std::int64_t num_unobserved_points = 0;   ///< Points without an observation.
  std::int64_t num_underconstrained_points = 0;   ///< Points with fewer than 2 observations.
  std::int64_t num_underconstrained_cameras = 0;  ///< Cameras with fewer than 3 observations.
  std::int64_t num_duplicate_observations = 0;    ///< Repeats of an earlier (camera, point) pair.
  std::int64_t num_non_positive_focal =
      0;  ///< Cameras with f (fx or fy) <= 0; mirrored data has them.
};

/// Counts, track lengths and reprojection errors.
/// The three error figures leave out the `num_non_finite` observations, so they are always finite.
ProblemStatistics statistics(const BundleScene& scene);

/// Positions i of observations whose (camera, point) pair occurred before, ascending, each with the
/// position of the first occurrence. O(C + P + N) time and memory.
struct DuplicateObservation {
  std::int64_t first;
  std::int64_t repeat;
};
std::vector<DuplicateObservation> duplicate_observations(const BundleScene& scene);

}  // namespace raylign
