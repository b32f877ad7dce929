// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "raylign/photometric/native/patch_reader.h"

/// Residuals of an edge, their robust law, and the fourteen sums that the normal equations are made
/// of. Included by patch_kernels.cpp alone.
namespace raylign::native {

// The four bits of each half byte as lanes.
alignas(16) inline constexpr float kMaskLanes[16][4] = {
    {0, 0, 0, 0}, {1, 0, 0, 0}, {0, 1, 0, 0}, {1, 1, 0, 0}, {0, 0, 1, 0}, {1, 0, 1, 0},
    {0, 1, 1, 0}, {1, 1, 1, 0}, {0, 0, 0, 1}, {1, 0, 0, 1}, {0, 1, 0, 1}, {1, 1, 0, 1},
    {0, 0, 1, 1}, {1, 0, 1, 1}, {0, 1, 1, 1}, {1, 1, 1, 1}};

RAYLIGN_INLINE F4 mask_lanes(std::uint32_t mask, int strip) {
  return load(kMaskLanes[mask >> (4 * strip) & 15u]);
}

RAYLIGN_INLINE F4 square_root(F4 s) {
  F4 root;
  for (int k = 0; k < 4; ++k) root[k] = __builtin_sqrtf(s[k]);
  return root;
}

// Σ log x_n as the logarithm of a product, taken when the product grows large. A factor is at most
// that of a patch: 32 pixels of 1 + s / k < 1e6.
struct LogSum {
  double product = 1.0;
  double sum = 0.0;
};

/// Above this `take_log` is due.
inline constexpr double kLargeProduct = 1e100;

RAYLIGN_INLINE void take_log(LogSum& logs) {
  logs.sum += std::log(logs.product);
  logs.product = 1.0;
}

// ρ of the pixels of an edge added up; products of 1 + s / k stand for sums of logarithms.
struct RhoSum {
  F4 sum = {};
  F4 product = {1.0f, 1.0f, 1.0f, 1.0f};
};

RAYLIGN_INLINE void move_product(RhoSum& rho, LogSum& logs) {
  logs.product *= (static_cast<double>(rho.product[0]) * rho.product[1]) *
                  (static_cast<double>(rho.product[2]) * rho.product[3]);
  rho.product = F4{1.0f, 1.0f, 1.0f, 1.0f};
}

// Adds ρ(s) of the lanes where m = 1; returns ρ′(s) m.
RAYLIGN_INLINE F4 weigh(Law law, float scale, float inverse_k, F4 s, F4 m, RhoSum& rho) {
  if (law == Law::LOG) {
    const F4 x = 1.0f + s * inverse_k * m;
    rho.product *= x;
    return m / x;
  }
  if (law == Law::HUBER) {
    const F4 root = square_root(s);
    const F4 linear = 2.0f * scale * root - scale * scale;
    const I4 is_inner = root <= scale;
    rho.sum += m * (is_inner ? s : linear);
    return m * (is_inner ? F4{1.0f, 1.0f, 1.0f, 1.0f} : scale / root);
  }
  rho.sum += m * s;
  return m;
}

// ρ(s) and ρ′(s) of a whole patch.
RAYLIGN_INLINE double weigh_patch(const PatchArrays& arrays, double s, double& weight) {
  if (arrays.law == Law::LOG) {
    weight = 1.0 / (1.0 + s / arrays.law_scale);
    return arrays.law_scale * std::log(1.0 + s / arrays.law_scale);
  }
  const double a = arrays.law_scale;
  if (arrays.law == Law::HUBER && s > a * a) {
    const double root = std::sqrt(s);
    weight = a / root;
    return 2.0 * a * root - a * a;
  }
  weight = 1.0;
  return s;
}

struct Brightness {
  double gain, offset, host_gain;
  double scale, fall;  // s and τ of patch_kernels.h
};

RAYLIGN_INLINE Brightness edge_brightness(const PatchArrays& arrays,
                                          const PatchStateArrays& state,
                                          std::int64_t p,
                                          const ImagePacket& image) {
  const std::int32_t host = arrays.hosts[p];
  Brightness out = {image.gain, image.b, 1.0, 1.0, 0.0};
  if (host >= 0) {
    const ImagePacket& from = state.images[host];
    out.gain *= from.inverse_gain;
    out.offset = from.inverse_gain * (image.b - from.b);
    out.host_gain = from.inverse_gain;
  }
  const double of_image = arrays.noise_ratio * out.gain * out.gain;
  const double inverse = 1.0 / (1.0 + of_image);
  out.scale = std::sqrt((1.0 + arrays.noise_ratio) * inverse);
  out.fall = of_image * inverse;
  return out;
}

// T and v of an edge; see patch_kernels.h.
struct EdgeTensor {
  double T[4][4];
  double v[4];
};

// Lane sums of one edge: ∇I ∇Iᵀ, ∇I I, ∇I, I I, I, 1, r ∇I, r I, r, r r, each times w.
struct TensorSums {
  F4 uu = {}, uv = {}, vv = {}, uI = {}, vI = {}, u = {}, v = {}, II = {}, I = {}, one = {};
  F4 ru = {}, rv = {}, rI = {}, r = {}, rr = {};
};

RAYLIGN_INLINE void add_strip(TensorSums& t, F4 I, F4 I_u, F4 I_v, F4 r, F4 w) {
  const F4 wu = w * I_u;
  const F4 wv = w * I_v;
  const F4 wI = w * I;
  t.uu += wu * I_u;
  t.uv += wu * I_v;
  t.vv += wv * I_v;
  t.uI += wu * I;
  t.vI += wv * I;
  t.u += wu;
  t.v += wv;
  t.II += wI * I;
  t.I += wI;
  t.one += w;
  t.ru += wu * r;
  t.rv += wv * r;
  t.rI += wI * r;
  const F4 wr = w * r;
  t.r += wr;
  t.rr += wr * r;
}

// f = [slope ∇I, s gain I + τ r, s], slope: s gain per px of level 0.
RAYLIGN_INLINE void finish_tensor(
    const TensorSums& t, const Brightness& b, double slope, double weight, EdgeTensor& out) {
  const F4 first = sum_lanes(t.uu, t.uv, t.vv, t.uI);
  const F4 second = sum_lanes(t.vI, t.u, t.v, t.II);
  const F4 third = sum_lanes(t.I, t.one, t.ru, t.rv);
  const F4 fourth = sum_lanes(t.rI, t.r, t.rr, t.rr);
  const double gain = b.scale * b.gain;
  const double s = weight * slope;
  const double g = weight * gain;
  const double of_r = weight * b.fall;
  const double one = weight * b.scale;
  out.T[0][0] = s * slope * first[0];
  out.T[0][1] = out.T[1][0] = s * slope * first[1];
  out.T[1][1] = s * slope * first[2];
  out.T[0][2] = out.T[2][0] = s * (gain * first[3] + b.fall * third[2]);
  out.T[1][2] = out.T[2][1] = s * (gain * second[0] + b.fall * third[3]);
  out.T[0][3] = out.T[3][0] = s * b.scale * second[1];
  out.T[1][3] = out.T[3][1] = s * b.scale * second[2];
  out.T[2][2] = g * gain * second[3] + of_r * (2.0 * gain * fourth[0] + b.fall * fourth[2]);
  out.T[2][3] = out.T[3][2] = b.scale * (g * third[0] + of_r * fourth[1]);
  out.T[3][3] = one * b.scale * third[1];
  out.v[0] = s * third[2];
  out.v[1] = s * third[3];
  out.v[2] = g * fourth[0] + of_r * fourth[2];
  out.v[3] = one * fourth[1];
}

// Σ ρ of an edge, but for the logarithms of LOG, which go to `logs` and stand for k times
// themselves; with kGradient its tensor, too.
template <bool kGradient>
RAYLIGN_INLINE double strip_costs(const PatchArrays& arrays,
                                  const KernelEdge& edge,
                                  int num_strips,
                                  const PatchPixels& pixels,
                                  const float* c,
                                  const Brightness& brightness,
                                  double slope,
                                  LogSum& logs,
                                  EdgeTensor& tensor) {
  const auto gain = static_cast<float>(brightness.gain);
  const auto offset = static_cast<float>(brightness.offset);
  const auto s = static_cast<float>(brightness.scale);
  const auto scale = static_cast<float>(arrays.law_scale);
  const auto inverse_k = static_cast<float>(1.0 / arrays.law_scale);
  const Law law = arrays.per_patch ? Law::TRIVIAL : arrays.law;
  RhoSum rho;
  TensorSums sums;
  for (int n = 0; n < num_strips; ++n) {
    const F4 r = s * (load(c + 4 * n) - (gain * pixels.I[n] + offset));
    const F4 w = weigh(law, scale, inverse_k, r * r, mask_lanes(edge.mask, n), rho);
    if (kGradient) add_strip(sums, pixels.I[n], pixels.I_u[n], pixels.I_v[n], r, w);
    if (law == Law::LOG && n % 4 == 3) move_product(rho, logs);  // a lane of four fits a float
  }
  double weight = 1.0;
  double twice = 0.0;
  if (law == Law::LOG) {
    move_product(rho, logs);
  } else {
    twice = (static_cast<double>(rho.sum[0]) + rho.sum[1]) +
            (static_cast<double>(rho.sum[2]) + rho.sum[3]);
    if (arrays.per_patch) twice = weigh_patch(arrays, twice, weight);
  }
  if (kGradient) finish_tensor(sums, brightness, slope, weight, tensor);
  return twice;
}

// As strip_costs: the loop of a patch of sixteen pixels is unrolled.
template <bool kGradient>
RAYLIGN_INLINE double edge_cost(const PatchArrays& arrays,
                                const KernelEdge& edge,
                                const PatchPixels& pixels,
                                const float* c,
                                const Brightness& brightness,
                                double slope,
                                LogSum& logs,
                                EdgeTensor& tensor) {
  if (arrays.padded_pixels == 16) {
    return strip_costs<kGradient>(arrays, edge, 4, pixels, c, brightness, slope, logs, tensor);
  }
  return strip_costs<kGradient>(arrays, edge, arrays.padded_pixels / 4, pixels, c, brightness,
                                slope, logs, tensor);
}

}  // namespace raylign::native
