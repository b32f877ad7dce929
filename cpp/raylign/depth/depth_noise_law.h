// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign {

/// Standard deviation of a measured inverse depth D (1/m), every DepthNoise in one form:
/// constant + c0 D² + c1 (1 − 0.4 D)². Plain enough for the kernels.
template <typename T>
struct DepthNoiseLaw {
  T constant = T(0);
  T c0 = T(0);
  T c1 = T(0);

  __attribute__((always_inline)) T sigma(T D) const {
    const T beyond = T(1) - T(0.4) * D;
    return constant + c0 * D * D + c1 * beyond * beyond;
  }
};

}  // namespace raylign
