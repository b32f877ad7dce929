// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/patch_reader.h"

#include <algorithm>
#include <cmath>

namespace raylign::photometric {
namespace {

bool read_patch(const Setting& setting,
                std::int64_t p,
                int level,
                int read_level,
                float* patch,
                std::uint32_t& mask) {
  const std::int32_t host = setting.hosts.image[p];
  if (!setting.hosts.uv.row(p).allFinite()) return false;
  const PatchPlane& plane = setting.prepared.images[host]->plane(read_level);
  const double scale = std::ldexp(1.0, -read_level);
  const double spacing = std::ldexp(1.0, level - read_level);
  const auto& offsets = setting.options.pattern.offsets;
  mask = 0;
  for (std::size_t n = 0; n < offsets.size(); ++n) {
    const double u = (setting.hosts.uv(p, 0) + 0.5) * scale - 0.5 + spacing * offsets[n][0];
    const double v = (setting.hosts.uv(p, 1) + 0.5) * scale - 0.5 + spacing * offsets[n][1];
    if (!plane.contains(u, v)) return false;
    patch[n] =
        static_cast<float>(sample_patch_plane(plane, setting.options.interpolation, u, v).value);
    if (setting.prepared.masks[host].counts(read_level, u, v)) mask |= 1u << n;
  }
  return true;
}

}  // namespace

PatchSources read_patches(const Setting& setting,
                          int level,
                          const std::vector<int>& levels,
                          std::vector<float>& patches) {
  const std::int64_t N = setting.num_points();
  const int n = setting.options.pattern.size();
  PatchSources sources;
  sources.is_read.assign(N, 1);
  sources.mask.assign(N, ~0u);
  patches.assign(static_cast<std::size_t>(N) * n, 0.0f);
  for_each_point(setting.pool, N, [&](std::int64_t p) {
    float* patch = patches.data() + p * n;
    if (setting.hosts.image[p] >= 0) {
      sources.is_read[p] = read_patch(setting, p, level, levels[p], patch, sources.mask[p]);
    } else if (setting.problem.has_patches()) {
      std::copy_n(setting.problem.patches.row(p).data(), n, patch);
    } else {
      sources.is_read[p] = 0;
    }
  });
  return sources;
}

}  // namespace raylign::photometric
