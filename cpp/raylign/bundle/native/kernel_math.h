// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/clones.h"
#include "raylign/base/double_lanes.h"
#include "raylign/bundle/native/kernels.h"

/// The inline pieces that the kernels' files share. No Eigen, nothing with external linkage: each
/// of those files compiles them for its own instruction sets.

namespace raylign::native {

// Four lanes of a padded row. GCC leaves loops of twelve scalar; as a vector type they become AVX
// where the clone has it, and pairs of SSE2 where not.
typedef double Lanes __attribute__((vector_size(32), may_alias));
constexpr int kLanes = kRow / 4;

// The same in an array of doubles, aligned like one.
typedef double LooseLanes __attribute__((vector_size(32), may_alias, aligned(8)));

RAYLIGN_INLINE Lanes* lanes(double* row) { return reinterpret_cast<Lanes*>(row); }
RAYLIGN_INLINE const Lanes* lanes(const double* row) { return reinterpret_cast<const Lanes*>(row); }

RAYLIGN_INLINE LooseLanes* loose_lanes(double* row) { return reinterpret_cast<LooseLanes*>(row); }
RAYLIGN_INLINE const LooseLanes* loose_lanes(const double* row) {
  return reinterpret_cast<const LooseLanes*>(row);
}

template <typename T>
RAYLIGN_INLINE void cross(const T* a, const T* b, T* out) {
  out[0] = a[1] * b[2] - a[2] * b[1];
  out[1] = a[2] * b[0] - a[0] * b[2];
  out[2] = a[0] * b[1] - a[1] * b[0];
}

template <typename T>
RAYLIGN_INLINE T dot3(const T* a, const T* b) {
  return a[0] * b[0] + a[1] * b[1] + a[2] * b[2];
}

// J of one observation; the branch is the same for all of a solve.
RAYLIGN_INLINE ObservationJacobian load(const Jacobians& J, std::int64_t q) {
  if (J.rounded == nullptr) return J.exact[q];
  ObservationJacobian out;
  for (int k = 0; k < 6; ++k) out.A[k] = J.rounded[q].A[k];
  for (int k = 0; k < 6; ++k) out.I[k] = J.rounded[q].I[k];
  return out;
}

// y = Wᵀ x and y = W x for the upper triangle W = (xx, xy, xz, yy, yz, zz).
template <typename T>
RAYLIGN_INLINE void multiply_transposed(const T* W, const T* x, T* y) {
  y[0] = W[0] * x[0];
  y[1] = W[1] * x[0] + W[3] * x[1];
  y[2] = W[2] * x[0] + W[4] * x[1] + W[5] * x[2];
}

template <typename T>
RAYLIGN_INLINE void multiply(const T* W, const T* x, T* y) {
  y[0] = W[0] * x[0] + W[1] * x[1] + W[2] * x[2];
  y[1] = W[3] * x[1] + W[4] * x[2];
  y[2] = W[5] * x[2];
}

}  // namespace raylign::native
