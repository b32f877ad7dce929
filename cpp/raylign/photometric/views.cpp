// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/views.h"

#include <cmath>

#include "raylign/photometric/judge.h"
#include "raylign/photometric/normals.h"
#include "raylign/photometric/occlusion.h"
#include "raylign/photometric/patch_reader.h"
#include "raylign/photometric/warp.h"

namespace raylign::photometric {
namespace {

constexpr double kOcclusionCell = 4.0;  // px, whatever the level: a slanted wall hides nothing
constexpr double kDegree = 0.017453292519943295;

Vector4 intrinsics_of(const PhotometricState& state, std::int64_t image) {
  return state.intrinsics.row(state.intrinsics_row(image)).transpose();
}

void set_points(const Setting& setting, const PhotometricState& state, PatchScene& scene) {
  scene.points = state.points;
  scene.inverse_depth =
      setting.options.point_parametrization == PointParametrization::INVERSE_DEPTH;
  if (!scene.inverse_depth) return;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    if (scene.hosts[p] < 0) continue;
    scene.points.row(p).setZero();
    scene.points(p, 0) = 1.0 / state.in_camera(scene.hosts[p], state.points.row(p)).z();
  }
}

PatchScene bare_scene(const Setting& setting, const PhotometricState& state) {
  PatchScene scene;
  scene.pattern = setting.options.pattern;
  scene.interpolation = setting.options.interpolation;
  scene.min_depth = setting.options.min_depth;
  scene.images = setting.prepared.images;
  scene.starts = setting.candidates.starts;
  scene.hosts = setting.hosts.image;
  scene.host_uv = setting.hosts.uv;
  scene.poses = state.poses;
  scene.brightness = state.brightness;
  scene.intrinsics = state.intrinsics;
  set_points(setting, state, scene);
  for (const std::int32_t image : setting.candidates.image) scene.edges.push_back({image});
  return scene;
}

// Noise of the images over that of the patches, which is more where they are read from whole
// pixels.
double noise_ratio(const Setting& setting, const std::vector<int>& levels) {
  if (!setting.options.brightness.balanced) return 0.0;
  double of_patches = 0.0;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    if (setting.hosts.image[p] < 0 || !setting.hosts.uv.row(p).allFinite()) {
      of_patches += 1.0;  // a stored patch: taken for pixels
      continue;
    }
    const double scale = std::ldexp(1.0, -levels[p]);
    const Vector2 uv = (setting.hosts.uv.row(p).array() + 0.5) * scale - 0.5;
    of_patches += setting.prepared.noise.value(uv.x(), uv.y());
  }
  return setting.prepared.noise.mean_value() * double(setting.num_points()) / of_patches;
}

// The normal that a patch is warped with; false: it is only shifted.
bool warp_normal(const Setting& setting, const Views& views, std::int64_t p, Vector3& normal) {
  const PatchWarp warp = setting.options.warp;
  if (warp == PatchWarp::NONE || setting.hosts.image[p] < 0) return false;
  normal = views.normals.row(p).transpose();
  const bool is_known = warp != PatchWarp::DEPTH && normal.allFinite();
  if (!is_known) normal = Vector3::UnitZ();
  return true;
}

PlaneWarp warp_to(const Setting& setting,
                  const PhotometricState& state,
                  std::int64_t p,
                  std::int32_t image,
                  const Vector3& normal) {
  const std::int32_t h = setting.hosts.image[p];
  if (h == image) {
    PlaneWarp identity;
    identity.is_valid = true;
    return identity;
  }
  const PatchPose& host = state.poses[h];
  const PatchPose& target = state.poses[image];
  const Quaternion q_jh = target.q * host.q.conjugate();
  return plane_warp(q_jh.toRotationMatrix(), target.t - q_jh * host.t,
                    state.ray(h, setting.hosts.uv.row(p)),
                    state.in_camera(h, state.points.row(p)).z(), normal, intrinsics_of(state, h),
                    intrinsics_of(state, image));
}

