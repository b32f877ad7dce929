// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/refinement.h"

#include <algorithm>
#include <cmath>

#include "raylign/photometric/constraints.h"
#include "raylign/photometric/engine.h"
#include "raylign/photometric/native/solve.h"

namespace raylign::photometric {
namespace {

constexpr int kRoundsWithNewLaw = 2;     // then the law stays, so that the cost of a level is one
constexpr double kSettledMotion = 0.01;  // px, median over the edges
// Coarse levels and first rounds only bring the next one near: a looser end.
constexpr double kSettledCoarseMotion = 0.03;  // px of the level
constexpr double kLooseTolerance = 1e-4;
constexpr int kMinEdgesPerImage = 8;  // fewer do not move a camera
constexpr double kMinShareOfPoints =
    0.25;                                // of those that level 0 can use: else a level is skipped
constexpr double kShortestSolve = 1e-3;  // s

// Lengths that the projections of the edges have moved by, px of level 0.
std::vector<double> motions(const PatchScene& before, const PatchScene& after) {
  std::vector<double> lengths;
  for (std::int64_t p = 0; p < before.num_points(); ++p) {
    for (std::int64_t e = before.starts[p]; e < before.starts[p + 1]; ++e) {
      const EdgeSample a = evaluate_edge(before, p, before.edges[e]);
      const EdgeSample b = evaluate_edge(after, p, after.edges[e]);
      if (a.is_seen && b.is_seen) lengths.push_back((a.uv - b.uv).norm());
    }
  }
  return lengths;
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// Holds what too few patches say anything about: a camera in whose image they are seen, or which
// they were read from.
void hold_unseen_images(const Setting& setting,
                        const PatchScene& scene,
                        PatchConstraints& constraints) {
  std::vector<int> counts(scene.poses.size(), 0);
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      if (setting.is_host(p, scene.edges[e].image)) continue;
      ++counts[scene.edges[e].image];
      if (scene.hosts[p] >= 0) ++counts[scene.hosts[p]];
    }
  }
  for (std::size_t i = 0; i < counts.size(); ++i) {
    if (counts[i] < kMinEdgesPerImage) hold_image(i, constraints);
  }
}

// By what the depths of the points of each host have changed, median; 1 where too few were solved.
std::vector<double> depth_ratios(const PhotometricState& old,
                                 const PatchScene& scene,
                                 const PatchConstraints& held,
                                 const PhotometricState& state) {
  constexpr std::size_t kMinPoints = 5;
  std::vector<std::vector<double>> by_host(scene.poses.size());
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const std::int32_t host = scene.hosts[p];
    if (held.points[p] || host < 0) continue;
    const double ratio =
        state.in_camera(host, state.points.row(p)).z() / old.in_camera(host, old.points.row(p)).z();
    if (ratio > 0.0 && std::isfinite(ratio)) by_host[host].push_back(ratio);
  }
  std::vector<double> ratios;
  for (const std::vector<double>& all : by_host) {
    ratios.push_back(all.size() < kMinPoints ? 1.0 : median(all));
  }
  return ratios;
}

std::int64_t num_points_with_edges(const PatchScene& scene) {
  std::int64_t count = 0;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    if (scene.starts[p] != scene.starts[p + 1]) ++count;
  }
  return count;
}

PhotometricRound describe(int level,
                          const PatchScene& scene,
                          const RoundLaw& law,
                          const Summary& summary) {
  PhotometricRound round;
  round.level = level;
  round.num_points = static_cast<int>(num_points_with_edges(scene));
  round.num_edges = static_cast<int>(scene.num_edges());
  round.sigma = law.noise.sigma;
  round.nu = law.loss.type == LossType::STUDENT_T ? law.loss.degrees_of_freedom : -1.0;
  round.initial_cost = summary.initial_cost;
  round.final_cost = summary.final_cost;
  round.num_iterations = summary.num_accepted + summary.num_rejected;
  return round;
}

}  // namespace

