// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/bundle/native/kernels.h"

namespace raylign::native {

/// A step of the cameras, and what the landmarks' part of it is made of.
struct TrialStep {
  State state;                        ///< before the step
  const CameraPacket* trial_packets;  ///< (C,) after it
  Jacobians J;                        ///< (N,)
  const LandmarkBlock* blocks;        ///< (L,)
  const LandmarkFactor* factors;      ///< (L,)
  const double* delta;                ///< canonical camera steps, (C, kRow)
  double* X_trial;                    ///< written
  bool refine_points;                 ///< see refine_points in trial_kernels.cpp
};

/// Sums over landmarks of what the loop wants to know of a step.
struct TrialSums {
  double cost = 0.0;
  /// Without the cameras' −gᵀδ; with what the refinement of the points gained on top (as Ceres'
  /// inner iterations count).
  double model_decrease = 0.0;
  double squared_step = 0.0;
  double squared_state = 0.0;
};

/// What one step along four tracks leaves for the next loop.
struct alignas(32) TrialScratch {
  double values[32];
};

/// Landmarks [begin, end): δX = −W Wᵀ (g + Σ Eᵀ F δ), X_trial = X ⊞ δX, and the cost there.
/// `scratch`: (max_track_length,), one per thread.
TrialSums try_landmarks(const TrialStep& step,
                        std::int64_t begin,
                        std::int64_t end,
                        TrialScratch* scratch);

}  // namespace raylign::native
