// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_layout.h"

#include <algorithm>
#include <limits>

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
  arrays_.inverse_depth = scene.inverse_depth;
  arrays_.with_intrinsics = with_intrinsics;
  set_law(options, arrays_);
  load_pattern(scene);
  load_planes(scene);
  load_hosts(scene);
  load_edges(scene);
  load_slots(scene);
  if (options.leaving == LeavingRule::ZERO) was_out_.assign(edges_.size(), 0);
  point_at_tables();
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
  for (std::int64_t p = 0; p < scene.num_points(); ++p, out += arrays_.padded_pixels) {
    for (int k = 0; k < arrays_.padded_pixels; ++k) {
      if (order_[k] >= 0) out[k] = scene.patch(p)[order_[k]];
    }
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
  hosts_ = scene.hosts;
  has_hosts_ = std::any_of(hosts_.begin(), hosts_.end(), [](std::int32_t h) { return h >= 0; });
  host_uv_.assign(scene.host_uv.data(), scene.host_uv.data() + scene.host_uv.size());
}

void PatchLayout::load_edges(const PatchScene& scene) {
  starts_ = scene.starts;
  edges_.reserve(scene.edges.size());
  for (const PatchEdge& from : scene.edges) {
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
