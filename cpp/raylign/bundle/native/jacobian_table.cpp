// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/jacobian_table.h"

#include <cmath>

namespace raylign::native {
namespace {

constexpr int kLongSolve = 200;
constexpr double kPoorGain = 0.25;
constexpr double kWeakDamping = 1e-10;
constexpr int kPatience = 2;

}  // namespace

JacobianTable::JacobianTable(JacobianStorage wanted,
                             bool is_weighted,
                             std::int64_t num_observations)
    : num_observations_(num_observations),
      is_stored_(wanted != JacobianStorage::AUTO || is_weighted),
      is_rounded_(is_stored_ && wanted != JacobianStorage::DOUBLE &&
                  (wanted == JacobianStorage::FLOAT || num_observations > kManyObservations)) {
  if (!is_stored_) return;
  if (is_rounded_) {
    rounded_.resize(num_observations);
  } else {
    exact_.resize(num_observations);
  }
}

Jacobians JacobianTable::view() {
  if (!is_stored_) return {nullptr, nullptr};
  return {exact_.data(), is_rounded_ ? rounded_.data() : nullptr};
}

void JacobianTable::observe(const LmSolve& step) {
  if (!is_rounded_ || step.interrupted) return;
  if (!step.solved) complaint_ = "a system had no solution";
  if (step.iterations > kLongSolve && ++num_long_solves_ == kPatience) {
    complaint_ = "conjugate gradients took more than 200 iterations twice";
  }
}

void JacobianTable::observe(const LmTrial& trial, double cost, double lambda) {
  // a cost that is not finite is the step's fault, not the table's
  if (!is_rounded_ || !std::isfinite(trial.cost)) return;
  if (!(trial.model_decrease > 0.0)) {
    complaint_ = "a step did not lower the model";
  } else if (lambda < kWeakDamping && cost - trial.cost < kPoorGain * trial.model_decrease &&
             ++num_poor_steps_ == kPatience) {
    complaint_ = "two steps at weak damping gained less than a quarter of the model's promise";
  }
}

void JacobianTable::promote() {
  is_rounded_ = false;
  Table<RoundedJacobian>().swap(rounded_);  // before the other takes memory
  exact_.resize(num_observations_);
}

std::string JacobianTable::description() const {
  if (!is_stored_) return "none";
  if (is_rounded_) return "float";
  return complaint_.empty() ? "double" : "float, then double: " + complaint_;
}

}  // namespace raylign::native
