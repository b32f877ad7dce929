// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/image/kernels.h"

#include <cfloat>

#include "raylign/base/clones.h"

namespace raylign::image_kernels {
namespace {

template <typename Pixel>
RAYLIGN_INLINE void weigh(const Pixel* __restrict in,
                          std::int64_t n,
                          const GreyWeights& weights,
                          float* __restrict out) {
  const float w0 = weights.channel[0];
  const float w1 = weights.channel[1];
  const float w2 = weights.channel[2];
  for (std::int64_t i = 0; i < n; ++i) {
    out[i] = w0 * static_cast<float>(in[3 * i]) + w1 * static_cast<float>(in[3 * i + 1]) +
             w2 * static_cast<float>(in[3 * i + 2]);
  }
}

// Four neighbouring pixels: GCC's own transposition of three rows into cells takes twice as long.
typedef float Four __attribute__((vector_size(16), aligned(4), may_alias));

RAYLIGN_INLINE Four four(const float* pixels) { return *reinterpret_cast<const Four*>(pixels); }

// The transpose of (value, du, dv, 0).
RAYLIGN_INLINE void store_cells(Four value, Four du, Four dv, float* out) {
  const Four zero = {0.0F, 0.0F, 0.0F, 0.0F};
  const Four a01 = __builtin_shufflevector(value, du, 0, 4, 1, 5);
  const Four a23 = __builtin_shufflevector(value, du, 2, 6, 3, 7);
  const Four b01 = __builtin_shufflevector(dv, zero, 0, 4, 1, 5);
  const Four b23 = __builtin_shufflevector(dv, zero, 2, 6, 3, 7);
  Four* cells = reinterpret_cast<Four*>(out);
  cells[0] = __builtin_shufflevector(a01, b01, 0, 1, 4, 5);
  cells[1] = __builtin_shufflevector(a01, b01, 2, 3, 6, 7);
  cells[2] = __builtin_shufflevector(a23, b23, 0, 1, 4, 5);
  cells[3] = __builtin_shufflevector(a23, b23, 2, 3, 6, 7);
}

// False for NaN and infinities.
RAYLIGN_INLINE bool is_positive(float x) { return x > 0.0F && x <= FLT_MAX; }

}  // namespace

RAYLIGN_CLONES void widen(const std::uint8_t* __restrict in,
                          std::int64_t n,
                          float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>(in[i]);
}

RAYLIGN_CLONES void widen(const std::uint16_t* __restrict in,
                          std::int64_t n,
                          float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = static_cast<float>(in[i]) / 257.0F;
}

RAYLIGN_CLONES void to_grey(const std::uint8_t* in,
                            std::int64_t n,
                            const GreyWeights& weights,
                            float* out) {
  weigh(in, n, weights, out);
}

RAYLIGN_CLONES void to_grey(const std::uint16_t* in,
                            std::int64_t n,
                            const GreyWeights& weights,
                            float* out) {
  weigh(in, n, weights, out);
  for (std::int64_t i = 0; i < n; ++i) out[i] = out[i] / 257.0F;
}

RAYLIGN_CLONES void to_grey(const float* in,
                            std::int64_t n,
                            const GreyWeights& weights,
                            float* out) {
  weigh(in, n, weights, out);
}

RAYLIGN_CLONES void halve(const float* __restrict top,
                          const float* __restrict bottom,
                          std::int64_t n,
                          float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) {
    out[i] = 0.25F * ((top[2 * i] + top[2 * i + 1]) + (bottom[2 * i] + bottom[2 * i + 1]));
  }
}

RAYLIGN_CLONES void gradient_cells(const float* __restrict above,
                                   const float* __restrict here,
                                   const float* __restrict below,
                                   float scale_v,
                                   std::int64_t n,
                                   float* __restrict out) {
  std::int64_t i = 0;
  for (; i + 4 <= n; i += 4) {
    const Four value = four(here + i);
    const Four du = 0.5F * (four(here + i + 1) - four(here + i - 1));
    const Four dv = scale_v * (four(below + i) - four(above + i));
    store_cells(value, du, dv, out + 4 * i);
  }
  for (; i < n; ++i) {
    out[4 * i] = here[i];
    out[4 * i + 1] = 0.5F * (here[i + 1] - here[i - 1]);
    out[4 * i + 2] = scale_v * (below[i] - above[i]);
    out[4 * i + 3] = 0.0F;
  }
}

RAYLIGN_CLONES void squared_gradient(const float* __restrict cells,
                                     std::int64_t n,
                                     float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) {
    const float squared = cells[4 * i + 1] * cells[4 * i + 1] + cells[4 * i + 2] * cells[4 * i + 2];
    out[i] = squared <= FLT_MAX ? squared : 0.0F;
  }
}

RAYLIGN_CLONES void maximum(const float* __restrict a,
                            const float* __restrict b,
                            const float* __restrict c,
                            std::int64_t n,
                            float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) {
    const float ab = a[i] > b[i] ? a[i] : b[i];
    out[i] = ab > c[i] ? ab : c[i];
  }
}