int clamp_level(const Setting& setting, int level) {
  return std::clamp(level, 0, setting.prepared.num_levels - 1);
}

// Warp and level of an edge; what the warp alone says against it.
EdgeStatus place_edge(
    const Setting& setting, const PlaneWarp& warp, bool has_normal, int level, PatchEdge& edge) {
  edge.level = level;
  if (!warp.is_valid) return EdgeStatus::OBLIQUE;
  const double scale = warp.scale();
  const int octaves = static_cast<int>(std::lround(std::log2(scale)));
  edge.level = clamp_level(setting, level + std::clamp(octaves, 0, 8));
  const double to_level = std::ldexp(1.0, level - edge.level);
  for (int i = 0; i < 4; ++i) {
    edge.A[i] = static_cast<float>(to_level * warp.A(i / 2, i % 2));
  }
  const VisibilityOptions& limits = setting.options.visibility;
  if (scale > limits.max_scale_change || scale * limits.max_scale_change < 1.0) {
    return EdgeStatus::SCALE_CHANGE;
  }
  const bool is_flat = has_normal && warp.cos_view < std::cos(kDegree * limits.max_view_angle);
  return is_flat ? EdgeStatus::OBLIQUE : EdgeStatus::OK;
}

// Level that the patch is read on in its host: coarser where most images see it smaller.
int host_level(const Setting& setting, std::vector<double>& octaves, int level) {
  if (octaves.empty()) return level;
  const auto middle = octaves.begin() + static_cast<std::ptrdiff_t>(octaves.size() / 2);
  std::nth_element(octaves.begin(), middle, octaves.end());
  return clamp_level(setting, level + std::max(0, static_cast<int>(std::lround(-*middle))));
}

// Places the edges of a point; returns the level to read its patch on.
int place_point(const Setting& setting,
                const PhotometricState& state,
                std::int64_t p,
                int level,
                Views& views) {
  Vector3 normal;
  const bool warped = warp_normal(setting, views, p, normal);
  const bool has_normal = warped && views.normals.row(p).allFinite();
  std::vector<double> octaves;
  for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
    PatchEdge& edge = views.scene.edges[e];
    edge.level = level;
    if (!warped) continue;
    const PlaneWarp warp = warp_to(setting, state, p, edge.image, normal);
    views.edges[e] = place_edge(setting, warp, has_normal, level, edge);
    if (warp.is_valid && !setting.is_host(p, edge.image))
      octaves.push_back(std::log2(warp.scale()));
  }
  return host_level(setting, octaves, level);
}

// Pixels of an edge that count in its image.
std::uint32_t edge_mask(const Setting& setting,
                        const PatchScene& scene,
                        const PatchEdge& edge,
                        const Vector2& uv) {
  const double scale = std::ldexp(1.0, -edge.level);
  std::uint32_t mask = 0;
  for (int n = 0; n < scene.pattern.size(); ++n) {
    const auto& o = scene.pattern.offsets[n];
    const double u = (uv.x() + 0.5) * scale - 0.5 + edge.A[0] * o[0] + edge.A[1] * o[1];
    const double v = (uv.y() + 0.5) * scale - 0.5 + edge.A[2] * o[0] + edge.A[3] * o[1];
    if (setting.prepared.masks[edge.image].counts(edge.level, u, v)) mask |= 1u << n;
  }
  return mask;
}

int num_counted(std::uint32_t mask) { return __builtin_popcount(mask); }

bool in_front(const PatchScene& scene, double z) {
  return std::isinf(scene.min_depth) ? z != 0.0 : z > scene.min_depth;
}

