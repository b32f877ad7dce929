// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/result.h"

namespace raylign {

std::string to_string(PointStatus status) {
  switch (status) {
    case PointStatus::OK:
      return "ok";
    case PointStatus::FEW_VIEWS:
      return "few_views";
    case PointStatus::OUT_OF_VIEW:
      return "out_of_view";
    case PointStatus::OCCLUDED:
      return "occluded";
    case PointStatus::LOW_TEXTURE:
      return "low_texture";
    case PointStatus::SATURATED:
      return "saturated";
    case PointStatus::DIVERGED:
      return "diverged";
    case PointStatus::FIXED:
      return "fixed";
  }
  return "unknown";
}

std::string to_string(EdgeStatus status) {
  switch (status) {
    case EdgeStatus::OK:
      return "ok";
    case EdgeStatus::BEHIND:
      return "behind";
    case EdgeStatus::OUT_OF_VIEW:
      return "out_of_view";
    case EdgeStatus::OBLIQUE:
      return "oblique";
    case EdgeStatus::SCALE_CHANGE:
      return "scale_change";
    case EdgeStatus::OCCLUDED:
      return "occluded";
    case EdgeStatus::SATURATED:
      return "saturated";
    case EdgeStatus::MISMATCH:
      return "mismatch";
    case EdgeStatus::NOT_USED:
      return "not_used";
  }
  return "unknown";
}

}  // namespace raylign
