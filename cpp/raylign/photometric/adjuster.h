// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/options.h"
#include "raylign/photometric/problem.h"
#include "raylign/photometric/result.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/summary.h"

namespace raylign {

/// Refines poses, points, brightness and, when asked, intrinsics so that the images agree
/// (docs/theory/photometric.md).
///
/// Levels from coarse to fine; on each, rounds: what is seen, how patches are warped and read and
/// which law the residuals follow is decided and frozen, then PatchScene is minimised by
/// options.backend. Points held out of the solve decide whether its result is better than the
/// start; if not, the start comes back bit by bit with `accepted` false (options.force: the refined
/// state).
///
/// Throws OptionsError, ShapeError; also ShapeError when no point is in view of two images.
/// Numerical trouble is Termination::FAILURE in the summary. A callback that stops, `interrupted`
/// and the time limit (options.lm, over all rounds) end with the best state so far, which goes
/// through the acceptance test like any other.
/// @param callback  sees the iterations of all rounds, numbered through
PhotometricResult adjust(const PhotometricProblem& problem,
                         const BundleConfig& config,
                         const PhotometricOptions& options,
                         const IterationCallback& callback = nullptr,
                         const InterruptCheck& interrupted = nullptr);

}  // namespace raylign
