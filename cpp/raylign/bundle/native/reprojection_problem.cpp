// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/reprojection_problem.h"

#include <algorithm>
#include <atomic>
#include <cmath>
#include <cstring>
#include <limits>

#include "raylign/bundle/native/landmark_kernels.h"
#include "raylign/bundle/native/make_solver.h"
#include "raylign/bundle/native/trial_kernels.h"

namespace raylign::native {
namespace {

std::vector<CoordinateMask> landmark_masks(const Layout& layout, const Constants& held) {
  std::vector<CoordinateMask> masks;
  if (held.points.empty()) return masks;
  for (const std::int32_t point : layout.points) masks.push_back(held.points[point]);
  return masks;
}

constexpr int kCamerasPerTask = 32;
constexpr int kDiagonal[3] = {0, 3, 5};  // of LandmarkBlock::H

// max(a, |b|), NaN once b is not finite: std::max would step over it.
double larger(double a, double b) {
  b = std::abs(b);
  if (std::isfinite(b)) return b > a ? b : a;  // a NaN in a stays
  return std::numeric_limits<double>::quiet_NaN();
}

bool is_homogeneous(const BundleOptions& options) {
  return options.point_parametrization == PointParametrization::HOMOGENEOUS;
}

}  // namespace

ReprojectionProblem::ReprojectionProblem(const BundleScene& scene,
                                         const Constants& held,
                                         const BundleOptions& options,
                                         const InterruptCheck& interrupted)
    : options_(options),
      frame_(is_homogeneous(options) ? homogeneous_frame(scene) : HomogeneousFrame{}),
      pool_(options.lm.num_threads),
      layout_(scene, is_homogeneous(options) ? PointKind::HOMOGENEOUS : PointKind::XYZ, pool_),
      held_(landmark_masks(layout_, held)),
      cameras_(scene, options.pose_parametrization, held, layout_.observed, frame_),
      J_(options.jacobian_storage,
         options.loss.type != LossType::TRIVIAL,
         layout_.num_observations()),
      solver_(make_linear_solver(options.linear_solver, {layout_, cameras_, pool_}, interrupted)) {
  const std::int64_t num_landmarks = layout_.num_landmarks();
  load_points(scene);
  landmark_blocks_.resize(num_landmarks);
  landmark_factors_.resize(num_landmarks);
  landmark_scales_.resize(3 * num_landmarks);
  const auto num_chunks = static_cast<std::size_t>(layout_.num_chunks());
  for (int g = 0; g < layout_.num_chunks(); ++g) {
    const auto [first, last] = layout_.camera_range(g);
    chunk_first_camera_.push_back(first);
    chunk_cameras_.emplace_back(last - first);
  }
  camera_sums_.resize(layout_.num_cameras);
  chunk_states_.resize(num_chunks);
  chunk_trials_.resize(num_chunks);
  trial_scratch_.assign(pool_.num_threads(), Table<TrialScratch>(layout_.max_track_length()));
  row_scratch_.assign(pool_.num_threads(), Table<CameraRows>(layout_.max_window()));
  const auto columns = static_cast<std::size_t>(cameras_.num_columns());
  for (auto* table : {&camera_gradient_, &camera_diagonal_, &camera_scales_, &damping_, &delta_}) {
    table->resize(columns);
  }
  canonical_delta_.assign(static_cast<std::size_t>(layout_.num_cameras) * kRow, 0.0);
}

void ReprojectionProblem::load_points(const BundleScene& scene) {
  X_.resize(point_size() * layout_.num_landmarks());
  pool_.run(layout_.num_chunks(), [&](int g) {
    for (auto j = layout_.chunks[g]; j < layout_.chunks[g + 1]; ++j) {
      load_point(scene.points.row(layout_.points[j]).transpose(), X_.data() + point_size() * j);
    }
  });
  X_trial_.resize(X_.size());
}

void ReprojectionProblem::load_point(const Vector3& X, double* out) const {
  if (layout_.point_kind == PointKind::HOMOGENEOUS) {
    Eigen::Map<Vector4>{out} = frame_.from_world(X);
  } else {
    Eigen::Map<Vector3>{out} = X;
  }
}

int ReprojectionProblem::num_effective_parameters() const {
  std::int64_t held = 0;
  for (const CoordinateMask& mask : held_) held += std::count(mask.begin(), mask.end(), true);
  return static_cast<int>(cameras_.num_columns() + 3 * layout_.num_landmarks() - held);
}

LmState ReprojectionProblem::linearize() {
  ++num_linearizations_;
  LmState state = linearize_chunks();
  state.gradient_max_norm = larger(state.gradient_max_norm, sum_cameras());
  if (!has_scales_) set_scales();
  cost_ = state.cost;
  return state;
}

// Calls task(chunk, worker): the workers share the chunks, each has its scratch.
template <typename Task>
void ReprojectionProblem::for_each_chunk(const Task& task) {
  std::atomic<int> next{0};
  pool_.run(pool_.num_threads(), [&](int worker) {
    for (int g = next++; g < layout_.num_chunks(); g = next++) task(g, worker);
  });
}

LmState ReprojectionProblem::linearize_chunks() {
  for_each_chunk([&](int g, int worker) { linearize_chunk(g, row_scratch_[worker].data()); });
  LmState state{0.0, 0.0};
  for (const LmState& chunk : chunk_states_) {
    state.cost += chunk.cost;
    state.gradient_max_norm = larger(state.gradient_max_norm, chunk.gradient_max_norm);
  }
  return state;
}

void ReprojectionProblem::linearize_chunk(int g, CameraRows* scratch) {
  LmState& state = chunk_states_[g];
  std::fill(chunk_cameras_[g].begin(), chunk_cameras_[g].end(), CameraSums{});
  const LinearizationTables tables{J_.view(), landmark_blocks_.data(), chunk_cameras_[g].data(),
                                   chunk_first_camera_[g], scratch};
  state.cost = native::linearize(this->state(), layout_.chunk_windows[g],
                                 layout_.chunk_windows[g + 1], tables);
  state.gradient_max_norm = largest_gradient(landmark_blocks_.data(), held_points(),
                                             layout_.chunks[g], layout_.chunks[g + 1]);
}

// Adds up the chunks; max |gradient| of the cameras.
double ReprojectionProblem::sum_cameras() {
  const int num_cameras = cameras_.num_cameras();
  const int num_parts = (num_cameras + kCamerasPerTask - 1) / kCamerasPerTask;
  pool_.run(num_parts, [&](int part) {
    const int end = std::min(num_cameras, (part + 1) * kCamerasPerTask);
    for (int i = part * kCamerasPerTask; i < end; ++i) sum_camera(i);
  });
  double largest = 0.0;
  for (const double g : camera_gradient_) largest = larger(largest, g);
  return largest;
}

// Chunk after chunk, each number in one fixed order. Then gradient Bᵀg and diagonal of BᵀUB: what
// the loop and the damping see, in the user's tangent.
void ReprojectionProblem::sum_camera(int i) {
  CameraSums& sums = camera_sums_[i];
  sums = {};
  for (std::size_t g = 0; g < chunk_cameras_.size(); ++g) {
    const std::int64_t place = i - chunk_first_camera_[g];
    if (place < 0 || place >= static_cast<std::int64_t>(chunk_cameras_[g].size())) continue;
    const CameraSums& chunk = chunk_cameras_[g][place];
    for (int k = 0; k < kBlock; ++k) sums.U.values[k] += chunk.U.values[k];
    for (int k = 0; k < kRow; ++k) sums.g[k] += chunk.g[k];
  }
  const int size = cameras_.size(i);
  const double* B = cameras_.map(i).values;
  double folded[9 * kRow];
  fold_block(sums.U, cameras_.map(i), cameras_.map(i), size, size, folded, kRow);
  for (int a = 0; a < size; ++a) {
    double gradient = 0.0;
    for (int m = 0; m < 9; ++m) gradient += B[m * kRow + a] * sums.g[m];
    camera_gradient_[cameras_.offset(i) + a] = gradient;
    camera_diagonal_[cameras_.offset(i) + a] = std::max(0.0, folded[a * kRow + a]);
  }
}

void ReprojectionProblem::set_scales() {
  for (std::size_t a = 0; a < camera_scales_.size(); ++a) {
    camera_scales_[a] = lm_column_scale(camera_diagonal_[a], options_.lm);
  }
  for (std::int64_t j = 0; j < layout_.num_landmarks(); ++j) {
    for (int k = 0; k < 3; ++k) {
      landmark_scales_[3 * j + k] =
          lm_column_scale(landmark_blocks_[j].H[kDiagonal[k]], options_.lm);
    }
  }
  has_scales_ = true;
}

void ReprojectionProblem::set_damping(double lambda) {
  for (std::size_t a = 0; a < damping_.size(); ++a) {
    damping_[a] = lambda * lm_damping(camera_diagonal_[a], camera_scales_[a], options_.lm);
  }
  const LandmarkDamping damping{lambda, options_.lm.min_diagonal, options_.lm.max_diagonal,
                                landmark_scales_.data(), held_points()};
  pool_.run(layout_.num_chunks(), [&](int g) {
    factor_landmarks(landmark_blocks_.data(), damping, layout_.chunks[g], layout_.chunks[g + 1],
                     landmark_factors_.data());
  });
}

DampedProblem ReprojectionProblem::damped(double lambda) {
  set_damping(lambda);
  return {layout_.observations(),  cameras_.packets(),       X_.data(),           J_.view(),
          landmark_blocks_.data(), landmark_factors_.data(), camera_sums_.data(), damping_.data(),
          num_linearizations_};
}

LmSolve ReprojectionProblem::solve_once(double lambda, bool tight) {
  DampedProblem problem = damped(lambda);
  problem.tight = tight;
  const LmSolve step = solver_->solve(problem, delta_.data());
  J_.observe(step);
  return step;
}

LmSolve ReprojectionProblem::solve(double lambda, bool tight) {
  lambda_ = lambda;
  if (J_.wants_double()) promote_jacobians();
  const LmSolve step = solve_once(lambda, tight);
  if (step.solved || !J_.wants_double()) return step;
  promote_jacobians();
  return solve_once(lambda, tight);
}

// The same state linearised again, into the table in double.
void ReprojectionProblem::promote_jacobians() {
  J_.promote();
  ++num_linearizations_;
  linearize_chunks();
  sum_cameras();
}

void ReprojectionProblem::set_canonical_step() {
  for (int i = 0; i < cameras_.num_cameras(); ++i) {
    const double* B = cameras_.map(i).values;
    for (int m = 0; m < 9; ++m) {
      double sum = 0.0;
      for (int a = 0; a < cameras_.size(i); ++a) {
        sum += B[m * kRow + a] * delta_[cameras_.offset(i) + a];
      }
      canonical_delta_[i * kRow + m] = sum;
    }
  }
}

double ReprojectionProblem::camera_gradient_step() const {
  double sum = 0.0;
  for (std::size_t a = 0; a < delta_.size(); ++a) sum += camera_gradient_[a] * delta_[a];
  return sum;
}

LmTrial ReprojectionProblem::try_step() {
  set_canonical_step();
  cameras_.try_step(delta_.data());
  const TrialStep step{state(),
                       cameras_.trial_packets(),
                       J_.view(),
                       landmark_blocks_.data(),
                       landmark_factors_.data(),
                       canonical_delta_.data(),
                       X_trial_.data(),
                       !options_.parity};
  for_each_chunk([&](int g, int worker) {
    chunk_trials_[g] = try_landmarks(step, layout_.chunks[g], layout_.chunks[g + 1],
                                     trial_scratch_[worker].data());
  });
  TrialSums sums;
  for (const TrialSums& chunk : chunk_trials_) {
    sums.cost += chunk.cost;
    sums.model_decrease += chunk.model_decrease;
    sums.squared_step += chunk.squared_step;
    sums.squared_state += chunk.squared_state;
  }
  for (const double d : delta_) sums.squared_step += d * d;
  sums.squared_state += cameras_.squared_norm();
  const LmTrial trial{sums.cost, sums.model_decrease - camera_gradient_step(),
                      std::sqrt(sums.squared_step), std::sqrt(sums.squared_state)};
  J_.observe(trial, cost_, lambda_);
  return trial;
}

void ReprojectionProblem::accept() {
  cameras_.accept();
  X_.swap(X_trial_);
}

void ReprojectionProblem::write_back(BundleScene& scene) const {
  cameras_.write_back(scene);
  for (std::int64_t j = 0; j < layout_.num_landmarks(); ++j) {
    const double* X = X_.data() + point_size() * j;
    auto row = scene.points.row(layout_.points[j]);
    double start[4];
    load_point(row.transpose(), start);
    if (std::memcmp(X, start, point_size() * sizeof(double)) == 0) continue;
    if (layout_.point_kind == PointKind::HOMOGENEOUS) {
      row = frame_.to_world(Eigen::Map<const Vector4>(X)).transpose();
    } else {
      row = Eigen::Map<const Vector3>(X).transpose();
    }
  }
}

}  // namespace raylign::native
