// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/bundle_adjuster.h"

#include "raylign/bundle/native/solve.h"
#include "raylign/ceres_backend/solve.h"

namespace raylign {
namespace {

CameraModel model_of(const BalProblem& /*problem*/) { return CameraModel::BAL; }
CameraModel model_of(const BundleProblem& problem) { return problem.camera_model; }

template <typename Problem>
void validate(const Problem& problem, const BundleConfig& config, const BundleOptions& options) {
  problem.validate();
  config.validate(problem.num_cameras(), problem.num_points(), param_names(model_of(problem)));
  options.validate();
}

struct Choice {
  Backend backend;
  std::string reason;
};

Choice choose_backend(const BundleScene& scene,
                      const BundleConfig& config,
                      const BundleOptions& options) {
  if (options.backend != Backend::AUTO) return {options.backend, "requested"};
  const std::string missing = native::missing_feature(scene, config, options);
  if (missing.empty()) return {Backend::NATIVE, "auto: it has all that was asked for"};
  BundleOptions instead = options;
  instead.backend = Backend::CERES;
  instead.validate();  // what only NATIVE has
  return {Backend::CERES, "auto: " + missing};
}

Summary solve(BundleScene& scene,
              const BundleConfig& config,
              const BundleOptions& options,
              const IterationCallback& callback,
              const InterruptCheck& interrupted) {
  const Choice choice = choose_backend(scene, config, options);
  Summary summary = choice.backend == Backend::NATIVE
                        ? native::solve(scene, config, options, callback, interrupted)
                        : ceres_backend::solve(scene, config, options, callback);
  summary.backend_reason = choice.reason;
  return summary;
}

template <typename Problem>
Summary adjust_in_scene(Problem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options,
                        const IterationCallback& callback,
                        const InterruptCheck& interrupted) {
  validate(problem, config, options);
  BundleScene scene(problem);
  const Summary summary = solve(scene, config, options, callback, interrupted);
  scene.store(problem);
  return summary;
}

}  // namespace

Summary adjust(BalProblem& problem,
               const BundleConfig& config,
               const BundleOptions& options,
               const IterationCallback& callback,
               const InterruptCheck& interrupted) {
  return adjust_in_scene(problem, config, options, callback, interrupted);
}

Summary adjust(BundleProblem& problem,
               const BundleConfig& config,
               const BundleOptions& options,
               const IterationCallback& callback,
               const InterruptCheck& interrupted) {
  return adjust_in_scene(problem, config, options, callback, interrupted);
}

Linearization linearize(const BalProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options) {
  validate(problem, config, options);
  return ceres_backend::linearize(problem, config, options);
}

Linearization linearize(const BundleProblem& problem,
                        const BundleConfig& config,
                        const BundleOptions& options) {
  validate(problem, config, options);
  return ceres_backend::linearize(problem, config, options);
}

}  // namespace raylign