RoundLaw estimate_law(const Setting& setting, const Views& views, const std::vector<bool>& active) {
  const NoiseOptions& options = setting.options.noise;
  NoiseLawOptions fit;
  // of a pixel as it is after smoothing
  fit.sensor_sigma = options.sensor_sigma * std::sqrt(setting.prepared.noise.value(0.0, 0.0));
  fit.nu = options.nu;
  RoundLaw law;
  law.noise = fit_noise_law(residuals_of(setting, views, active), fit);
  law.loss = noise_loss(law.noise, options.loss, options.scope, setting.options.pattern.size());
  if (options.scale > 0.0) law.loss.scale = options.scale;
  law.unit = cost_unit(law.loss, law.noise.sigma);
  return law;
}

double Progress::seconds_left() const {
  return std::max(options_.lm.max_solver_time_s - clock_.seconds(), kShortestSolve);
}

bool Progress::asks_to_stop() {
  if (is_over_) return true;
  const bool is_late = clock_.seconds() >= options_.lm.max_solver_time_s;
  const bool is_interrupted = interrupted_ && interrupted_();
  if (!is_late && !is_interrupted) return false;
  summary_.termination = is_late ? Termination::TIME_LIMIT : Termination::USER_STOPPED;
  summary_.message = is_late ? "max_solver_time_s reached" : "interrupted between solves";
  return is_over_ = true;
}

Summary Progress::solve(PatchScene& scene,
                        const PatchConstraints& constraints,
                        PatchSolveOptions options) {
  options.lm.max_solver_time_s = seconds_left();
  const bool is_first = summary_.iterations.empty();
  const int offset = is_first ? 0 : summary_.iterations.back().iteration;
  const double begun_s = clock_.seconds();
  const auto forward = [&](const IterationSummary& row) {
    if (!callback_ || (row.iteration == 0 && !is_first)) return CallbackAction::CONTINUE;
    IterationSummary numbered = row;
    numbered.iteration += offset;
    numbered.cumulative_time_s += begun_s;
    return callback_(numbered);
  };
  const Summary part =
      solve_scene(scene, constraints, options, options_.backend, forward, interrupted_);
  append(part);
  is_over_ =
      part.termination == Termination::USER_STOPPED || part.termination == Termination::TIME_LIMIT;
  return part;
}

void Progress::append(const Summary& part) {
  std::vector<IterationSummary> rows = std::move(summary_.iterations);
  const int offset = rows.empty() ? 0 : rows.back().iteration;
  const double begun_s = rows.empty() ? 0.0 : rows.back().cumulative_time_s;
  Summary total = part;
  total.residual_time_s += summary_.residual_time_s;
  total.jacobian_time_s += summary_.jacobian_time_s;
  total.linear_solver_time_s += summary_.linear_solver_time_s;
  for (IterationSummary row : part.iterations) {
    if (row.iteration == 0 && !rows.empty()) continue;
    row.iteration += offset;
    row.cumulative_time_s += begun_s;
    rows.push_back(row);
  }
  total.iterations = std::move(rows);
  total.count_steps();
  total.total_time_s = clock_.seconds();
  summary_ = std::move(total);
}

FrozenProblem Refinement::make_solve(const Views& views, const std::vector<bool>& active) const {
  const PhotometricOptions& options = setting_.options;
  FrozenProblem solve;
  solve.scene = used_scene(views, active);
  solve.constraints = base_;
  hold_unused(solve.scene, base_.points, solve.constraints);
  hold_unseen_images(setting_, solve.scene, solve.constraints);
  set_priors(setting_, start_, law_.unit, solve.constraints);
  solve.options.loss = law_.loss;
  solve.options.scope = options.noise.scope;
  solve.options.leaving = options.leaving;
  solve.options.max_leaving_share = options.max_leaving_share;
  solve.options.lm = options.lm;
  solve.options.lambda_rule = LambdaRule::FAST;
  if (options.additive_damping) {
    solve.options.lambda_rule = LambdaRule::G2O;
    LmOptions& lm = solve.options.lm;
    lm.jacobi_scaling = false;
    lm.min_diagonal = lm.max_diagonal = 1.0;
    lm.initial_lambda *= native::max_diagonal(solve.scene, solve.constraints, solve.options);
  }
  return solve;
}

