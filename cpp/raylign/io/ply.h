// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

#include "raylign/io/byte_sink.h"
#include "raylign/scene/bal_problem.h"

namespace raylign {

using Rgb = std::array<std::uint8_t, 3>;

struct PlyOptions {
  bool cameras = true;  ///< Draw the cameras as frusta.
  double camera_scale =
      0.0;  ///< Depth of a frustum, scene units, >= 0; 0 = 5 % of the scene's extent.
  Rgb camera_color = {230, 60, 30};
  Rgb point_color = {150, 150, 150};  ///< For problems without colours.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// What went into a PLY file and what had no finite coordinates (as 32-bit floats) and was left
/// out.
struct PlySummary {
  std::int64_t num_points = 0;
  std::int64_t num_cameras = 0;
  std::int64_t num_skipped_points = 0;
  std::int64_t num_skipped_cameras = 0;
};

/// Writes a binary little-endian PLY: one vertex per point, then six per camera (centre, four image
/// corners, a tip above the image's upper edge), and seven triangles per camera. The frustum opens
/// along the camera's −z and is as wide as its observations reach; +v, up in BAL images, points to
/// the tip. Atomic as write_bal. Throws OptionsError, ShapeError, FormatError (target cannot be
/// written).
PlySummary write_ply(const BalProblem& problem,
                     const std::string& path,
                     const PlyOptions& options = {});
PlySummary write_ply(const BalProblem& problem, ByteSink& sink, const PlyOptions& options = {});

}  // namespace raylign