RAYLIGN_CLONES void square_root(const float* __restrict in, std::int64_t n, float* __restrict out) {
  for (std::int64_t i = 0; i < n; ++i) out[i] = __builtin_sqrtf(in[i]);
}

RAYLIGN_CLONES void mark_depth(const float* __restrict D,
                               const float* __restrict V,
                               std::int64_t n,
                               float* __restrict D_out,
                               float* __restrict V_out) {
  for (std::int64_t i = 0; i < n; ++i) {
    const bool has_depth = is_positive(D[i]) & is_positive(V[i]);
    D_out[i] = has_depth ? D[i] : 0.0F;
    V_out[i] = has_depth ? V[i] : 0.0F;
  }
}

RAYLIGN_CLONES void halve_depth(
    const DepthRows& in, float max_depth_ratio, std::int64_t n, float* D_out, float* V_out) {
  const float* __restrict D0 = in.D[0];
  const float* __restrict D1 = in.D[1];
  const float* __restrict V0 = in.V[0];
  const float* __restrict V1 = in.V[1];
  float* __restrict D_parent = D_out;
  float* __restrict V_parent = V_out;
  for (std::int64_t i = 0; i < n; ++i) {
    const float D[4] = {D0[2 * i], D0[2 * i + 1], D1[2 * i], D1[2 * i + 1]};
    const float V[4] = {V0[2 * i], V0[2 * i + 1], V1[2 * i], V1[2 * i + 1]};
    float count = 0.0F;
    float sum_w = 0.0F;
    float sum_wD = 0.0F;
    float smallest = FLT_MAX;
    float largest = 0.0F;
    for (int k = 0; k < 4; ++k) {
      const bool has_depth = V[k] > 0.0F;
      const float inverse = 1.0F / V[k];
      const float w = has_depth ? inverse : 0.0F;
      count += has_depth ? 1.0F : 0.0F;
      sum_w += w;
      sum_wD += w * D[k];
      const float below = has_depth ? D[k] : FLT_MAX;
      smallest = below < smallest ? below : smallest;
      largest = D[k] > largest ? D[k] : largest;
    }
    const float mean_D = sum_wD / sum_w;
    const float mean_V = count / sum_w;
    const bool has_depth =
        is_positive(mean_D) & is_positive(mean_V) & (largest <= max_depth_ratio * smallest);
    D_parent[i] = has_depth ? mean_D : 0.0F;
    V_parent[i] = has_depth ? mean_V : 0.0F;
  }
}

namespace {

constexpr float kPole = -0.26794919243112270F;  // sqrt(3) - 2
constexpr int kHorizon = 24;                    // kPole^24 = 2e-14

// The causal start: the sum of pole^k s(k) over the mirrored signal (Unser 1999, eq. 2.5 ff.).
RAYLIGN_INLINE void causal_start(const float* data,
                                 std::int64_t n,
                                 std::int64_t stride,
                                 float* __restrict start) {
  for (int i = 0; i < kFilterLanes; ++i) start[i] = data[i];
  float power = kPole;
  if (n > kHorizon) {
    for (int k = 1; k < kHorizon; ++k, power *= kPole) {
      for (int i = 0; i < kFilterLanes; ++i) start[i] += power * data[k * stride + i];
    }
    return;
  }
  // One period of 2 n - 2 samples, summed over all periods.
  const std::int64_t period = 2 * n - 2;
  for (std::int64_t k = 1; k < period; ++k, power *= kPole) {
    const float* sample = data + (k < n ? k : period - k) * stride;
    for (int i = 0; i < kFilterLanes; ++i) start[i] += power * sample[i];
  }
  for (int i = 0; i < kFilterLanes; ++i) start[i] /= 1.0F - power;
}

}  // namespace

RAYLIGN_CLONES void bspline_filter(float* data, std::int64_t n, std::int64_t stride) {
  constexpr float kGain = 6.0F;
  if (n == 1) return;  // a constant is its own spline
  float state[kFilterLanes];
  causal_start(data, n, stride, state);
  for (std::int64_t k = 0; k < n; ++k) {
    float* sample = data + k * stride;
    if (k > 0) {
      for (int i = 0; i < kFilterLanes; ++i) state[i] = sample[i] + kPole * state[i];
    }
    for (int i = 0; i < kFilterLanes; ++i) sample[i] = state[i];
  }
  const float* before_last = data + (n - 2) * stride;
  constexpr float kEnd = kGain * kPole / (kPole * kPole - 1.0F);
  float* last = data + (n - 1) * stride;
  for (int i = 0; i < kFilterLanes; ++i) state[i] = kEnd * (last[i] + kPole * before_last[i]);
  for (int i = 0; i < kFilterLanes; ++i) last[i] = state[i];
  for (std::int64_t k = n - 2; k >= 0; --k) {
    float* sample = data + k * stride;
    for (int i = 0; i < kFilterLanes; ++i) state[i] = kPole * (state[i] - kGain * sample[i]);
    for (int i = 0; i < kFilterLanes; ++i) sample[i] = state[i];
  }
}

}  // namespace raylign::image_kernels
