// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/bundle_adjuster.h"

#include "raylign/bundle/native/solve.h"
#include "raylign/ceres_backend/solve.h"

namespace raylign {
namespace {

void validate(const BalProblem& problem, const BundleConfig& config, const BundleOptions& options) {
  problem.validate();
  config.validate(problem.num_cameras(), problem.num_points());
  options.validate();
}

}  // namespace

Summary adjust(BalProblem& problem,
               const BundleConfig& config,
               const BundleOptions& options,
               const IterationCallback& callback) {
  validate(problem, config, options);
  switch (options.backend) {
    case Backend::NATIVE:
      return native::solve(problem, config, options, callback);
    case Backend::CERES:
      break;
  }
  return ceres_backend::solve(problem, config, options, callback);
}

Linearization linearize(const BalProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options) {
  validate(problem, config, options);
  return ceres_backend::linearize(problem, config, options);
}

}  // namespace raylign
