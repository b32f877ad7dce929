// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/odometry/sensed_depth.h"

namespace raylign {

/// Of the points of a keyframe that T_th brings to where `sensed` has depth, the share that lands
/// on it; 1 when there are too few to tell. The intensities may have followed something that moves
/// by itself, or a wrong pose may look alike: depth does not lie with them.
double depth_agreement(const PointList& points,
                       const Matrix4& T_th,
                       const PinholeCamera& camera,
                       const SensedDepth& sensed);

/// The left twist of T_th by which depth alone would have it otherwise, [υ; ω]: a few steps of
/// point to plane with a weak prior at zero, so that what the surfaces do not determine stays.
/// Points that land on another surface are left out. Zero when there are too few to tell.
Vector6 depth_step(const PointList& points,
                   const Matrix4& T_th,
                   const PinholeCamera& camera,
                   const SensedDepth& sensed);

}  // namespace raylign
