// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "raylign/camera/bal.h"
#include "raylign/camera/pinhole.h"
#include "raylign/camera/radtan.h"

namespace raylign {

/// The camera classes by name, for data that says at run time which one it means.
enum class CameraModel {
  BAL,      ///< BalCamera: f, k1, k2; looks along −z, v up
  PINHOLE,  ///< PinholeCamera: fx, fy, cx, cy; looks along +z, v down
  RADTAN,   ///< RadtanCamera (Brown-Conrady): fx, fy, cx, cy, k1, k2, p1, p2, k3; as PINHOLE
};

/// The most parameters that a model has.
inline constexpr int kMaxCameraParams = RadtanCamera::kNumParams;

/// Stands for a camera class in overload resolution and generic lambdas.
template <typename C>
struct CameraType {
  using Camera = C;
};

/// Calls visit(CameraType<…>) with the class behind `model`: the one switch over camera models.
template <typename Visitor>
decltype(auto) visit_camera(CameraModel model, Visitor&& visit) {
  switch (model) {
    case CameraModel::PINHOLE:
      return visit(CameraType<PinholeCamera>{});
    case CameraModel::RADTAN:
      return visit(CameraType<RadtanCamera>{});
    case CameraModel::BAL:
      break;
  }
  return visit(CameraType<BalCamera>{});
}

int num_params(CameraModel model);
/// Names of the parameters in the order of the class' `params()`.
std::vector<std::string> param_names(CameraModel model);

std::vector<CameraModel> all_camera_models();
std::string to_string(CameraModel model);

}  // namespace raylign
