// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/adjuster.h"

#include <algorithm>

#include "raylign/base/stopwatch.h"
#include "raylign/camera/camera_model.h"
#include "raylign/photometric/acceptance.h"
#include "raylign/photometric/attempts.h"
#include "raylign/photometric/brightness_start.h"
#include "raylign/photometric/canonical_world.h"
#include "raylign/photometric/constraints.h"
#include "raylign/photometric/covariance.h"
#include "raylign/photometric/judge.h"
#include "raylign/photometric/levels.h"
#include "raylign/photometric/refinement.h"
#include "raylign/photometric/report.h"
#include "raylign/photometric/start_check.h"

namespace raylign {
namespace {

using namespace photometric;  // NOLINT(google-build-using-namespace): this file is its front door

Setting make_setting(const PhotometricProblem& problem,
                     const PhotometricOptions& options,
                     ThreadPool& pool,
                     const PhotometricState& start) {
  Setting setting{problem, options, pool, prepare_images(problem, options), {}, {}};
  setting.hosts = choose_hosts(problem, options, setting.prepared, start);
  setting.candidates = list_candidates(problem, options, setting.hosts);
  return setting;
}

void check_combination(const PhotometricProblem& problem, const PhotometricOptions& options) {
  if (options.presmooth > 0.0 && problem.has_patches()) {
    throw OptionsError("PhotometricOptions.presmooth must be 0 with stored patches, got " +
                       format_double(options.presmooth));
  }
  if (options.point_parametrization != PointParametrization::INVERSE_DEPTH) return;
  const bool hosted =
      problem.hosts.rows() > 0 ? problem.hosts.minCoeff() >= 0 : !problem.has_patches();
  if (!hosted) {
    throw OptionsError(
        "PhotometricOptions.point_parametrization INVERSE_DEPTH needs a host for every point");
  }
}

void check(const PhotometricProblem& problem,
           const BundleConfig& config,
           const PhotometricOptions& options) {
  options.validate();
  problem.validate(options.pattern.size());
  config.validate(problem.num_images(), problem.num_points(), param_names(CameraModel::PINHOLE));
  check_combination(problem, options);
}

bool moves_cameras(const PatchConstraints& constraints) {
  return !std::all_of(constraints.poses.begin(), constraints.poses.end(),
                      [](const PoseMask& mask) { return mask.all(); });
}

// Every options.hold_out-th point, when that leaves enough on both sides and there is something
// that it can judge.
std::vector<bool> choose_held_out(const Setting& setting, const PatchConstraints& constraints) {
  constexpr std::int64_t kMinPoints = 50;
  const std::int64_t N = setting.num_points();
  const int every = setting.options.hold_out;
  std::vector<bool> held_out(N, false);
  if (every == 0 || N < kMinPoints || !moves_cameras(constraints)) return held_out;
  for (std::int64_t p = every - 1; p < N; p += every) held_out[p] = !constraints.points[p];
  return held_out;
}

class Adjustment {
 public:
  Adjustment(const PhotometricProblem& problem,
             const BundleConfig& config,
             const PhotometricOptions& options,
             Progress& progress)
      : options_(options),
        progress_(progress),
        pool_(options.lm.num_threads),
        start_(start_state(problem)),
        setting_(make_setting(problem, options, pool_, start_)) {
    result_.messages = check_start(setting_, start_);
    base_ = base_constraints(setting_, start_, config);
    result_.gauge = describe_gauge(setting_, config);
    plan_ = plan_levels(setting_, start_);
    result_.messages.insert(result_.messages.end(), plan_.messages.begin(), plan_.messages.end());
  }

  PhotometricResult run() {
    given_ = start_;
    start_brightness(plan_.num_levels - 1);
    Refinement refinement(setting_, base_, start_);
    const std::vector<bool> held_out = choose_held_out(setting_, base_);
    std::vector<bool> active = held_out;
    active.flip();
    Attempts attempts(setting_, base_, start_, active, progress_, refinement);
    Attempt attempt = attempts.run(plan_.num_levels);
    result_.messages.insert(result_.messages.end(), attempts.messages().begin(),
                            attempts.messages().end());
    accept(attempt, held_out);
    if (returns_refined() && active != std::vector<bool>(active.size(), true)) {
      finish_with_all_points(refinement, attempt.state);
    }
    return report(refinement, attempts.before(), attempt.state);
  }

  FrozenProblem freeze() {
    start_brightness(0);
    const std::vector<bool> all(setting_.num_points(), true);
    Refinement refinement(setting_, base_, start_);
    const Views views = find_views(setting_, start_, 0);
    refinement.set_law(estimate_law(setting_, views, all));
    return refinement.make_solve(views, all);
  }

