// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/loss_function.h>

#include "raylign/robust/loss.h"

namespace raylign::ceres_backend {

/// raylign's robust law behind Ceres' interface: one definition of ρ for every engine.
class RobustLoss final : public ceres::LossFunction {
 public:
  explicit RobustLoss(const Loss& loss) : loss_(loss) {}

  void Evaluate(double squared_norm, double out[3]) const override {
    const LossValue value = loss_.evaluate(squared_norm);
    out[0] = value.rho;
    out[1] = value.d_rho;
    // Every law here is concave, ρ″ <= 0. Ceres aborts the process on ρ″ = NaN with ρ′ = 0, which
    // is what ρ″ becomes when s overflows.
    out[2] = value.d2_rho <= 0.0 ? value.d2_rho : 0.0;
  }

 private:
  Loss loss_;
};

}  // namespace raylign::ceres_backend
