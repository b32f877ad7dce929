// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/landmark_kernels.h"

#include <cmath>
#include <limits>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/landmark_group.h"

namespace raylign::native {
namespace {

constexpr int kDiagonal[3] = {0, 3, 5};  // of LandmarkBlock::H

RAYLIGN_INLINE void held_lanes(const Group& group, const std::array<bool, 3>* held, M4* masks) {
  for (int k = 0; k < 3; ++k) masks[k] = M4{};
  if (held == nullptr) return;
  for (int lane = 0; lane < 4; ++lane) {
    const bool* mask = held[group.landmark[lane]].data();
    for (int k = 0; k < 3; ++k) masks[k][lane] = mask[k] ? -1 : 0;
  }
}

// lm_damping.
RAYLIGN_INLINE void add_damping(const LandmarkDamping& damping, const D4& scale, D4& h) {
  const D4 zero = {};
  const D4 s2 = scale * scale;
  D4 clamped = s2 * h;
  clamped = clamped < damping.min_diagonal ? zero + damping.min_diagonal : clamped;
  clamped = clamped > damping.max_diagonal ? zero + damping.max_diagonal : clamped;
  h += damping.lambda * (clamped / s2);
}

// Of records that lie as the landmarks do; no tracks.
RAYLIGN_INLINE Group records_at(std::int64_t begin, std::int64_t end) {
  Group group = {};
  group.count = end - begin < 4 ? static_cast<int>(end - begin) : 4;
  for (int lane = 0; lane < 4; ++lane) {
    group.landmark[lane] = lane < group.count ? begin + lane : begin + group.count - 1;
  }
  return group;
}

}  // namespace

RAYLIGN_CLONES void factor_landmarks(const LandmarkBlock* blocks,
                                     const LandmarkDamping& damping,
                                     std::int64_t begin,
                                     std::int64_t end,
                                     LandmarkFactor* factors) {
  for (std::int64_t j = begin; j < end; j += 4) {
    const Group group = records_at(j, end);
    D4 H[6];
    gather_records<6>(group, blocks, H);
    D4 scales[3];
    gather_points(XyzPoint{}, group, damping.scales, scales);
    M4 held[3];
    held_lanes(group, damping.held, held);
    D4 diagonal[3];
    for (int k = 0; k < 3; ++k) {
      diagonal[k] = H[kDiagonal[k]];
      add_damping(damping, scales[k], diagonal[k]);
    }
    D4 W[6];
    factor_block(H, diagonal, held, W);
    scatter_records<6>(group, W, factors);
  }
}

RAYLIGN_CLONES double largest_gradient(const LandmarkBlock* blocks,
                                       const std::array<bool, 3>* held,
                                       std::int64_t begin,
                                       std::int64_t end) {
  const D4 zero = {};
  D4 largest = {};
  D4 spoilt = {};  // NaN once something is not finite
  for (std::int64_t j = begin; j < end; j += 4) {
    const Group group = records_at(j, end);
    D4 block[9];
    gather_records<9>(group, blocks, block);
    M4 masks[3];
    held_lanes(group, held, masks);
    for (int k = 0; k < 3; ++k) {
      const D4 g = masks[k] ? zero : magnitude(block[6 + k]);
      spoilt += g - g;
      largest = g > largest ? g : largest;
    }
  }
  if (sum_of(spoilt) != 0.0) return std::numeric_limits<double>::quiet_NaN();
  double result = 0.0;
  for (int lane = 0; lane < 4; ++lane) result = largest[lane] > result ? largest[lane] : result;
  return result;
}

}  // namespace raylign::native
