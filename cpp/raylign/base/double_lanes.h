// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "raylign/base/clones.h"

/// Four doubles at once, for the loops that the compiler, left to itself, transposes or leaves
/// scalar. For the files of the kernels alone (base/clones.h). Formulas that are templates of their
/// number take double as well as D4: `mask ? a : b` chooses lane by lane.
namespace raylign::native {

using D4 = double __attribute__((vector_size(32)));
using M4 = std::int64_t __attribute__((vector_size(32)));  // −1 or 0: what comparing D4 gives

RAYLIGN_INLINE void load(const double* p, D4& v) { __builtin_memcpy(&v, p, sizeof(v)); }
RAYLIGN_INLINE void store(const D4& v, double* p) { __builtin_memcpy(p, &v, sizeof(v)); }

// Vectors at any address that a double may have; in structs, because a template argument drops the
// attributes.
struct Four {
  typedef double Vector __attribute__((vector_size(32), may_alias, aligned(8)));
};
struct Eight {
  typedef double Vector __attribute__((vector_size(64), may_alias, aligned(8)));
};

template <typename Width>
RAYLIGN_INLINE typename Width::Vector& at(double* values) {
  return *reinterpret_cast<typename Width::Vector*>(values);
}
template <typename Width>
RAYLIGN_INLINE const typename Width::Vector& at(const double* values) {
  return *reinterpret_cast<const typename Width::Vector*>(values);
}

RAYLIGN_INLINE bool any(const M4& mask) { return (mask[0] | mask[1] | mask[2] | mask[3]) != 0; }
RAYLIGN_INLINE bool any(bool mask) { return mask; }

RAYLIGN_INLINE void square_root(double x, double& root) { root = std::sqrt(x); }
RAYLIGN_INLINE void square_root(const D4& x, D4& root) {
  for (int lane = 0; lane < 4; ++lane) root[lane] = std::sqrt(x[lane]);
}

RAYLIGN_INLINE double sum_of(const D4& v) { return (v[0] + v[1]) + (v[2] + v[3]); }

// Four vectors of four: rows become columns.
RAYLIGN_INLINE void transpose(D4& a, D4& b, D4& c, D4& d) {
  const D4 ab_even = __builtin_shufflevector(a, b, 0, 4, 2, 6);
  const D4 ab_odd = __builtin_shufflevector(a, b, 1, 5, 3, 7);
  const D4 cd_even = __builtin_shufflevector(c, d, 0, 4, 2, 6);
  const D4 cd_odd = __builtin_shufflevector(c, d, 1, 5, 3, 7);
  a = __builtin_shufflevector(ab_even, cd_even, 0, 1, 4, 5);
  b = __builtin_shufflevector(ab_odd, cd_odd, 0, 1, 4, 5);
  c = __builtin_shufflevector(ab_even, cd_even, 2, 3, 6, 7);
  d = __builtin_shufflevector(ab_odd, cd_odd, 2, 3, 6, 7);
}

// Lane l of out[k] = rows[l][k], k < kCount.
template <int kCount>
RAYLIGN_INLINE void gather(const double* const* rows, D4* out) {
  constexpr int kWhole = kCount / 4 * 4;
  for (int k = 0; k < kWhole; k += 4) {
    for (int lane = 0; lane < 4; ++lane) load(rows[lane] + k, out[k + lane]);
    transpose(out[k], out[k + 1], out[k + 2], out[k + 3]);
  }
  for (int k = kWhole; k < kCount; ++k) out[k] = D4{rows[0][k], rows[1][k], rows[2][k], rows[3][k]};
}

// rows[l][k] = lane l of in[k], k < kCount.
template <int kCount>
RAYLIGN_INLINE void scatter(const D4* in, double* const* rows) {
  constexpr int kWhole = kCount / 4 * 4;
  for (int k = 0; k < kWhole; k += 4) {
    D4 row[4] = {in[k], in[k + 1], in[k + 2], in[k + 3]};
    transpose(row[0], row[1], row[2], row[3]);
    for (int lane = 0; lane < 4; ++lane) store(row[lane], rows[lane] + k);
  }
  for (int k = kWhole; k < kCount; ++k) {
    for (int lane = 0; lane < 4; ++lane) rows[lane][k] = in[k][lane];
  }
}

}  // namespace raylign::native