 private:
  void start_brightness(int level) {
    if (setting_.problem.brightness.rows() > 0) return;
    start_.brightness = estimate_brightness(setting_, start_, level);
  }

  bool returns_refined() const { return result_.accepted || options_.force; }

  void accept(Attempt& attempt, const std::vector<bool>& held_out) {
    const Verdict verdict = judge_refinement(setting_, base_, attempt.law, attempt.num_levels,
                                             held_out, attempt.matches, start_, attempt.state);
    result_.accepted = verdict.accepted;
    result_.reason = verdict.reason;
    result_.num_hold_out = std::count(held_out.begin(), held_out.end(), true);
    result_.hold_out_cost_before = verdict.costs.before;
    result_.hold_out_cost_after = verdict.costs.after;
  }

  // The points that were held out have done their work: once more, on the finest level, with them.
  void finish_with_all_points(Refinement& refinement, PhotometricState& state) {
    if (progress_.is_over()) return;
    Refinement::Plan plan;
    plan.max_num_rounds = options_.max_num_rounds;
    refinement.run(plan, std::vector<bool>(setting_.num_points(), true), &progress_, state);
  }

  PhotometricResult report(const Refinement& refinement,
                           const Views& before,
                           const PhotometricState& refined) {
    result_.messages.insert(result_.messages.end(), refinement.messages().begin(),
                            refinement.messages().end());
    const PhotometricState& state = returns_refined() ? refined : given_;
    store(state, given_, setting_.problem, result_);
    Views after = returns_refined() ? find_views(setting_, refined, 0) : before;
    if (returns_refined() && options_.visibility.rule == VisibilityRule::AUTO) {
      mark_diverged(setting_, refinement.law().noise.sigma, after);
    }
    report_views(setting_, before, after, base_.points, result_);
    if (returns_refined()) add_covariances(refinement, after);
    result_.rounds = refinement.rounds();
    result_.summary = progress_.summary();
    result_.sigma = refinement.law().noise.sigma;
    result_.threshold = refinement.law().loss.scale;
    result_.noise_ratio = after.scene.noise_ratio;
    result_.presmooth = setting_.prepared.presmooth;
    if (refinement.law().loss.type == LossType::STUDENT_T) {
      result_.nu = refinement.law().loss.degrees_of_freedom;
    }
    return std::move(result_);
  }

  void add_covariances(const Refinement& refinement, const Views& views) {
    if (options_.covariance == CovarianceScope::NONE) return;
    CovarianceOptions options;
    options.points = options_.covariance == CovarianceScope::ALL;
    options.presmooth = setting_.prepared.presmooth;
    options.prior_unit = refinement.law().unit;
    const FrozenProblem solve =
        refinement.make_solve(views, std::vector<bool>(setting_.num_points(), true));
    if (solve.scene.num_edges() == 0) return;
    PhotometricCovariance covariance =
        photometric_covariance(solve.scene, solve.constraints, solve.options, options);
    result_.pose_covariance = std::move(covariance.poses);
    result_.point_covariances = std::move(covariance.points);
    result_.covariance_overlap = covariance.overlap;
    result_.shared_noise = covariance.shared_noise;
    result_.free_directions = covariance.free_directions;
  }

  const PhotometricOptions& options_;
  Progress& progress_;
  ThreadPool pool_;
  PhotometricState start_;  // with the brightness that the solve starts from
  PhotometricState given_;  // as the problem has it
  Setting setting_;
  PatchConstraints base_;
  LevelPlan plan_;
  PhotometricResult result_;
};

}  // namespace

PhotometricResult adjust(const PhotometricProblem& problem,
                         const BundleConfig& config,
                         const PhotometricOptions& options,
                         const IterationCallback& callback,
                         const InterruptCheck& interrupted) {
  const Stopwatch clock;
  check(problem, config, options);
  const CanonicalWorld world(problem, config, options);
  if (!world.is_used()) {
    Progress progress(options, clock, callback, interrupted);
    return Adjustment(problem, config, options, progress).run();
  }
  const PhotometricProblem inside = world.into(problem);
  const PhotometricOptions inside_options = world.into(options);
  Progress progress(inside_options, clock, callback, interrupted);
  PhotometricResult result = Adjustment(inside, config, inside_options, progress).run();
  world.back(problem, inside, result);
  return result;
}

FrozenProblem freeze(const PhotometricProblem& problem,
                     const BundleConfig& config,
                     const PhotometricOptions& options) {
  check(problem, config, options);
  const Stopwatch clock;
  const IterationCallback no_callback;
  const InterruptCheck never;
  Progress unused(options, clock, no_callback, never);
  return Adjustment(problem, config, options, unused).freeze();
}

}  // namespace raylign
