// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/hosts.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

namespace raylign::photometric {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

// All images, or the images of each point's tracks, sorted, each once.
std::vector<std::vector<std::int32_t>> images_of_points(const PhotometricProblem& problem) {
  std::vector<std::vector<std::int32_t>> images(problem.num_points());
  if (problem.track_point.rows() == 0) {
    std::vector<std::int32_t> all(problem.num_images());
    for (std::size_t i = 0; i < all.size(); ++i) all[i] = static_cast<std::int32_t>(i);
    std::fill(images.begin(), images.end(), all);
    return images;
  }
  for (Eigen::Index k = 0; k < problem.track_point.rows(); ++k) {
    images[problem.track_point[k]].push_back(problem.track_image[k]);
  }
  for (auto& list : images) {
    std::sort(list.begin(), list.end());
    list.erase(std::unique(list.begin(), list.end()), list.end());
  }
  return images;
}

Vector3 viewing_direction(const PhotometricState& state, std::int32_t image, const Vector3& X) {
  const PatchPose& pose = state.poses[image];
  return (X + pose.q.conjugate() * pose.t).normalized();
}

class HostChoice {
 public:
  HostChoice(const PhotometricOptions& options,
             const PreparedImages& prepared,
             const PhotometricState& start)
      : options_(options), prepared_(prepared), start_(start) {}

  std::int32_t best(const Vector3& X, const std::vector<std::int32_t>& images) const {
    Vector3 middle = Vector3::Zero();
    for (const std::int32_t j : images) {
      if (contrast(X, j) >= 0.0) middle += viewing_direction(start_, j, X);
    }
    std::int32_t best = -1;
    double highest = -1.0;
    for (const std::int32_t j : images) {
      const double seen = contrast(X, j);
      if (seen < 0.0) continue;
      const double frontal = viewing_direction(start_, j, X).dot(middle.normalized());
      const double score = seen * std::max(frontal, 0.0);
      if (score <= highest) continue;
      highest = score;
      best = j;
    }
    return best;
  }

 private:
  double contrast(const Vector3& X, std::int32_t j) const {
    Vector2 uv;
    if (!start_.project(j, X, uv)) return -1.0;
    return contrast_at(*prepared_.images[j], options_.interpolation, options_.pattern, uv);
  }

  const PhotometricOptions& options_;
  const PreparedImages& prepared_;
  const PhotometricState& start_;
};

Vector2 host_pixel(const PhotometricProblem& problem,
                   const PhotometricState& start,
                   std::int64_t p,
                   std::int32_t host) {
  if (problem.host_uv.rows() > 0 && problem.host_uv.row(p).allFinite()) {
    return problem.host_uv.row(p);
  }
  Vector2 uv;
  if (start.project(host, problem.points.row(p), uv)) return uv;
  return {kNaN, kNaN};
}

}  // namespace

bool PatchHosts::any() const {
  return std::any_of(image.begin(), image.end(), [](std::int32_t host) { return host >= 0; });
}

double contrast_at(const PatchImage& image,
                   SampleInterpolation interpolation,
                   const PatchPattern& pattern,
                   const Vector2& uv) {
  const PatchPlane& plane = image.plane(0);
  double sum = 0.0;
  double squares = 0.0;
  for (const auto& o : pattern.offsets) {
    const double u = uv.x() + o[0];
    const double v = uv.y() + o[1];
    if (!plane.contains(u, v)) return -1.0;
    const double grey = sample_patch_plane(plane, interpolation, u, v).value;
    sum += grey;
    squares += grey * grey;
  }
  const double n = pattern.size();
  return std::sqrt(std::max(squares / n - sum * sum / (n * n), 0.0));
}

PatchHosts choose_hosts(const PhotometricProblem& problem,
                        const PhotometricOptions& options,
                        const PreparedImages& prepared,
                        const PhotometricState& start) {
  const std::int64_t N = problem.num_points();
  PatchHosts hosts;
  hosts.image.assign(N, -1);
  hosts.uv.setConstant(N, 2, kNaN);
  const bool choose = problem.hosts.rows() == 0 && !problem.has_patches();
  const HostChoice choice(options, prepared, start);
  const auto images = choose ? images_of_points(problem) : std::vector<std::vector<std::int32_t>>();
  for (std::int64_t p = 0; p < N; ++p) {
    if (choose) hosts.image[p] = choice.best(problem.points.row(p), images[p]);
    if (problem.hosts.rows() > 0) hosts.image[p] = problem.hosts[p];
    if (hosts.image[p] >= 0) hosts.uv.row(p) = host_pixel(problem, start, p, hosts.image[p]);
  }
  return hosts;
}

Candidates list_candidates(const PhotometricProblem& problem,
                           const PhotometricOptions& options,
                           const PatchHosts& hosts) {
  auto images = images_of_points(problem);
  const bool without_host = options.point_parametrization == PointParametrization::INVERSE_DEPTH;
  Candidates candidates;
  candidates.starts.push_back(0);
  for (std::int64_t p = 0; p < problem.num_points(); ++p) {
    auto& list = images[p];
    const std::int32_t host = hosts.image[p];
    const auto at = std::lower_bound(list.begin(), list.end(), host);
    const bool is_there = at != list.end() && *at == host;
    if (host >= 0 && !is_there && !without_host) list.insert(at, host);
    if (host >= 0 && is_there && without_host) list.erase(at);
    candidates.image.insert(candidates.image.end(), list.begin(), list.end());
    candidates.starts.push_back(candidates.size());
  }
  return candidates;
}

}  // namespace raylign::photometric
