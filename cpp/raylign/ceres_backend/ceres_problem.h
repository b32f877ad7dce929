// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/manifold.h>
#include <ceres/problem.h>

#include <array>
#include <memory>
#include <vector>

#include "raylign/ceres_backend/linear_solver_choice.h"
#include "raylign/parametrization/constants.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign {
class Stopwatch;
}

namespace raylign::ceres_backend {

/// A ceres::Problem with what a solve of it needs. Those who derive own everything that it points
/// to.
class CeresProblem {
 public:
  CeresProblem() = default;
  CeresProblem(const CeresProblem&) = delete;  // Ceres keeps addresses
  CeresProblem& operator=(const CeresProblem&) = delete;
  virtual ~CeresProblem() = default;

  ceres::Problem& ceres_problem() { return *ceres_; }

  /// All parameter blocks that a residual uses, in the order of the state; the points last.
  const std::vector<double*>& blocks() const { return blocks_; }
  const std::vector<double*>& point_blocks() const { return point_blocks_; }
  bool has_free_point() const;

  /// Ceres puts the start back when it fails; what it had reached until then is kept here.
  virtual void save_state() = 0;
  virtual void restore_saved_state() = 0;

 protected:
  std::unique_ptr<ceres::Problem> ceres_;
  std::vector<double*> blocks_;
  std::vector<double*> point_blocks_;
};

/// Cost and loss functions stay with the caller, manifolds go to Ceres.
ceres::Problem::Options problem_options();

/// Of the first `size` coordinates; a mask may be longer than its block.
template <std::size_t N>
std::vector<int> held_offsets(const std::array<bool, N>& mask, int size) {
  std::vector<int> offsets;
  for (int k = 0; k < size; ++k) {
    if (mask[k]) offsets.push_back(k);
  }
  return offsets;
}

template <int Size, std::size_t N>
void hold_coordinates(ceres::Problem& problem, double* block, const std::array<bool, N>& mask) {
  if (all_held(mask)) {
    problem.SetParameterBlockConstant(block);
  } else if (count_free(mask) < Size) {
    problem.SetManifold(block, new ceres::SubsetManifold(Size, held_offsets(mask, Size)));
  }
}

/// Solves, tells the callback and gives the summary, all but `total_time_s`. The blocks then hold
/// the best state found. What the callback throws comes out, with the best state in the blocks too.
/// @param options  its linear solver is `choice`'s
/// @param clock    started when the user's call began
Summary run_ceres(CeresProblem& problem,
                  const BundleOptions& options,
                  const LinearSolverChoice& choice,
                  int num_residual_blocks,
                  const IterationCallback& callback,
                  const Stopwatch& clock);

}  // namespace raylign::ceres_backend
