// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Whether there is a patch, and which of its pixels count.
struct PatchSources {
  std::vector<char> is_read;        ///< (N,) 0: the host's patch is not inside its image
  std::vector<std::uint32_t> mask;  ///< (N,) bit n: pixel n counts in the host
};

/// Reads the patches (N, n) from their hosts, around the pixels that the hosts name, pattern spaced
/// in pixels of level `level` and read on level levels[p] >= level; or copies the stored ones.
PatchSources read_patches(const Setting& setting,
                          int level,
                          const std::vector<int>& levels,
                          std::vector<float>& patches);

}  // namespace raylign::photometric
