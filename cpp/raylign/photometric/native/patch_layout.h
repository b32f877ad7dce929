// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/native/patch_kernels.h"

namespace raylign::native {

/// A PatchScene laid out for the kernels: what does not move during a solve.
class PatchLayout {
 public:
  PatchLayout(const PatchScene& scene, const PatchSolveOptions& options, bool with_intrinsics);

  /// What the kernels walk along; valid while this and the scene's images live.
  const PatchArrays& arrays() const { return arrays_; }
  std::vector<KernelEdge>& edges() { return edges_; }
  std::int64_t num_living_pixels() const;
  std::int64_t num_slots() const { return static_cast<std::int64_t>(slot_images_.size()); }
  bool has_hosts() const { return has_hosts_; }
  /// (N,) the scene's point at each place of the arrays: neighbours in an image follow each other,
  /// so that a pass finds their pixels in the cache.
  const std::vector<std::int64_t>& points() const { return points_; }
  int num_columns() const {
    return arrays_.with_intrinsics ? kImageColumnsWithIntrinsics : kImageColumns;
  }

 private:
  void order_points(const PatchScene& scene);
  void load_pattern(const PatchScene& scene);
  void load_planes(const PatchScene& scene);
  void load_edges(const PatchScene& scene);
  void add_edge(const PatchEdge& from);
  void load_slots(const PatchScene& scene);
  void load_hosts(const PatchScene& scene);
  void point_at_tables();

  PatchArrays arrays_{};
  std::vector<std::int64_t> points_;
  std::vector<int> order_;  // pattern's pixel of each kernel pixel, −1: padding
  std::vector<float> offsets_u_, offsets_v_;
  std::vector<PlaneRef> planes_;
  std::vector<std::int32_t> first_plane_;  // of each image
  std::vector<std::int64_t> starts_;
  std::vector<KernelEdge> edges_;
  std::vector<float> patches_;
  std::vector<std::int32_t> hosts_;
  std::vector<std::uint16_t> host_slots_;
  std::vector<double> host_uv_;
  std::vector<unsigned char> was_out_;  // LeavingRule::ZERO only
  std::vector<std::int64_t> slot_starts_;
  std::vector<std::int32_t> slot_images_;
  bool has_hosts_ = false;
};

}  // namespace raylign::native
