// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/base/eigen.h"
#include "raylign/camera/radtan.h"
#include "raylign/synthetic/render/render_options.h"
#include "raylign/synthetic/render/scene.h"

namespace raylign {

/// What a perfect camera sees; (height, width) maps. Depth, normal and face belong to the ray
/// through the pixel centre in the middle of the exposure of its row, whatever the anti-aliasing.
struct RenderedFrame {
  template <typename T>
  using Map = Rows<T, Eigen::Dynamic>;

  Map<double> irradiance;  ///< grey values, mean of the scene's textures; no noise
  Map<double> depth;       ///< z in the camera frame; NaN where nothing is met
  Rows<double, 3> normal;  ///< unit, camera frame, towards the camera, row-major; NaN
  Map<std::int32_t> face;  ///< index into RenderScene::faces(); −1
};

/// Renders by casting rays. Pixels that the camera's distortion cannot reach count as met by
/// nothing. `motion` is the tangent [υ; ω] of the camera motion per frame interval (see
/// RenderOptions). Throws OptionsError for bad options, a camera that is not valid, a T_cw that is
/// not rigid; ShapeError for a size outside [1, 32766]. Cost: 0.1 µs per ray and 60 waves.
RenderedFrame render_frame(const RenderScene& scene,
                           const RadtanCamera& camera,
                           const Matrix4& T_cw,
                           int width,
                           int height,
                           const RenderOptions& options = {},
                           const Vector6& motion = Vector6::Zero());

}  // namespace raylign
