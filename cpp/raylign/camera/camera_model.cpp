// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/camera_model.h"

namespace raylign {

int num_params(CameraModel model) {
  return visit_camera(model, [](auto type) { return int{decltype(type)::Camera::kNumParams}; });
}

std::vector<std::string> param_names(CameraModel model) {
  switch (model) {
    case CameraModel::BAL:
      return {"f", "k1", "k2"};
    case CameraModel::PINHOLE:
      return {"fx", "fy", "cx", "cy"};
    case CameraModel::RADTAN:
      return {"fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"};
  }
  return {};
}

std::vector<CameraModel> all_camera_models() {
  return {CameraModel::BAL, CameraModel::PINHOLE, CameraModel::RADTAN};
}

std::string to_string(CameraModel model) {
  switch (model) {
    case CameraModel::BAL:
      return "bal";
    case CameraModel::PINHOLE:
      return "pinhole";
    case CameraModel::RADTAN:
      return "radtan";
  }
  return "unknown";
}

}  // namespace raylign
