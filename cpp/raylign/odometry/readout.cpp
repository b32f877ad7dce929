// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/odometry/readout.h"

#include <algorithm>

namespace raylign {

double ReadoutEstimator::move(const ReadoutEquation& equation, double bound_s) {
  const double gradient = information_ * (readout_s_ - mean_s_) + equation.gradient;
  const double before_s = readout_s_;
  own_information_ = equation.information;
  readout_s_ -= gradient / (information_ + own_information_);
  readout_s_ = std::clamp(readout_s_, -bound_s, bound_s);
  return readout_s_ - before_s;
}

void ReadoutEstimator::keep() {
  mean_s_ = readout_s_;
  information_ += own_information_;
  own_information_ = 0.0;
}

}  // namespace raylign
