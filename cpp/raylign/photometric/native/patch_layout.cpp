// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_layout.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <tuple>

#include "raylign/base/error.h"

namespace raylign::native {
namespace {

Reader reader_of(const PatchScene& scene) {
  const bool is_square = scene.pattern.is_square4();
  switch (scene.interpolation) {
    case SampleInterpolation::CUBIC_BSPLINE:
      return is_square ? Reader::SQUARE_BSPLINE : Reader::BSPLINE;
    case SampleInterpolation::BILINEAR:
      return is_square ? Reader::SQUARE_BILINEAR : Reader::BILINEAR;
    case SampleInterpolation::CENTRAL_DIFFERENCE:
      break;
  }
  return Reader::CENTRAL_DIFFERENCE;
}

void set_law(const PatchSolveOptions& options, PatchArrays& arrays) {
  const Loss& loss = options.loss;
  arrays.per_patch = options.scope == LossScope::PATCH;
  arrays.law_scale = loss.scale;
  switch (loss.type) {
    case LossType::TRIVIAL:
      arrays.law = Law::TRIVIAL;
      return;
    case LossType::HUBER:
      arrays.law = Law::HUBER;
      return;
    case LossType::CAUCHY:
      arrays.law = Law::LOG;
      arrays.law_scale = loss.scale * loss.scale;
      return;
    case LossType::STUDENT_T:
      arrays.law = Law::LOG;
      arrays.law_scale = loss.degrees_of_freedom * loss.scale * loss.scale;
      return;
    default:
      throw OptionsError(
          "PatchSolveOptions.loss must be trivial, huber, cauchy or student_t, got " +
          to_string(loss.type));
  }
}

}  // namespace

PatchLayout::PatchLayout(const PatchScene& scene,
                         const PatchSolveOptions& options,
                         bool with_intrinsics) {
  arrays_.reader = reader_of(scene);
  arrays_.min_depth = scene.min_depth;
  arrays_.noise_ratio = scene.noise_ratio;
  arrays_.inverse_depth = scene.inverse_depth;
  arrays_.with_intrinsics = with_intrinsics;
  set_law(options, arrays_);
  order_points(scene);
  load_pattern(scene);
  load_planes(scene);
  load_hosts(scene);
  load_edges(scene);
  load_slots(scene);
  if (options.leaving == LeavingRule::ZERO) was_out_.assign(edges_.size(), 0);
  point_at_tables();
}

std::int64_t PatchLayout::num_living_pixels() const {
  std::int64_t count = 0;
  for (const KernelEdge& edge : edges_) {
    if (edge.is_alive) count += __builtin_popcount(edge.mask);
  }
  return count;
}

// By host, or first image, and there by rows of tiles.
void PatchLayout::order_points(const PatchScene& scene) {
  constexpr double kTile = 16.0;  // px
  using Key = std::tuple<std::int32_t, std::int64_t, double>;
  std::vector<Key> keys;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    std::int32_t image = scene.hosts[p];
    Vector2 uv = scene.host_uv.row(p).transpose();
    if (image < 0 && scene.starts[p] < scene.starts[p + 1]) {
      image = scene.edges[scene.starts[p]].image;
      const PatchPose& pose = scene.poses[image];
      const auto K = scene.intrinsics.row(scene.intrinsics_row(image));
      const Vector3 q = pose.q * scene.points.row(p).transpose() + pose.t;
      uv = {K[0] * q.x() / q.z() + K[2], K[1] * q.y() / q.z() + K[3]};
    }
    const bool is_place = std::abs(uv.x()) < 1e6 && std::abs(uv.y()) < 1e6;  // false for NaN
    if (!is_place) uv.setZero();
    keys.emplace_back(image, static_cast<std::int64_t>(uv.y() / kTile), uv.x());
    points_.push_back(p);
  }
  std::stable_sort(points_.begin(), points_.end(),
                   [&](std::int64_t a, std::int64_t b) { return keys[a] < keys[b]; });
}

