// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/solver/summary.h"

namespace raylign {

enum class PointStatus : std::uint8_t {
  OK,
  FEW_VIEWS,    ///< seen, but by fewer images than it takes
  OUT_OF_VIEW,  ///< in no image but at most its host
  OCCLUDED,     ///< hidden behind other points in most images
  LOW_TEXTURE,  ///< its patch has too little gradient
  SATURATED,    ///< too few pixels of its patch count
  DIVERGED,     ///< most images show something else than its patch
  FIXED,        ///< held by the config; used
};

enum class EdgeStatus : std::uint8_t {
  OK,
  BEHIND,        ///< the point is behind the camera or too near
  OUT_OF_VIEW,   ///< the patch is not inside the image
  OBLIQUE,       ///< the surface is seen at too flat an angle
  SCALE_CHANGE,  ///< too much larger or smaller than in the host
  OCCLUDED,      ///< behind a nearer point
  SATURATED,     ///< too few pixels count
  MISMATCH,      ///< the image shows something else
  NOT_USED,      ///< the point itself is not used: see its status
};

/// One round: visibility, warps and law frozen, then one solve.
struct PhotometricRound {
  int level = -1;
  int round = -1;  ///< 0, 1, … on the level
  int num_points = 0;
  int num_edges = 0;
  double sigma = -1.0;  ///< of the law, grey levels
  double nu = -1.0;
  double initial_cost = -1.0;
  double final_cost = -1.0;
  int num_iterations = 0;
  double max_motion_px = -1.0;  ///< largest motion of a projection by the solve
};

/// What `adjust` found. Impossible values until it is filled.
struct PhotometricResult {
  // The state: the refined one, or the start bit by bit when that was not accepted.
  Rows<double, 16> T_cw;       ///< (M, 16)
  Rows<double, 3> points;      ///< (N, 3) world frame
  Rows<double, 2> brightness;  ///< (M, 2) a, b
  Rows<double, 4> intrinsics;  ///< (1, 4) or (M, 4), as in the problem

  bool accepted = false;
  std::string reason = "nothing was adjusted";
  std::int64_t num_hold_out = 0;       ///< points of the acceptance test
  double hold_out_cost_before = -1.0;  ///< mean robust cost of their edges, grey²
  double hold_out_cost_after = -1.0;
  std::vector<std::string> messages;  ///< what the user should know, one sentence each

  std::vector<PointStatus> point_status;  ///< (N,)
  Rows<std::int32_t, 1> edge_image;       ///< (E,) every candidate, in the order of the points
  Rows<std::int32_t, 1> edge_point;       ///< (E,)
  std::vector<EdgeStatus> edge_status;    ///< (E,) of the last round
  /// Grey levels, root mean square over the pixels of the edges that are OK at the end; NaN: none.
  Rows<double, 1> edge_rms_before;   ///< (E,)
  Rows<double, 1> edge_rms_after;    ///< (E,)
  Rows<double, 1> point_rms_before;  ///< (N,)
  Rows<double, 1> point_rms_after;   ///< (N,)
  Rows<double, 1> image_rms_before;  ///< (M,)
  Rows<double, 1> image_rms_after;   ///< (M,)
  Rows<double, 1> shift_px;          ///< (M,) median motion of the projections, start to end

  // What the residuals were taken for at the end.
  Rows<std::int32_t, 1> hosts;          ///< (N,) image that the patch was read from, −1: stored
  Rows<double, 2> host_uv;              ///< (N, 2) px
  Rows<float, Eigen::Dynamic> patches;  ///< (N, n) grey levels, of level 0
  Rows<double, 3> normals;              ///< (N, 3) used, host frame; NaN: none
  double sigma = -1.0;                  ///< of the law of one pixel's residual, grey levels
  double nu = -1.0;                     ///< degrees of freedom of Student's t; −1: another law
  double threshold = -1.0;   ///< scale of the loss: σ, of HUBER and CAUCHY their threshold
  double noise_ratio = 0.0;  ///< κ of the residuals, PatchScene::noise_ratio
  double presmooth = 0.0;    ///< σ of the Gaussian that the images were smoothed with, px

  std::string gauge;  ///< what anchors the result, in words
  std::vector<PhotometricRound> rounds;
  Summary summary;  ///< iterations of all rounds in a row, costs of the last round

  // Covariances of the refined state (covariance.h); empty unless asked for and returned.
  Eigen::MatrixXd pose_covariance;    ///< (6M, 6M) of ξ = [υ; ω], T_cw = exp(ξ) T_estimate
  Rows<double, 9> point_covariances;  ///< (N, 9), NaN where there is none
  double shared_noise = -1.0;         ///< share of a residual's variance that is the patch's noise
  double covariance_overlap = -1.0;   ///< patches that a pixel belongs to, on average
  int free_directions = -1;           ///< that nothing determines
};

std::string to_string(PointStatus status);
std::string to_string(EdgeStatus status);

}  // namespace raylign