void Refinement::run(const Plan& plan,
                     const std::vector<bool>& active,
                     Progress* progress,
                     PhotometricState& state) {
  if (plan.law != nullptr) law_ = *plan.law;
  for (int level = plan.num_levels - 1; level >= 0; --level) {
    if (level > 0 && !is_worth_solving(level, active, state)) continue;
    for (int round = 0; round < plan.max_num_rounds; ++round) {
      const bool estimate = plan.law == nullptr && round < kRoundsWithNewLaw;
      const bool is_loose = plan.max_num_rounds > 1 && (level > 0 || round == 0);
      const double motion = run_round(level, active, estimate, is_loose, progress, state);
      rounds_.back().round = round;
      if (progress != nullptr && progress->is_over()) return;
      if (level == 0 && is_loose) continue;
      if (motion < (level > 0 ? std::ldexp(kSettledCoarseMotion, level) : kSettledMotion)) break;
    }
  }
}

bool Refinement::is_worth_solving(int level,
                                  const std::vector<bool>& active,
                                  const PhotometricState& state) {
  const auto count = [&](int l) {
    return num_points_with_edges(used_scene(find_views(setting_, state, l), active));
  };
  const std::int64_t here = count(level);
  if (static_cast<double>(here) >= kMinShareOfPoints * static_cast<double>(count(0))) return true;
  messages_.push_back("level " + std::to_string(level) + " was skipped: it can use " +
                      std::to_string(here) + " points only");
  return false;
}

double Refinement::run_round(int level,
                             const std::vector<bool>& active,
                             bool estimate,
                             bool is_loose,
                             Progress* progress,
                             PhotometricState& state) {
  const Views views = find_views(setting_, state, level);
  if (estimate) law_ = estimate_law(setting_, views, active);
  FrozenProblem solve = make_solve(views, active);
  if (is_loose) {
    LmOptions& lm = solve.options.lm;
    lm.function_tolerance = std::max(lm.function_tolerance, kLooseTolerance);
  }
  PatchScene& scene = solve.scene;
  const PatchScene before = scene;
  const Summary summary = progress != nullptr
                              ? progress->solve(scene, solve.constraints, solve.options)
                              : solve_scene(scene, solve.constraints, solve.options,
                                            setting_.options.backend, nullptr, nullptr);
  adopt(scene, solve.constraints, state);
  rounds_.push_back(describe(level, scene, law_, summary));
  const std::vector<double> lengths = motions(before, scene);
  rounds_.back().max_motion_px =
      lengths.empty() ? 0.0 : *std::max_element(lengths.begin(), lengths.end());
  return median(lengths);
}

void Refinement::adopt(const PatchScene& scene,
                       const PatchConstraints& held,
                       PhotometricState& state) const {
  const PhotometricState old = state;
  state.poses = scene.poses;
  state.brightness = scene.brightness;
  state.intrinsics = scene.intrinsics;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const std::int32_t host = scene.hosts[p];
    if (held.points[p]) continue;
    const Vector3 X = world_point(scene, p);
    const bool is_sane = X.allFinite() && (host < 0 || state.in_camera(host, X).z() > 0.0);
    if (is_sane) state.points.row(p) = X.transpose();
  }
  carry_along(old, scene, held, state);
}

// Points that were not solved for go with their host's camera, and their depths with those of the
// host's other points: otherwise they would stay behind when the scale drifts.
void Refinement::carry_along(const PhotometricState& old,
                             const PatchScene& scene,
                             const PatchConstraints& held,
                             PhotometricState& state) const {
  const std::vector<double> ratios = depth_ratios(old, scene, held, state);
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const std::int32_t host = scene.hosts[p];
    if (base_.points[p] || !held.points[p] || host < 0) continue;
    if (ratios[host] == 1.0 && same_pose(old.poses[host], state.poses[host])) continue;
    const Vector3 q = ratios[host] * old.in_camera(host, old.points.row(p));
    state.points.row(p) = (state.poses[host].q.conjugate() * (q - state.poses[host].t)).transpose();
  }
}

}  // namespace raylign::photometric