// The square readers go along rows, the pattern along columns; the rest keeps its order.
void PatchLayout::load_pattern(const PatchScene& scene) {
  const int n = scene.pattern.size();
  arrays_.num_pixels = n;
  arrays_.padded_pixels = (n + 3) / 4 * 4;
  const bool is_square = scene.pattern.is_square4();
  for (int k = 0; k < arrays_.padded_pixels; ++k) {
    const int pixel = is_square ? 4 * (k % 4) + k / 4 : k;
    order_.push_back(pixel < n ? pixel : -1);
    const auto& offset = scene.pattern.offsets[pixel < n ? pixel : 0];
    offsets_u_.push_back(static_cast<float>(offset[0]));
    offsets_v_.push_back(static_cast<float>(offset[1]));
  }
  patches_.assign(static_cast<std::size_t>(scene.num_points()) * arrays_.padded_pixels, 0.0f);
  float* out = patches_.data();
  for (const std::int64_t p : points_) {
    for (int k = 0; k < arrays_.padded_pixels; ++k) {
      if (order_[k] >= 0) out[k] = scene.patch(p)[order_[k]];
    }
    out += arrays_.padded_pixels;
  }
}

void PatchLayout::load_planes(const PatchScene& scene) {
  for (const auto& image : scene.images) {
    first_plane_.push_back(static_cast<std::int32_t>(planes_.size()));
    for (int level = 0; level < image->num_levels(); ++level) {
      const PatchPlane& plane = image->plane(level);
      planes_.push_back({plane.origin, plane.stride, plane.max_u, plane.max_v});
    }
  }
}

void PatchLayout::load_hosts(const PatchScene& scene) {
  for (const std::int64_t p : points_) {
    hosts_.push_back(scene.hosts[p]);
    host_uv_.push_back(scene.host_uv(p, 0));
    host_uv_.push_back(scene.host_uv(p, 1));
    has_hosts_ |= scene.hosts[p] >= 0;
  }
}

void PatchLayout::load_edges(const PatchScene& scene) {
  edges_.reserve(scene.edges.size());
  starts_.push_back(0);
  for (const std::int64_t p : points_) {
    for (auto e = scene.starts[p]; e < scene.starts[p + 1]; ++e) add_edge(scene.edges[e]);
    starts_.push_back(static_cast<std::int64_t>(edges_.size()));
  }
}

void PatchLayout::add_edge(const PatchEdge& from) {
  KernelEdge edge{};
  edge.image = from.image;
  edge.plane = first_plane_[from.image] + from.level;
  edge.level = static_cast<std::int16_t>(from.level);
  for (int k = 0; k < arrays_.padded_pixels; ++k) {
    const bool counts = order_[k] >= 0 && (from.mask >> order_[k] & 1u) != 0u;
    edge.mask |= static_cast<std::uint32_t>(counts) << k;
  }
  std::copy(from.A.begin(), from.A.end(), edge.A);
  edge.has_warp = from.A != std::array<float, 4>{1.0f, 0.0f, 0.0f, 1.0f};
  edge.is_alive = true;
  edges_.push_back(edge);
}

void PatchLayout::load_slots(const PatchScene& scene) {
  host_slots_.assign(hosts_.size(), 0);
  slot_starts_.push_back(0);
  std::vector<std::int32_t> images;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    images.clear();
    if (hosts_[p] >= 0) images.push_back(hosts_[p]);
    for (auto e = starts_[p]; e < starts_[p + 1]; ++e) images.push_back(edges_[e].image);
    std::sort(images.begin(), images.end());
    images.erase(std::unique(images.begin(), images.end()), images.end());
    const auto slot_of = [&](std::int32_t image) {
      const auto at = std::lower_bound(images.begin(), images.end(), image);
      return static_cast<std::uint16_t>(at - images.begin());
    };
    if (images.size() > std::numeric_limits<std::uint16_t>::max()) {
      throw ShapeError("a point may be seen by at most 65535 images");
    }
    for (auto e = starts_[p]; e < starts_[p + 1]; ++e) edges_[e].slot = slot_of(edges_[e].image);
    if (hosts_[p] >= 0) host_slots_[p] = slot_of(hosts_[p]);
    slot_images_.insert(slot_images_.end(), images.begin(), images.end());
    slot_starts_.push_back(static_cast<std::int64_t>(slot_images_.size()));
  }
}

void PatchLayout::point_at_tables() {
  arrays_.offsets_u = offsets_u_.data();
  arrays_.offsets_v = offsets_v_.data();
  arrays_.planes = planes_.data();
  arrays_.starts = starts_.data();
  arrays_.edges = edges_.data();
  arrays_.patches = patches_.data();
  arrays_.hosts = hosts_.data();
  arrays_.host_slots = host_slots_.data();
  arrays_.host_uv = host_uv_.data();
  arrays_.was_out = was_out_.empty() ? nullptr : was_out_.data();
  arrays_.slot_starts = slot_starts_.data();
  arrays_.slot_images = slot_images_.data();
}

}  // namespace raylign::native
