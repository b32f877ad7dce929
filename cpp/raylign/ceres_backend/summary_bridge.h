// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/iteration_callback.h>
#include <ceres/solver.h>

#include <exception>
#include <functional>
#include <utility>

#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign::ceres_backend {

/// The options that Ceres and raylign share, by Ceres' names.
ceres::Solver::Options to_ceres(const BundleOptions& options);

/// Fills everything that Ceres' own summary knows; the choice of the linear solver, the
/// iterations and the step counts are the caller's.
Summary from_ceres(const ceres::Solver::Summary& summary, const LmOptions& options);

/// Turns Ceres' iterations into ours, keeps them, and asks the user's callback. An exception from
/// the callback stops the solve and waits in pending_exception(): it must not pass through Ceres.
class CallbackBridge final : public ceres::IterationCallback {
 public:
  /// @param time_before_s seconds spent before Ceres was called: our cumulative time counts from
  /// the call
  /// @param on_accepted   called when the parameter blocks hold a new accepted state
  CallbackBridge(const raylign::IterationCallback& callback,
                 int num_residual_blocks,
                 double time_before_s,
                 std::function<void()> on_accepted)
      : callback_(callback),
        num_residual_blocks_(num_residual_blocks),
        time_before_s_(time_before_s),
        on_accepted_(std::move(on_accepted)) {}

  ceres::CallbackReturnType operator()(const ceres::IterationSummary& summary) override;

  const std::vector<IterationSummary>& iterations() const { return iterations_; }
  std::exception_ptr pending_exception() const { return pending_exception_; }

 private:
  const raylign::IterationCallback& callback_;
  int num_residual_blocks_;
  double time_before_s_;
  std::function<void()> on_accepted_;
  std::vector<IterationSummary> iterations_;
  std::exception_ptr pending_exception_;
};

}  // namespace raylign::ceres_backend
