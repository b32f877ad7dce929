// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/sinusoid_kernels.h"

#include <cstdint>

#include "raylign/base/clones.h"

namespace raylign::render {
namespace {

typedef double Lanes __attribute__((vector_size(32), may_alias, aligned(8)));
typedef std::int64_t Bits __attribute__((vector_size(32), may_alias, aligned(8)));
constexpr int kLanes = 4;
constexpr int kVectors = kPointBlock / kLanes;

// sin πh. Adding 1.5 · 2⁵² rounds h to an integer n whose parity lies in the lowest bit of the sum;
// sin πh = (−1)ⁿ sin π(h − n) with |h − n| <= ½, where the Taylor series is cut at 3e-16.
RAYLIGN_INLINE Lanes sin_pi(const Lanes& h) {
  constexpr double kRound = 6755399441055744.0;
  const Lanes shifted = h + kRound;
  const Lanes r = h - (shifted - kRound);
  const Lanes x = r * r;
  Lanes sum = x * -2.2948428997269873e-08 + 7.952054001475513e-07;  // π¹⁹ / 19!, π¹⁷ / 17!
  sum = sum * x - 2.1915353447830217e-05;
  sum = sum * x + 0.00046630280576761255;
  sum = sum * x - 0.0073704309457143504;
  sum = sum * x + 0.08214588661112823;
  sum = sum * x - 0.5992645293207921;
  sum = sum * x + 2.5501640398773455;
  sum = sum * x - 5.16771278004997;  // π³ / 3!
  sum = sum * x + 3.141592653589793;
  sum = sum * r;
  const Bits flipped =
      reinterpret_cast<const Bits&>(sum) ^ (reinterpret_cast<const Bits&>(shifted) << 63);
  return reinterpret_cast<const Lanes&>(flipped);
}

// kPointBlock values of one coordinate.
struct Block {
  Lanes x[kVectors];
};

RAYLIGN_INLINE void load(const double* from, Block& block) {
  for (int i = 0; i < kVectors; ++i) {
    block.x[i] = reinterpret_cast<const Lanes*>(from)[i];
  }
}

RAYLIGN_INLINE void store(const Block& block, double* to) {
  for (int i = 0; i < kVectors; ++i) reinterpret_cast<Lanes*>(to)[i] = block.x[i];
}

RAYLIGN_INLINE void clear(Block& block) {
  for (int i = 0; i < kVectors; ++i) block.x[i] = Lanes{};
}

RAYLIGN_INLINE Lanes dot(const Block* p, int i, const double* f) {
  return p[0].x[i] * f[0] + p[1].x[i] * f[1] + p[2].x[i] * f[2];
}

RAYLIGN_INLINE void frequency_of(const Waves& waves, int k, double* f) {
  for (int axis = 0; axis < 3; ++axis) f[axis] = waves.frequency[axis][k];
}

// 1 where q <= pass, 0 where q >= stop: s³ (10 − 15 s + 6 s²) in between.
RAYLIGN_INLINE Lanes band_weight(const Lanes& q, double stop, double inverse_width) {
  const Lanes zero = {};
  const Lanes one = zero + 1.0;
  Lanes s = (stop - q) * inverse_width;
  s = s < zero ? zero : s;
  s = s > one ? one : s;
  return s * s * s * ((6.0 * s - 15.0) * s + 10.0);
}

}  // namespace

RAYLIGN_CLONES
void sum_waves(const Waves& waves, const WavePoints& points, double* value) {
  for (int begin = 0; begin < points.size; begin += kPointBlock) {
    Block p[3];
    Block sum;
    for (int axis = 0; axis < 3; ++axis) load(points.position[axis] + begin, p[axis]);
    clear(sum);
    for (int k = 0; k < waves.count; ++k) {
      double f[3];
      frequency_of(waves, k, f);
      for (int i = 0; i < kVectors; ++i) {
        sum.x[i] += waves.amplitude[k] * sin_pi(dot(p, i, f) + waves.phase[k]);
      }
    }
    store(sum, value + begin);
  }
}

RAYLIGN_CLONES
void sum_banded_waves(const Waves& waves, const WavePoints& points, double* value) {
  // Frequencies are half turns, the band is in cycles: a factor 2, squared.
  constexpr double kStop = 4.0 / (kStopWavelength * kStopWavelength);
  constexpr double kPass = 4.0 / (kPassWavelength * kPassWavelength);
  for (int begin = 0; begin < points.size; begin += kPointBlock) {
    Block p[3], by_u[3], by_v[3];
    Block sum;
    for (int axis = 0; axis < 3; ++axis) {
      load(points.position[axis] + begin, p[axis]);
      load(points.by_u[axis] + begin, by_u[axis]);
      load(points.by_v[axis] + begin, by_v[axis]);
    }
    clear(sum);
    for (int k = 0; k < waves.count; ++k) {
      double f[3];
      frequency_of(waves, k, f);
      for (int i = 0; i < kVectors; ++i) {
        const Lanes du = dot(by_u, i, f);
        const Lanes dv = dot(by_v, i, f);
        const Lanes weight = band_weight(du * du + dv * dv, kStop, 1.0 / (kStop - kPass));
        sum.x[i] += waves.amplitude[k] * weight * sin_pi(dot(p, i, f) + waves.phase[k]);
      }
    }
    store(sum, value + begin);
  }
}

RAYLIGN_CLONES
void sum_wave_gradients(const Waves& waves,
                        const WavePoints& points,
                        double* value,
                        double* const gradient[3]) {
  constexpr double kPi = 3.141592653589793;
  for (int begin = 0; begin < points.size; begin += kPointBlock) {
    Block p[3], slope[3];
    Block sum;
    clear(sum);
    for (int axis = 0; axis < 3; ++axis) {
      load(points.position[axis] + begin, p[axis]);
      clear(slope[axis]);
    }
    for (int k = 0; k < waves.count; ++k) {
      double f[3];
      frequency_of(waves, k, f);
      for (int i = 0; i < kVectors; ++i) {
        const Lanes angle = dot(p, i, f) + waves.phase[k];
        sum.x[i] += waves.amplitude[k] * sin_pi(angle);
        const Lanes cosine = waves.amplitude[k] * kPi * sin_pi(angle + 0.5);
        for (int axis = 0; axis < 3; ++axis) slope[axis].x[i] += cosine * f[axis];
      }
    }
    store(sum, value + begin);
    for (int axis = 0; axis < 3; ++axis) store(slope[axis], gradient[axis] + begin);
  }
}

}  // namespace raylign::render
