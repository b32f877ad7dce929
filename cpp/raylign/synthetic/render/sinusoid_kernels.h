// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Sums of plane waves at many points: the inner loop of the renderer. Sums run over the waves in
/// order for each point and nothing is contracted: the same bits on every processor.
namespace raylign::render {

/// Points are handed over in multiples of this.
inline constexpr int kPointBlock = 16;

/// Σ amplitude_k sin π(x · frequency_k + phase_k); frequencies in half turns per unit length.
struct Waves {
  int count = 0;
  const double* frequency[3] = {};
  const double* phase = nullptr;
  const double* amplitude = nullptr;
};

/// `size` points, a multiple of kPointBlock.
struct WavePoints {
  int size = 0;
  const double* position[3] = {};
  const double* by_u[3] = {};  ///< d(position)/d(pixel column); only for sum_banded_waves
  const double* by_v[3] = {};  ///< d(position)/d(pixel row)
};

/// A wave of 4 px or longer in the image passes whole, one of 2.5 px or shorter not at all.
inline constexpr double kPassWavelength = 4.0;
inline constexpr double kStopWavelength = 2.5;

/// value[i] = the sum at point i.
void sum_waves(const Waves& waves, const WavePoints& points, double* value);

/// The sum with every wave weighted by w(|J^T frequency|²), J = [by_u by_v]: 1 up to
/// 1 / kPassWavelength cycles per px, 0 from 1 / kStopWavelength on, quintic (C2) in between.
void sum_banded_waves(const Waves& waves, const WavePoints& points, double* value);

/// The sum and its gradient by position.
void sum_wave_gradients(const Waves& waves,
                        const WavePoints& points,
                        double* value,
                        double* const gradient[3]);

}  // namespace raylign::render
