// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string_view>

namespace raylign {

/// SplitMix64 (Steele, Lea & Flood, OOPSLA 2014): advances `state`, returns 64 well-mixed bits.
constexpr std::uint64_t splitmix64(std::uint64_t& state) {
  state += 0x9e3779b97f4a7c15ULL;
  std::uint64_t z = state;
  z = (z ^ (z >> 30)) * 0xbf58476d1ce4e5b9ULL;
  z = (z ^ (z >> 27)) * 0x94d049bb133111ebULL;
  return z ^ (z >> 31);
}

/// Random numbers by name: the stream (seed, name, index, sub) is the same whoever asks for it and
/// in whatever order, so that work may be cut into any chunks or threads and knobs do not disturb
/// each other.
///
/// Generator: xoshiro256** 1.0 (Blackman & Vigna, ACM TOMS 2021), seeded through SplitMix64.
/// Distributions are our own (those of <random> differ between standard libraries), free of libm:
/// the same bits anywhere.
class RandomStream {
 public:
  RandomStream(std::uint64_t seed,
               std::string_view name,
               std::uint64_t index = 0,
               std::uint64_t sub = 0);

  /// 64 uniform bits.
  std::uint64_t bits();
  /// Uniform in [0, 1), a multiple of 2⁻⁵³.
  double uniform() { return static_cast<double>(bits() >> 11) * 0x1.0p-53; }
  /// Uniform in [low, high).
  double uniform(double low, double high) { return low + (high - low) * uniform(); }
  /// Uniform integer in [0, count); count >= 1. Lemire 2019 without the rejection step: bias <
  /// count · 2⁻³².
  std::uint32_t below(std::uint32_t count);
  /// Standard normal by the polar method (Marsaglia & Bray 1964).
  double normal();

 private:
  std::array<std::uint64_t, 4> state_;
  double spare_ = 0.0;
  bool has_spare_ = false;
};

}  // namespace raylign
