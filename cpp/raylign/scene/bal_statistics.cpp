// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/scene/bal_statistics.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "raylign/camera/bal.h"
#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

// Calls visit(i, residual, depth) for each observation; the rotation of a camera is computed once.
template <typename Visitor>
void for_each_observation(const BalProblem& problem, Visitor visit) {
  problem.validate();
  std::vector<Matrix3> R_cw(problem.num_cameras());
  for (std::int64_t c = 0; c < problem.num_cameras(); ++c) {
    R_cw[c] = so3_exp(problem.cameras.row(c).head<3>().transpose());
  }
  for (std::int64_t i = 0; i < problem.num_observations(); ++i) {
    const std::int32_t c = problem.camera_index[i];
    const auto camera = problem.cameras.row(c);
    const Vector3 t_cw = camera.segment<3>(3).transpose();
    const Vector3 p_c = R_cw[c] * problem.points.row(problem.point_index[i]).transpose() + t_cw;
    Vector2 predicted;
    if (!BalCamera(camera[6], camera[7], camera[8]).project(p_c, predicted)) {
      predicted.setConstant(std::numeric_limits<double>::quiet_NaN());
    }
    visit(i, Vector2(predicted - problem.observations.row(i).transpose()), -p_c.z());
  }
}

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

void add_structure(const BalProblem& problem, ProblemStatistics& out) {
  const auto per_camera = count_uses(problem.camera_index, problem.num_cameras());
  const auto per_point = count_uses(problem.point_index, problem.num_points());
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
  out.num_duplicate_observations =
      static_cast<std::int64_t>(duplicate_observations(problem).size());
  out.num_non_positive_focal = (problem.cameras.col(6).array() <= 0.0).count();
}

void add_errors(const BalProblem& problem, ProblemStatistics& out) {
  std::vector<double> errors;
  errors.reserve(problem.num_observations());
  double sum = 0.0;
  for_each_observation(problem, [&](std::int64_t, const Vector2& residual, double depth) {
    if (depth <= 0.0) ++out.num_behind_camera;
    const double squared = residual.squaredNorm();
    if (!std::isfinite(squared)) return;
    sum += squared;
    errors.push_back(std::sqrt(squared));
  });
  out.num_non_finite = problem.num_observations() - static_cast<std::int64_t>(errors.size());
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

PointMajor sort_by_point(const BalProblem& problem) {
  PointMajor sorted;
  sorted.begin.assign(problem.num_points() + 1, 0);
  sorted.order.resize(problem.num_observations());
  for (Eigen::Index i = 0; i < problem.point_index.size(); ++i) {
    ++sorted.begin[problem.point_index[i] + 1];
  }
  std::partial_sum(sorted.begin.begin(), sorted.begin.end(), sorted.begin.begin());
  std::vector<std::int64_t> next(sorted.begin.begin(), sorted.begin.end() - 1);
  for (Eigen::Index i = 0; i < problem.point_index.size(); ++i) {
    sorted.order[next[problem.point_index[i]]++] = i;
  }
  return sorted;
}

}  // namespace

Rows<double, 2> reprojection_residuals(const BalProblem& problem) {
  Rows<double, 2> residuals(problem.num_observations(), 2);
  for_each_observation(problem, [&](std::int64_t i, const Vector2& residual, double) {
    residuals.row(i) = residual.transpose();
  });
  return residuals;
}

Rows<double, 1> depths(const BalProblem& problem) {
  Rows<double, 1> result(problem.num_observations());
  for_each_observation(problem,
                       [&](std::int64_t i, const Vector2&, double depth) { result[i] = depth; });
  return result;
}

double reprojection_cost(const BalProblem& problem) {
  double sum = 0.0;
  for_each_observation(problem, [&](std::int64_t, const Vector2& residual, double) {
    sum += residual.squaredNorm();
  });
  return 0.5 * sum;
}

ProblemStatistics statistics(const BalProblem& problem) {
  ProblemStatistics out;
  out.num_cameras = problem.num_cameras();
  out.num_points = problem.num_points();
  out.num_observations = problem.num_observations();
  add_errors(problem, out);  // validates the indices first
  add_structure(problem, out);
  return out;
}

std::vector<DuplicateObservation> duplicate_observations(const BalProblem& problem) {
  problem.validate();
  const PointMajor sorted = sort_by_point(problem);
  // last_seen[c] = first observation of camera c within the current point; older marks point before
  // the group and are recognised by their point.
  std::vector<std::int64_t> last_seen(problem.num_cameras(), -1);
  std::vector<DuplicateObservation> duplicates;
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    for (std::int64_t k = sorted.begin[p]; k < sorted.begin[p + 1]; ++k) {
      const std::int64_t i = sorted.order[k];
      std::int64_t& first = last_seen[problem.camera_index[i]];
      if (first >= 0 && problem.point_index[first] == p) {
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
