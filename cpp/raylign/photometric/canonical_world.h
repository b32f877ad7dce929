// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/photometric/options.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/result.h"
#include "raylign/solver/bundle_config.h"

namespace raylign::photometric {

/// The world that a problem is solved in: the frame of the first camera, the median distance of the
/// points from it for unit. So neither damping nor any tolerance nor how scale is held depends on
/// the user's world, and a world far from its origin costs no digits inside. The start is rounded
/// to 2^-30, a millionth of a pixel: below that the single precision of the kernels would make
/// another last step of any difference, 1e-7 of the depth; so the same start in a world that has
/// been moved, turned and scaled is solved bit by bit alike.
class CanonicalWorld {
 public:
  CanonicalWorld(const PhotometricProblem& problem,
                 const BundleConfig& config,
                 const PhotometricOptions& options);

  /// False: `problem` is to be solved as it is, because a part of a translation is held, which
  /// means another thing in another world, or the damping is that of the exercise.
  bool is_used() const { return is_used_; }

  PhotometricProblem into(const PhotometricProblem& problem) const;
  PhotometricOptions into(PhotometricOptions options) const;
  /// @param solved  the problem that `result` is of; what did not move from it gets the bits of
  ///                `given`
  void back(const PhotometricProblem& given,
            const PhotometricProblem& solved,
            PhotometricResult& result) const;

 private:
  bool is_used_ = false;
  double unit_ = 1.0;  // X = R_0ᵀ (unit · X′ − t_0)
  Matrix3 R_0_ = Matrix3::Identity();
  Vector3 t_0_ = Vector3::Zero();
};

}  // namespace raylign::photometric
