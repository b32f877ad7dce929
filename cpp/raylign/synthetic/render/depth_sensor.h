// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/camera/radtan.h"
#include "raylign/depth/depth_model.h"

namespace raylign {

/// A depth camera: noise on the inverse depth D = 1/Z, its quantisation, and holes. The default is
/// like a Kinect: structured light of disparity step 1/8 px at f b = 575 px · 7.5 cm.
struct DepthSensorOptions {
  /// Law of the noise (DepthModel::inverse_depth_sigma), range, and how far from a step of the
  /// depth there is none: what a tracker that knows the sensor believes.
  DepthModel model = {};
  double noise = 1.0;  ///< Factor of the law's sigma, finite and >= 0.
  double correlation_length =
      0.0;  ///< px, in [0, 64]: noise with autocorrelation e^(−d² / (2 l²)).
  double inverse_depth_step = 0.0029;  ///< D is rounded to multiples of it, 1/m; 0: not rounded.
  double max_incidence_deg = 80.0;  ///< No depth where ray and normal differ by more, in (0, 90].
  double dropout = 0.0;             ///< Part of the pixels without depth at random, in [0, 1].

  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// Depth (height, width) in m as the sensor reports it, NaN where it reports none. `depth` and
/// `normal` (height · width, 3; camera frame) are a RenderedFrame's. The noise of frame `index`
/// follows from (seed, index) and the pixel. Throws OptionsError, ShapeError.
Rows<float, Eigen::Dynamic> sense_depth(const Eigen::Ref<const Rows<double, Eigen::Dynamic>>& depth,
                                        const Eigen::Ref<const Rows<double, 3>>& normal,
                                        const RadtanCamera& camera,
                                        const DepthSensorOptions& options,
                                        std::uint64_t seed = 0,
                                        std::uint64_t index = 0);

/// Gaussian random numbers of mean 0 and variance 1 for every pixel, autocorrelation
/// e^(−d² / (2 length²)); length 0: independent. A function of (seed, index) and the pixel.
/// Throws OptionsError for a length outside [0, 64], ShapeError for a size outside [1, 32766].
Rows<double, Eigen::Dynamic> noise_field(
    int width, int height, double correlation_length, std::uint64_t seed, std::uint64_t index);

}  // namespace raylign