// What the edge's place in the image says, its mask set.
EdgeStatus look_at_edge(const Setting& setting,
                        const PatchScene& scene,
                        std::int64_t p,
                        std::uint32_t patch_mask,
                        PatchEdge& edge) {
  const EdgeSample sample = evaluate_edge(scene, p, edge);
  if (!sample.is_seen) {
    const PatchPose& pose = scene.poses[edge.image];
    const double z = (pose.q * world_point(scene, p) + pose.t).z();
    return in_front(scene, z) ? EdgeStatus::OUT_OF_VIEW : EdgeStatus::BEHIND;
  }
  edge.mask = patch_mask & edge_mask(setting, scene, edge, sample.uv);
  const bool enough = 2 * num_counted(edge.mask) >= scene.pattern.size();
  return enough ? EdgeStatus::OK : EdgeStatus::SATURATED;
}

bool all_candidates(const Setting& setting) {
  return setting.options.visibility.rule == VisibilityRule::ALL;
}

void look_at_edges(const Setting& setting, const PatchSources& sources, Views& views) {
  PatchScene& scene = views.scene;
  for_each_point(setting.pool, setting.num_points(), [&](std::int64_t p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      const EdgeStatus placed = views.edges[e];
      const EdgeStatus seen = sources.is_read[p]
                                  ? look_at_edge(setting, scene, p, sources.mask[p], scene.edges[e])
                                  : EdgeStatus::NOT_USED;
      views.edges[e] = seen == EdgeStatus::OK ? placed : seen;
    }
  });
}

}  // namespace

Views find_views(const Setting& setting, const PhotometricState& state, int level) {
  Views views;
  views.scene = bare_scene(setting, state);
  views.edges.assign(views.scene.edges.size(), EdgeStatus::OK);
  const bool with_normals =
      setting.options.warp == PatchWarp::AUTO || setting.options.warp == PatchWarp::NORMAL;
  views.normals.setConstant(setting.num_points(), 3, std::nan(""));
  if (with_normals) views.normals = fit_normals(state, setting.hosts, setting.problem.normals);
  std::vector<int> levels(setting.num_points(), level);
  for_each_point(setting.pool, setting.num_points(),
                 [&](std::int64_t p) { levels[p] = place_point(setting, state, p, level, views); });
  views.scene.noise_ratio = noise_ratio(setting, levels);
  const PatchSources sources = read_patches(setting, level, levels, views.scene.patches);
  look_at_edges(setting, sources, views);
  if (all_candidates(setting)) {
    std::fill(views.edges.begin(), views.edges.end(), EdgeStatus::OK);
    views.points.assign(setting.num_points(), PointStatus::OK);
    return views;
  }
  if (setting.options.visibility.rule == VisibilityRule::AUTO &&
      setting.options.visibility.occlusion > 0.0) {
    mark_occluded(setting, state, kOcclusionCell, views);
  }
  judge(setting, sources, views);
  return views;
}

PatchScene used_scene(const Views& views, const std::vector<bool>& active) {
  PatchScene used = views.scene;
  used.edges.clear();
  for (std::int64_t p = 0; p < views.scene.num_points(); ++p) {
    for (std::int64_t e = views.scene.starts[p]; active[p] && e < views.scene.starts[p + 1]; ++e) {
      if (views.edges[e] == EdgeStatus::OK) used.edges.push_back(views.scene.edges[e]);
    }
    used.starts[p + 1] = used.num_edges();
  }
  return used;
}

std::vector<float> residuals_of(const Setting& setting,
                                const Views& views,
                                const std::vector<bool>& active) {
  std::vector<float> residuals;
  const PatchScene& scene = views.scene;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; active[p] && e < scene.starts[p + 1]; ++e) {
      const PatchEdge& edge = scene.edges[e];
      if (views.edges[e] != EdgeStatus::OK || setting.is_host(p, edge.image)) continue;
      const EdgeSample sample = evaluate_edge(scene, p, edge);
      for (int n = 0; sample.is_seen && n < scene.pattern.size(); ++n) {
        if (sample.counts(edge, n)) residuals.push_back(static_cast<float>(sample.residual[n]));
      }
    }
  }
  return residuals;
}

}  // namespace raylign::photometric
