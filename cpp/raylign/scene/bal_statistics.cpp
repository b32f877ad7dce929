// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_statistics.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <utility>

namespace raylign {
namespace {

template <typename T>
double median_of(std::vector<T> values) {
  const std::size_t half = values.size() / 2;
  std::nth_element(values.begin(), values.begin() + half, values.end());
  const double upper = static_cast<double>(values[half]);
  if (values.size() % 2 == 1) return upper;
  return 0.5 *
         (upper + static_cast<double>(*std::max_element(values.begin(), values.begin() + half)));
}

CountSummary summarize(const std::vector<std::int64_t>& counts) {
  CountSummary summary;
  if (counts.empty()) return summary;
  const auto [low, high] = std::minmax_element(counts.begin(), counts.end());
  const std::int64_t total = std::accumulate(counts.begin(), counts.end(), std::int64_t{0});
  summary.min = static_cast<double>(*low);
  summary.max = static_cast<double>(*high);
  summary.mean = static_cast<double>(total) / static_cast<double>(counts.size());
  summary.median = median_of(counts);
  return summary;
}

std::vector<std::int64_t> count_uses(const Rows<std::int32_t, 1>& index, std::int64_t size) {
  std::vector<std::int64_t> counts(size, 0);
  for (Eigen::Index i = 0; i < index.size(); ++i) ++counts[index[i]];
  return counts;
}

std::int64_t count_below(const std::vector<std::int64_t>& counts, std::int64_t limit) {
  return std::count_if(counts.begin(), counts.end(), [limit](std::int64_t n) { return n < limit; });
}

void add_structure(const BundleScene& scene, ProblemStatistics& out) {
  const auto per_camera = count_uses(scene.camera_index, scene.num_cameras());
  const auto per_point = count_uses(scene.point_index, scene.num_points());
  out.observations_per_camera = summarize(per_camera);
  out.observations_per_point = summarize(per_point);
  if (!per_point.empty()) {
    out.track_length_histogram.assign(static_cast<std::size_t>(out.observations_per_point.max) + 1,
                                      0);
    for (const std::int64_t length : per_point) ++out.track_length_histogram[length];
  }
  out.num_unobserved_cameras = count_below(per_camera, 1);
  out.num_unobserved_points = count_below(per_point, 1);
  out.num_underconstrained_cameras = count_below(per_camera, 3);
  out.num_underconstrained_points = count_below(per_point, 2);
  out.num_duplicate_observations = static_cast<std::int64_t>(duplicate_observations(scene).size());
  const int num_focals = scene.camera_model == CameraModel::BAL ? 1 : 2;
  out.num_non_positive_focal =
      (scene.intrinsics.leftCols(num_focals).array() <= 0.0).rowwise().any().count();
}

void add_errors(const BundleScene& scene, ProblemStatistics& out) {
  std::vector<double> errors;
  errors.reserve(scene.num_observations());
  double sum = 0.0;
  out.num_behind_camera = (depths(scene).array() <= 0.0).count();
  const Rows<double, 2> residuals = reprojection_residuals(scene);
  for (Eigen::Index i = 0; i < residuals.rows(); ++i) {
    const double squared = residuals.row(i).squaredNorm();
    if (!std::isfinite(squared)) continue;
    sum += squared;
    errors.push_back(std::sqrt(squared));
  }
  out.num_non_finite = scene.num_observations() - static_cast<std::int64_t>(errors.size());
  out.cost = 0.5 * sum;
  if (errors.empty()) return;
  out.rmse = std::sqrt(sum / (2.0 * static_cast<double>(errors.size())));
  out.max_error = *std::max_element(errors.begin(), errors.end());
  out.median_error = median_of(std::move(errors));
}

// Observation positions grouped by point, in file order inside each group (counting sort).
struct PointMajor {
  std::vector<std::int64_t> begin;  // (P + 1) offsets into order
  std::vector<std::int64_t> order;  // (N,)
};

PointMajor sort_by_point(const BundleScene& scene) {
  PointMajor sorted;
  sorted.begin.assign(scene.num_points() + 1, 0);
  sorted.order.resize(scene.num_observations());
  for (Eigen::Index i = 0; i < scene.point_index.size(); ++i) {
    ++sorted.begin[scene.point_index[i] + 1];
  }
  std::partial_sum(sorted.begin.begin(), sorted.begin.end(), sorted.begin.begin());
  std::vector<std::int64_t> next(sorted.begin.begin(), sorted.begin.end() - 1);
  for (Eigen::Index i = 0; i < scene.point_index.size(); ++i) {
    sorted.order[next[scene.point_index[i]]++] = i;
  }
  return sorted;
}

}  // namespace

ProblemStatistics statistics(const BundleScene& scene) {
  ProblemStatistics out;
  out.num_cameras = scene.num_cameras();
  out.num_points = scene.num_points();
  out.num_observations = scene.num_observations();
  add_errors(scene, out);
  add_structure(scene, out);
  return out;
}

std::vector<DuplicateObservation> duplicate_observations(const BundleScene& scene) {
  const PointMajor sorted = sort_by_point(scene);
  // last_seen[c] = first observation of camera c within the current point; older marks point before
  // the group and are recognised by their point.
  std::vector<std::int64_t> last_seen(scene.num_cameras(), -1);
  std::vector<DuplicateObservation> duplicates;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t k = sorted.begin[p]; k < sorted.begin[p + 1]; ++k) {
      const std::int64_t i = sorted.order[k];
      std::int64_t& first = last_seen[scene.camera_index[i]];
      if (first >= 0 && scene.point_index[first] == p) {
        duplicates.push_back({first, i});
      } else {
        first = i;
      }
    }
  }
  std::sort(duplicates.begin(), duplicates.end(),
            [](const auto& a, const auto& b) { return a.repeat < b.repeat; });
  return duplicates;
}

}  // namespace raylign
