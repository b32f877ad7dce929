// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/adjuster.h"

#include "raylign/camera/camera_model.h"

namespace raylign {
namespace {

// The start as a result.
PhotometricResult unchanged(const PhotometricProblem& problem) {
  PhotometricResult result;
  result.T_cw = problem.T_cw;
  result.points = problem.points;
  result.intrinsics = problem.intrinsics;
  result.brightness = problem.brightness;
  if (result.brightness.rows() == 0) result.brightness.setZero(problem.num_images(), 2);
  return result;
}

}  // namespace

PhotometricResult adjust(const PhotometricProblem& problem,
                         const BundleConfig& config,
                         const PhotometricOptions& options,
                         const IterationCallback& /*callback*/,
                         const InterruptCheck& /*interrupted*/) {
  options.validate();
  problem.validate(options.pattern.size());
  config.validate(problem.num_images(), problem.num_points(), param_names(CameraModel::PINHOLE));
  PhotometricResult result = unchanged(problem);
  result.summary = nothing_to_adjust(to_string(options.backend));
  return result;
}

}  // namespace raylign
