// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign {

/// How a pixel becomes one grey value.
enum class Antialiasing {
  NONE,       ///< the grey value where the centre ray lands: the same from every view, to rounding
  BANDLIMIT,  ///< the same without texture detail that the pixel grid cannot hold (2.5 to 4 px)
  SUPERSAMPLE,  ///< mean over the pixel of supersampling² rays, then the lens: a Gaussian PSF
};

/// Options of the renderer. The camera moves during the frame when a motion is given: T_cw is the
/// pose in the middle of the exposure of the middle row, exp(τ motion) T_cw the one at time τ in
/// frame intervals.
struct RenderOptions {
  Antialiasing antialiasing = Antialiasing::BANDLIMIT;
  int supersampling = 4;       ///< SUPERSAMPLE: rays per pixel and axis, in [1, 16].
  double psf_sigma = 0.5;      ///< SUPERSAMPLE: sigma of the PSF in px, in [0, 5].
  double background = 0.0;     ///< Grey value where no surface is met, in [0, 255].
  double exposure_time = 0.0;  ///< Motion blur: shutter time in frame intervals, in [0, 1].
  int blur_samples = 8;        ///< Motion blur: instants averaged, in [1, 1024].
  double readout_time = 0.0;  ///< Rolling shutter: first to last row in frame intervals, in [0, 1].
  int num_threads = 1;        ///< In [1, 1024]; the bits do not depend on it.

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

}  // namespace raylign
