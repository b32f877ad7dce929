// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/tracking/alignment_problem.h"
#include "raylign/tracking/options.h"
#include "raylign/tracking/result.h"

namespace raylign::tracking {

/// The sums of the pass at the pose that is assessed, as a whole and by tiles.
struct BlockSums {
  const PassSums& sums;
  const std::vector<TileSums>& tiles;
};

/// Over-dispersion of a term: mean over the columns of the ratio of the variance of its gradient,
/// estimated from blocks, to what H says. 1 for independent residuals with the right σ; n for
/// residuals that come in n equal copies. NaN when there are too few blocks.
double over_dispersion(const BlockSums& blocks, const TrackingOptions& options, bool of_depth);

/// Information, both covariances, eigenvalues; `columns` are the free ones of [υ; ω; σ; a; b].
void set_uncertainty(const BlockSums& blocks,
                     const std::vector<int>& columns,
                     const TrackingOptions& options,
                     double depth_weight,
                     AlignmentResult& result);

/// What the bands of a pass say about the readout time; `twists`: of T_th in each band, per second
/// of it.
ReadoutEquation readout_equation(const std::vector<PassSums>& bands,
                                 const std::vector<Vector6>& twists,
                                 const std::vector<int>& columns,
                                 const TrackingOptions& options,
                                 double depth_weight);

/// Overlap, usage, good ratio, agreement, residual variances.
void set_agreement(const BlockSums& blocks, int num_points, AlignmentResult& result);

/// Decides status and reason from what the result holds.
void set_status(const TrackingOptions& options, AlignmentResult& result);

}  // namespace raylign::tracking
