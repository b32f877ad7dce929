// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/depth/depth_model.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {

double DepthModel::effective_sigma() const {
  if (sigma > 0.0) return sigma;
  switch (noise) {
    case DepthNoise::KINECT:
      return 1.0;
    case DepthNoise::DISPARITY:
      return 0.5;
    case DepthNoise::TIME_OF_FLIGHT:
      return 0.01;
    case DepthNoise::CONSTANT:
      break;
  }
  return 0.002;
}

DepthNoiseLaw<double> DepthModel::law() const {
  const double s = effective_sigma();
  DepthNoiseLaw<double> law;
  switch (noise) {
    case DepthNoise::KINECT:
      // Axial noise of Nguyen, Izadi, Lovell, 3DIMPVT 2012, eq. 1, for surfaces that face the
      // sensor.
      law.c0 = 0.0012 * s;
      law.c1 = 0.0019 * s;
      break;
    case DepthNoise::TIME_OF_FLIGHT:
      law.c0 = s;
      break;
    case DepthNoise::DISPARITY:
      law.constant = s / focal_baseline;
      break;
    case DepthNoise::CONSTANT:
      law.constant = s;
      break;
  }
  return law;
}

double DepthModel::inverse_depth_sigma(double depth) const { return law().sigma(1.0 / depth); }

void DepthModel::validate() const {
  require_option(sigma >= 0 && std::isfinite(sigma), "DepthModel.sigma", "finite and >= 0", sigma);
  const bool is_stereo = noise == DepthNoise::DISPARITY;
  require_option(
      std::isfinite(focal_baseline) && (is_stereo ? focal_baseline > 0 : focal_baseline >= 0),
      "DepthModel.focal_baseline", is_stereo ? "> 0 (px m) with noise DISPARITY" : ">= 0 (px m)",
      focal_baseline);
  require_option(min_depth > 0, "DepthModel.min_depth", "> 0 (m)", min_depth);
  require_option(max_depth > min_depth && std::isfinite(max_depth), "DepthModel.max_depth",
                 "finite and > min_depth (m)", max_depth);
  require_option(edge_ratio >= 0, "DepthModel.edge_ratio", ">= 0", edge_ratio);
  require_option(edge_radius >= 0 && edge_radius <= 16, "DepthModel.edge_radius", "in [0, 16]",
                 edge_radius);
}

std::string to_string(DepthNoise noise) {
  switch (noise) {
    case DepthNoise::KINECT:
      return "kinect";
    case DepthNoise::DISPARITY:
      return "disparity";
    case DepthNoise::TIME_OF_FLIGHT:
      return "time_of_flight";
    case DepthNoise::CONSTANT:
      break;
  }
  return "constant";
}

}  // namespace raylign
