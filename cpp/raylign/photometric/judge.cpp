// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/judge.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace raylign::photometric {
namespace {

// Of a view that shows something else: median |r| in σ (0.67 where the patch is shown), and the
// share of the contrast that is left (0.02 on rendered rooms at σ = 2).
constexpr double kDivergedResidual = 1.5;
constexpr double kDivergedShare = 0.06;

double contrast_of(const float* patch, int n) {
  double sum = 0.0;
  double squares = 0.0;
  for (int i = 0; i < n; ++i) {
    sum += patch[i];
    squares += double(patch[i]) * patch[i];
  }
  return std::sqrt(std::max(squares / n - sum * sum / (double(n) * n), 0.0));
}

void mark_mismatches(const Setting& setting, Views& views) {
  const VisibilityOptions& limits = setting.options.visibility;
  NoiseLawOptions noise;
  noise.sensor_sigma = setting.options.noise.sensor_sigma;
  const std::vector<bool> all(setting.num_points(), true);
  const double sigma = fit_noise_law(residuals_of(setting, views, all), noise).sigma;
  const PatchScene& scene = views.scene;
  for_each_point(setting.pool, setting.num_points(), [&](std::int64_t p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      if (views.edges[e] != EdgeStatus::OK || setting.is_host(p, scene.edges[e].image)) continue;
      const Match match = match_of(scene, p, scene.edges[e]);
      const bool matches =
          match.median_residual < limits.max_residual * sigma || match.zncc > limits.min_zncc;
      if (!matches) views.edges[e] = EdgeStatus::MISMATCH;
    }
  });
}

// What the edges of a point say about it; `counts` by status, without the host's edge.
PointStatus status_of(const std::array<int, 9>& counts, int min_other_views) {
  const auto count = [&](EdgeStatus status) { return counts[static_cast<std::size_t>(status)]; };
  const int ok = count(EdgeStatus::OK);
  const int mismatch = count(EdgeStatus::MISMATCH);
  if (mismatch > ok) return PointStatus::DIVERGED;
  if (ok >= min_other_views) return PointStatus::OK;
  const int occluded = count(EdgeStatus::OCCLUDED);
  const int saturated = count(EdgeStatus::SATURATED);
  if (occluded > ok && occluded >= saturated) return PointStatus::OCCLUDED;
  if (saturated > ok) return PointStatus::SATURATED;
  return ok + occluded + saturated + mismatch == 0 ? PointStatus::OUT_OF_VIEW
                                                   : PointStatus::FEW_VIEWS;
}

PointStatus status_of_point(const Setting& setting,
                            const PatchSources& sources,
                            const Views& views,
                            std::int64_t p) {
  const PatchScene& scene = views.scene;
  const int n = scene.pattern.size();
  if (!sources.is_read[p]) return PointStatus::OUT_OF_VIEW;
  if (2 * __builtin_popcount(sources.mask[p] & ((n < 32 ? 1u << n : 0u) - 1u)) < n) {
    return PointStatus::SATURATED;
  }
  if (contrast_of(scene.patch(p), n) < setting.options.visibility.min_texture) {
    return PointStatus::LOW_TEXTURE;
  }
  std::array<int, 9> counts{};
  for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
    if (setting.is_host(p, scene.edges[e].image)) continue;
    ++counts[static_cast<std::size_t>(views.edges[e])];
  }
  const int own = setting.hosts.image[p] >= 0 ? 1 : 0;
  return status_of(counts, std::max(setting.options.visibility.min_views - own, 1));
}

}  // namespace

Match match_of(const PatchScene& scene, std::int64_t p, const PatchEdge& edge) {
  const EdgeSample sample = evaluate_edge(scene, p, edge);
  std::array<double, PatchPattern::kMaxPixels> absolute;
  double c = 0.0, v = 0.0, cc = 0.0, vv = 0.0, cv = 0.0, rr = 0.0;
  int count = 0;
  for (int n = 0; n < scene.pattern.size(); ++n) {
    if (!sample.counts(edge, n)) continue;
    const double x = scene.patch(p)[n];
    const double y = sample.value[n];
    absolute[count++] = std::abs(sample.residual[n]);
    c += x;
    v += y;
    cc += x * x;
    vv += y * y;
    cv += x * y;
    rr += sample.residual[n] * sample.residual[n];
  }
  Match match;
  if (count == 0) return match;
  std::nth_element(absolute.begin(), absolute.begin() + count / 2, absolute.begin() + count);
  match.median_residual = absolute[count / 2];
  const double contrast = cc - c * c / count;
  if (contrast > 0.0) match.unexplained = rr / contrast;
  const double spread = contrast * (vv - v * v / count);
  if (spread > 0.0) match.zncc = (cv - c * v / count) / std::sqrt(spread);
  return match;
}

void judge(const Setting& setting, const PatchSources& sources, Views& views) {
  if (setting.options.visibility.rule == VisibilityRule::AUTO) mark_mismatches(setting, views);
  views.points.resize(setting.num_points());
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    views.points[p] = status_of_point(setting, sources, views, p);
    if (views.points[p] == PointStatus::OK) continue;
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      if (views.edges[e] == EdgeStatus::OK) views.edges[e] = EdgeStatus::NOT_USED;
    }
  }
}

void mark_diverged(const Setting& setting, double sigma, Views& views) {
  const PatchScene& scene = views.scene;
  for_each_point(setting.pool, setting.num_points(), [&](std::int64_t p) {
    if (views.points[p] != PointStatus::OK) return;
    int num_ok = 0;
    int num_other = 0;
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      if (views.edges[e] != EdgeStatus::OK || setting.is_host(p, scene.edges[e].image)) continue;
      const Match match = match_of(scene, p, scene.edges[e]);
      ++num_ok;
      if (match.median_residual > kDivergedResidual * sigma && match.unexplained > kDivergedShare) {
        ++num_other;
      }
    }
    if (2 * num_other <= num_ok) return;
    views.points[p] = PointStatus::DIVERGED;
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      if (views.edges[e] == EdgeStatus::OK) views.edges[e] = EdgeStatus::NOT_USED;
    }
  });
}

}  // namespace raylign::photometric
