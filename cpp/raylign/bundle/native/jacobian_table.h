// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <string>

#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/table.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/lm.h"

namespace raylign::native {

/// J of all observations, in double or rounded to float, and the rule by which the rounded table
/// gives way to the other one, for good: the numbers say that the steps suffer. Or no table at all:
/// the kernels compute J again where they need it, in the time that reading it would take.
class JacobianTable {
 public:
  /// AUTO rounds above this number of observations.
  static constexpr std::int64_t kManyObservations = 1'000'000;

  /// @param is_weighted  a robust law's weights are in J; AUTO has no table without them
  JacobianTable(JacobianStorage wanted, bool is_weighted, std::int64_t num_observations);

  Jacobians view();
  bool is_stored() const { return is_stored_; }
  bool is_rounded() const { return is_rounded_; }

  /// What a step of damping λ, solved or tried from a state of that cost, says of the table.
  void observe(const LmSolve& step);
  void observe(const LmTrial& trial, double cost, double lambda);
  bool wants_double() const { return is_rounded_ && !complaint_.empty(); }

  /// Takes the table in double in place of the rounded one; J has to be computed again.
  void promote();

  /// Summary::jacobian_storage.
  std::string description() const;

 private:
  std::int64_t num_observations_;
  bool is_stored_;
  bool is_rounded_;
  Table<ObservationJacobian> exact_;
  Table<RoundedJacobian> rounded_;
  std::string complaint_;
  int num_long_solves_ = 0;
  int num_poor_steps_ = 0;
};

}  // namespace raylign::native
