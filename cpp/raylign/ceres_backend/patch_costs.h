// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/cost_function.h>

#include <array>
#include <cstdint>

#include "raylign/ceres_backend/patch_edges.h"

namespace raylign::ceres_backend {

/// What a parameter block is to an edge.
enum class PatchSlot : std::uint8_t {
  POSE,
  POINT,
  BRIGHTNESS,
  HOST_BRIGHTNESS,
  INTRINSICS,
  HOST_POSE,
  HOST_INTRINSICS,
};

/// An edge and its blocks, in their order.
struct PatchBlocks {
  std::int64_t point = 0;
  std::int64_t edge = 0;
  int count = 0;
  std::array<PatchSlot, 7> slots{};
};

/// All pixels of an edge as one block, for laws of the patch.
class PatchCost final : public ceres::CostFunction {
 public:
  PatchCost(const PatchEdges& edges, const PatchBlocks& blocks);
  bool Evaluate(double const* const* x, double* residuals, double** J) const override;

 private:
  const PatchEdges& edges_;
  const PatchBlocks blocks_;
};

/// One pixel of an edge, for laws of the pixel: the reference, not made for speed.
class PatchPixelCost final : public ceres::CostFunction {
 public:
  PatchPixelCost(const PatchEdges& edges, const PatchBlocks& blocks, int n);
  bool Evaluate(double const* const* x, double* residual, double** J) const override;

 private:
  const PatchEdges& edges_;
  const PatchBlocks blocks_;
  const int n_;
};

/// Numbers in the block of a slot.
int patch_slot_size(const PatchScene& scene, PatchSlot slot);

}  // namespace raylign::ceres_backend
