// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/schur_kernels.h"

#include "raylign/bundle/native/kernel_math.h"

namespace raylign::native {
namespace {

// Zᵀ = (A W)ᵀ F.
RAYLIGN_INLINE void eliminate(const ObservationJacobian& J,
                              const double* W,
                              const double* F,
                              Elimination& out) {
  double E[2][3];
  multiply_transposed(W, J.A, E[0]);
  multiply_transposed(W, J.A + 3, E[1]);
  for (int m = 0; m < 3; ++m) {
    Lanes* Z = lanes(out.Z + m * kRow);
    for (int v = 0; v < kLanes; ++v) {
      Z[v] = E[0][m] * lanes(F)[v] + E[1][m] * lanes(F + kRow)[v];
    }
  }
}

// S −= Z_i Z_kᵀ: the innermost loop of bundle adjustment.
RAYLIGN_INLINE void subtract_product(const Elimination& Z_i, const Elimination& Z_k, Block& S) {
  Lanes z[3][kLanes];
  for (int m = 0; m < 3; ++m) {
    for (int v = 0; v < kLanes; ++v) z[m][v] = lanes(Z_k.Z + m * kRow)[v];
  }
  for (int row = 0; row < 9; ++row) {
    const double* w = Z_i.Z + row;
    Lanes* out = lanes(S.values + row * kRow);
    for (int v = 0; v < kLanes; ++v) {
      Lanes sum = out[v];  // one after the other: three fused multiply-subtracts
      sum -= w[0] * z[0][v];
      sum -= w[kRow] * z[1][v];
      sum -= w[2 * kRow] * z[2][v];
      out[v] = sum;
    }
  }
}

// The block rows of one track. `ids`: its cameras, −1 where there is no Z. `places`: see
// SchurPattern, null for a track that is not tabulated.
RAYLIGN_INLINE void subtract_track(const SchurBlocks& S,
                                   std::int32_t row_end,
                                   std::int64_t length,
                                   const std::int32_t* ids,
                                   const Elimination* Z,
                                   const std::uint16_t* places) {
  for (std::int64_t a = 0; a < length && ids[a] < row_end; ++a) {
    const std::uint16_t* row_places = places;
    if (places != nullptr) places += length - a;
    if (ids[a] < 0) continue;
    const std::int64_t start = S.starts[ids[a]];
    const std::int32_t* column = S.columns + start;
    for (std::int64_t b = a; b < length; ++b) {
      if (ids[b] < 0) continue;
      std::int64_t place;
      if (row_places != nullptr) {
        place = row_places[b - a];
      } else {
        while (*column < ids[b]) ++column;
        place = column - (S.columns + start);
      }
      Block& block = S.blocks[start + place];
      subtract_product(Z[a], Z[b], block);
      // the same camera twice in a track: both orders fall into one block
      if (a != b && ids[a] == ids[b]) subtract_product(Z[b], Z[a], block);
    }
  }
}

}  // namespace

RAYLIGN_CLONES void subtract_landmarks(const Observations& observations,
                                       std::int64_t num_landmarks,
                                       const CameraPacket* packets,
                                       const double* X,
                                       const ObservationJacobian* J,
                                       const LandmarkBlock* blocks,
                                       const LandmarkFactor* factors,
                                       std::int32_t row_begin,
                                       std::int32_t row_end,
                                       const SchurBlocks& S,
                                       Elimination* scratch,
                                       std::int32_t* ids) {
  const std::uint16_t* places = S.places;
  for (std::int64_t j = 0; j < num_landmarks; ++j) {
    const std::int64_t first = observations.starts[j];
    const std::int64_t length = observations.starts[j + 1] - first;
    const bool tabulated = length <= S.max_tabulated;
    const std::uint16_t* track_places = tabulated ? places : nullptr;
    if (tabulated) places += length * (length + 1) / 2;
    const std::int32_t* track = observations.camera + first;
    if (track[0] >= row_end || track[length - 1] < row_begin) continue;
    const double* W = factors[j].W;
    double y[3];
    multiply_transposed(W, blocks[j].g, y);
    for (std::int64_t a = 0; a < length; ++a) {
      const std::int32_t i = track[a];
      ids[a] = i < row_begin || S.active[i] == 0 ? -1 : i;
      if (ids[a] < 0) continue;
      alignas(32) double F[2 * kRow];
      camera_rows(J[first + a], X + 3 * j, packets[i].c, F);
      const double* Z = scratch[a].Z;
      eliminate(J[first + a], W, F, scratch[a]);
      if (i >= row_end) continue;
      double* rhs = S.rhs + std::int64_t{i} * kRow;
      for (int k = 0; k < 9; ++k)
        rhs[k] += Z[k] * y[0] + Z[kRow + k] * y[1] + Z[2 * kRow + k] * y[2];
    }
    subtract_track(S, row_end, length, ids, scratch, track_places);
  }
}

RAYLIGN_CLONES void fold_block(const Block& M,
                               const Block& B_i,
                               const Block& B_k,
                               int rows,
                               int columns,
                               double* out,
                               std::int64_t stride) {
  Block P;
  for (int row = 0; row < 9; ++row) {
    Lanes sum[kLanes] = {};
    for (int m = 0; m < 9; ++m) {
      for (int v = 0; v < kLanes; ++v) {
        sum[v] += M.values[row * kRow + m] * lanes(B_k.values + m * kRow)[v];
      }
    }
    for (int v = 0; v < kLanes; ++v) lanes(P.values + row * kRow)[v] = sum[v];
  }
  for (int a = 0; a < rows; ++a) {
    alignas(32) double Q[kRow];
    Lanes sum[kLanes] = {};
    for (int row = 0; row < 9; ++row) {
      for (int v = 0; v < kLanes; ++v) {
        sum[v] += B_i.values[row * kRow + a] * lanes(P.values + row * kRow)[v];
      }
    }
    for (int v = 0; v < kLanes; ++v) lanes(Q)[v] = sum[v];
    for (int k = 0; k < columns; ++k) out[a * stride + k] = Q[k];
  }
}

}  // namespace raylign::native
