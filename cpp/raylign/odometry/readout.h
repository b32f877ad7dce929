// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/odometry/options.h"
#include "raylign/tracking/shutter.h"

namespace raylign {

/// The readout time of a camera's rows, from what alignments tell about it: recursive least squares
/// over the frames, one number for all of them.
class ReadoutEstimator {
 public:
  explicit ReadoutEstimator(const ShutterOptions& options)
      : readout_s_(options.readout_s), mean_s_(options.readout_s) {}

  double readout_s() const { return readout_s_; }
  /// Moves readout_s() to where the frames before and this one, aligned with readout_s(), want it,
  /// within ± bound_s. Returns the step. Until `keep` this frame can be asked again.
  double move(const ReadoutEquation& equation, double bound_s);
  /// The frame counts for those that follow.
  void keep();

 private:
  // Of 1.4 ms, when residuals were independent; they are not, and it is about 10 ms.
  static constexpr double kPriorInformation = 5e5;

  double readout_s_;
  double mean_s_;  // of the frames before
  double information_ = kPriorInformation;
  double own_information_ = 0.0;
};

}  // namespace raylign
