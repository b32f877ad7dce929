// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_problem.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "raylign/solver/blocked_cholesky.h"
#include "raylign/solver/lapack.h"

namespace raylign::native {
namespace {

// The memory of all parts' reduced systems together, and how many parts at most.
constexpr std::int64_t kPartBytes = std::int64_t{128} << 20;
constexpr std::int64_t kMaxParts = 8;
constexpr std::int64_t kPointsPerPart = 128;

// A cost that no step is accepted with, and yet a number: leaving the images is a bad step, not a
// failure.
constexpr double kRefused = 1e300;

// The diagonal of a point's H.
constexpr int kDiagonal[3] = {0, 3, 5};

void add_to(const std::vector<double>& from, std::vector<double>& to) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += from[k];
}

double larger(double a, double b) {
  return std::isnan(a) || std::isnan(b) ? std::numeric_limits<double>::quiet_NaN()
                                        : std::max(a, std::abs(b));
}

}  // namespace

PatchProblem::PatchProblem(const PatchScene& scene,
                           const PatchConstraints& constraints,
                           const PatchSolveOptions& options,
                           InterruptCheck interrupted)
    : options_(options),
      interrupted_(std::move(interrupted)),
      constraints_(constraints),
      columns_(scene, constraints),
      layout_(scene, options, columns_.with_intrinsics()),
      pool_(options.lm.num_threads),
      inverse_depth_(scene.inverse_depth) {
  const auto N = static_cast<std::size_t>(scene.num_points());
  const auto M = static_cast<std::size_t>(scene.num_images());
  block_starts_.push_back(0);
  for (std::size_t i = 0; i < M; ++i) {
    block_starts_.push_back(block_starts_.back() + static_cast<std::int64_t>(M - i));
  }
  load_state(scene);
  held_.assign(N, 0);
  std::vector<std::int64_t> places(N);
  for (std::size_t k = 0; k < N; ++k) {
    const std::int64_t p = layout_.points()[k];
    places[p] = static_cast<std::int64_t>(k);
    if (!constraints.points.empty()) held_[k] = constraints.points[p] ? 1 : 0;
  }
  for (PatchPointPrior& prior : constraints_.point_priors) prior.point = places[prior.point];
  point_blocks_.resize(N);
  factors_.resize(N);
  point_scales_.resize(3 * N);
  point_damping_.resize(3 * N);
  const auto block_size = static_cast<std::size_t>(C() * C());
  W_.resize(static_cast<std::size_t>(layout_.num_slots()) * 3 * C());
  H_.resize(static_cast<std::size_t>(num_blocks()) * block_size);
  S_.resize(H_.size());
  gradient_.resize(M * C());
  rhs_.resize(M * C());
  image_steps_.assign(M * C(), 0.0);
  const int n = columns_.num_columns();
  column_scales_.resize(n);
  damping_.resize(n);
  matrix_.setZero(n, n);
  delta_.setZero(n);
  make_parts();
  schur_ = {C(),
            inverse_depth_ ? 1 : 3,
            layout_.arrays().slot_starts,
            layout_.arrays().slot_images,
            W_.data(),
            point_blocks_.data(),
            factors_.data(),
            block_starts_.data()};
  find_living_edges();
}

void PatchProblem::load_state(const PatchScene& scene) {
  state_.poses = scene.poses;
  state_.brightness = scene.brightness;
  state_.intrinsics = scene.intrinsics;
  for (const std::int64_t p : layout_.points()) {
    for (int k = 0; k < 3; ++k) {
      state_.points.push_back(k == 0 || !inverse_depth_ ? scene.points(p, k) : 0.0);
    }
  }
  set_packets(state_);
  trial_ = state_;
}

void PatchProblem::set_packets(State& state) const {
  state.packets.resize(state.poses.size());
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    ImagePacket& packet = state.packets[i];
    Eigen::Map<RowMajor<3, 3>>{packet.R} = state.poses[i].q.toRotationMatrix();
    Eigen::Map<Vector3>{packet.t} = state.poses[i].t;
    const auto row = static_cast<Eigen::Index>(i);
    const auto K = state.intrinsics.row(state.intrinsics.rows() == 1 ? 0 : row);
    packet.fx = K[0];
    packet.fy = K[1];
    packet.cx = K[2];
    packet.cy = K[3];
    packet.gain = std::exp(state.brightness(row, 0));
    packet.inverse_gain = std::exp(-state.brightness(row, 0));
    packet.b = state.brightness(row, 1);
  }
}

void PatchProblem::make_parts() {
  const auto N = static_cast<std::int64_t>(point_blocks_.size());
  const auto bytes = static_cast<std::int64_t>(H_.size() * sizeof(double));
  const std::int64_t fitting = std::clamp<std::int64_t>(kPartBytes / (bytes + 1), 1, kMaxParts);
  const std::int64_t count = std::clamp<std::int64_t>(N / kPointsPerPart, 1, fitting);
  parts_.resize(static_cast<std::size_t>(count));
  const std::int64_t* starts = layout_.arrays().starts;
  part_points_.push_back(0);
  for (std::int64_t g = 1; g <= count; ++g) {  // as many edges in each
    const std::int64_t* at = std::lower_bound(starts, starts + N, starts[N] * g / count);
    part_points_.push_back(g == count ? N : std::max(part_points_.back(), at - starts));
  }
  for (Part& part : parts_) {
    part.diagonal.resize(state_.poses.size() * C() * C());
    part.gradient.resize(state_.poses.size() * C());
    if (layout_.has_hosts()) part.cross.resize(H_.size());
    part.S.resize(H_.size());
    part.rhs.resize(rhs_.size());
  }
}

// An edge that is not seen at the start takes no part in a solve that keeps costs: to come into
// view would cost it.
void PatchProblem::find_living_edges() {
  left_costs_.assign(layout_.edges().size(), 0.0);
  run_linearize(true);
  is_start_linearized_ = true;
  if (options_.leaving == LeavingRule::ZERO) return;
  for (std::size_t e = 0; e < left_costs_.size(); ++e) {
    layout_.edges()[e].is_alive = left_costs_[e] >= 0.0;
    left_costs_[e] = std::max(left_costs_[e], 0.0);
  }
}

void PatchProblem::run_linearize(bool first) {
  const auto count = static_cast<int>(parts_.size());
  pool_.run(count, [&](int g) {
    Part& part = parts_[g];
    std::fill(part.diagonal.begin(), part.diagonal.end(), 0.0);
    std::fill(part.cross.begin(), part.cross.end(), 0.0);
    std::fill(part.gradient.begin(), part.gradient.end(), 0.0);
    const NormalArrays out = {point_blocks_.data(), W_.data(),
                              part.diagonal.data(), part.cross.data(),
                              part.gradient.data(), block_starts_.data()};
    part.sums =
        linearize_points(layout_.arrays(), arrays_of(state_), part_points_[g], part_points_[g + 1],
                         first ? nullptr : left_costs(), first ? left_costs_.data() : nullptr, out);
  });
}

void PatchProblem::add_parts() {
  std::fill(H_.begin(), H_.end(), 0.0);
  std::fill(gradient_.begin(), gradient_.end(), 0.0);
  const auto block_size = static_cast<std::size_t>(C() * C());
  for (const Part& part : parts_) {
    if (!part.cross.empty()) add_to(part.cross, H_);
    add_to(part.gradient, gradient_);
    for (std::size_t i = 0; i < state_.poses.size(); ++i) {
      double* block = H_.data() + static_cast<std::size_t>(block_starts_[i]) * block_size;
      const double* from = part.diagonal.data() + i * block_size;
      for (std::size_t k = 0; k < block_size; ++k) block[k] += from[k];
    }
  }
}

LmState PatchProblem::linearize() {
  // What found the living edges is the start's own: those that died added nothing to it.
  if (!std::exchange(is_start_linearized_, false)) run_linearize(false);
  add_parts();
  LmState state{0.0, 0.0};
  num_seen_ = 0;
  for (const Part& part : parts_) {
    state.cost += part.sums.cost;
    num_seen_ += part.sums.num_seen;
  }
  state.cost += prior_cost(constraints_, priors_state(state_));
  add_priors(constraints_, priors_state(state_),
             {C(), block_starts_.data(), H_.data(), gradient_.data(), point_blocks_.data()});
  columns_.set_poses(state_.poses);
  state.gradient_max_norm = gradient_max_norm();
  if (!has_scales_) set_scales();
  return state;
}

double PatchProblem::gradient_max_norm() const {
  Eigen::VectorXd free = Eigen::VectorXd::Zero(columns_.num_columns());
  for (int i = 0; i < num_images(); ++i) {
    columns_.add_vector(i, gradient_.data() + std::int64_t{i} * C(), free);
  }
  double norm = 0.0;
  for (const double g : free) norm = larger(norm, g);
  for (std::size_t p = 0; p < point_blocks_.size(); ++p) {
    if (held_[p] != 0) continue;
    for (int k = 0; k < schur_.point_size; ++k) norm = larger(norm, point_blocks_[p].g[k]);
  }
  return norm;
}

// The diagonal of H over the free columns, in `matrix_`.
void PatchProblem::set_diagonal() {
  matrix_.setZero();
  // images that share intrinsics meet on the diagonal
  const bool off_diagonal = layout_.has_hosts() && columns_.with_intrinsics();
  for (int i = 0; i < num_images(); ++i) {
    const int end = off_diagonal ? num_images() : i + 1;
    for (int k = i; k < end; ++k) {
      columns_.add_block(i, k, H_.data() + (block_starts_[i] + k - i) * C() * C(), matrix_);
    }
  }
}

double PatchProblem::max_diagonal() {
  set_diagonal();
  double largest = 0.0;
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k) largest = std::max(largest, matrix_(k, k));
  for (const PointBlock& block : point_blocks_) {
    for (const int k : kDiagonal) largest = std::max(largest, block.H[k]);
  }
  return largest;
}

void PatchProblem::set_scales() {
  set_diagonal();
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k) {
    column_scales_[k] = lm_column_scale(matrix_(k, k), options_.lm);
  }
  for (std::size_t p = 0; p < point_blocks_.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      point_scales_[3 * p + k] = lm_column_scale(point_blocks_[p].H[kDiagonal[k]], options_.lm);
    }
  }
  has_scales_ = true;
}

void PatchProblem::set_damping(double lambda) {
  set_diagonal();
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k) {
    damping_[k] = lambda * lm_damping(matrix_(k, k), column_scales_[k], options_.lm);
  }
  for (std::size_t p = 0; p < point_blocks_.size(); ++p) {
    for (int k = 0; k < 3; ++k) {
      point_damping_[3 * p + k] = lambda * lm_damping(point_blocks_[p].H[kDiagonal[k]],
                                                      point_scales_[3 * p + k], options_.lm);
    }
  }
}

// S, damped, and the right-hand side, over the free columns, in matrix_ and delta_.
void PatchProblem::form_system() {
  pool_.run(static_cast<int>(parts_.size()), [&](int g) {
    Part& part = parts_[g];
    factor_points(point_blocks_.data(), point_damping_.data(), held_.data(), schur_.point_size,
                  part_points_[g], part_points_[g + 1], factors_.data());
    std::fill(part.S.begin(), part.S.end(), 0.0);
    std::fill(part.rhs.begin(), part.rhs.end(), 0.0);
    eliminate_points(schur_, part_points_[g], part_points_[g + 1], part.S.data(), part.rhs.data());
  });
  S_ = H_;
  for (std::size_t k = 0; k < rhs_.size(); ++k) rhs_[k] = -gradient_[k];
  for (const Part& part : parts_) {
    add_to(part.S, S_);
    add_to(part.rhs, rhs_);
  }
  matrix_.setZero();
  delta_.setZero();
  for (int i = 0; i < num_images(); ++i) {
    columns_.add_vector(i, rhs_.data() + std::int64_t{i} * C(), delta_);
    for (int k = i; k < num_images(); ++k) {
      columns_.add_block(i, k, S_.data() + (block_starts_[i] + k - i) * C() * C(), matrix_);
    }
  }
  for (Eigen::Index k = 0; k < matrix_.rows(); ++k) matrix_(k, k) += damping_[k];
}

LmSolve PatchProblem::solve(double lambda, bool /*tight*/) {  // always exact
  LmSolve result;
  result.interrupted = interrupted_ && interrupted_();
  if (result.interrupted) return result;
  set_damping(lambda);
  form_system();
  const int n = columns_.num_columns();
  if (!factor_cholesky(matrix_.data(), n, pool_)) return result;
  solve_dense(matrix_.data(), n, delta_.data());
  result.solved = delta_.allFinite();
  columns_.expand(delta_, image_steps_.data());
  return result;
}

// −gᵀδ − ½ δᵀHδ of the images.
double PatchProblem::image_model_decrease() const {
  double decrease = 0.0;
  const std::int64_t size = C();
  for (std::int64_t i = 0; i < num_images(); ++i) {
    const Eigen::Map<const Eigen::VectorXd> step(image_steps_.data() + i * size, size);
    decrease -= step.dot(Eigen::Map<const Eigen::VectorXd>(gradient_.data() + i * size, size));
    for (std::int64_t k = i; k < num_images(); ++k) {
      using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;
      const Eigen::Map<const RowMatrix> block(H_.data() + (block_starts_[i] + k - i) * size * size,
                                              size, size);
      const Eigen::Map<const Eigen::VectorXd> other(image_steps_.data() + k * size, size);
      decrease -= (i == k ? 0.5 : 1.0) * step.dot(block * other);
      if (!layout_.has_hosts()) break;  // the rest is zero
    }
  }
  return decrease;
}

LmTrial PatchProblem::try_step() {
  trial_.poses = state_.poses;
  trial_.brightness = state_.brightness;
  trial_.intrinsics = state_.intrinsics;
  LmTrial trial;
  double squared_step = delta_.squaredNorm();
  double squared_state = 0.0;
  std::vector<bool> moved(static_cast<std::size_t>(state_.intrinsics.rows()), false);
  for (int i = 0; i < num_images(); ++i) {
    const double* step = image_steps_.data() + std::int64_t{i} * C();
    pose_plus(TranslationUpdate::COUPLED, constraints_.poses[i], Eigen::Map<const Vector6>(step),
              trial_.poses[i].q, trial_.poses[i].t);
    trial_.brightness(i, 0) += step[6];
    trial_.brightness(i, 1) += step[7];
    squared_state += 1.0 + state_.poses[i].t.squaredNorm();
    const int row = state_.intrinsics.rows() == 1 ? 0 : i;
    if (C() == kImageColumns || moved[row]) continue;
    moved[row] = true;
    for (int k = 0; k < 4; ++k) trial_.intrinsics(row, k) += step[8 + k];
  }
  set_packets(trial_);
  pool_.run(static_cast<int>(parts_.size()), [&](int g) {
    Part& part = parts_[g];
    part.step = step_points(schur_, image_steps_.data(), state_.points.data(), part_points_[g],
                            part_points_[g + 1], trial_.points.data());
    part.sums = evaluate_points(layout_.arrays(), arrays_of(trial_), part_points_[g],
                                part_points_[g + 1], left_costs());
  });
  trial.cost = prior_cost(constraints_, priors_state(trial_));
  trial.model_decrease = image_model_decrease();
  std::int64_t num_seen = 0;
  for (const Part& part : parts_) {
    trial.cost += part.sums.cost;
    trial.model_decrease += part.step.model_decrease;
    squared_step += part.step.squared_step;
    squared_state += part.step.squared_state;
    num_seen += part.sums.num_seen;
  }
  trial.step_norm = std::sqrt(squared_step);
  trial.state_norm = std::sqrt(squared_state);
  const double kept = (1.0 - options_.max_leaving_share) * static_cast<double>(num_seen_);
  const bool keeps = options_.leaving == LeavingRule::KEEP_COST;
  if (keeps && static_cast<double>(num_seen) < kept) trial.cost = kRefused;
  return trial;
}

void PatchProblem::accept() { std::swap(state_, trial_); }

void PatchProblem::write_back(PatchScene& scene) const {
  for (std::size_t i = 0; i < state_.poses.size(); ++i) scene.poses[i] = state_.poses[i];
  scene.brightness = state_.brightness;
  scene.intrinsics = state_.intrinsics;
  for (std::size_t j = 0; j < layout_.points().size(); ++j) {
    for (int k = 0; k < schur_.point_size; ++k) {
      scene.points(layout_.points()[j], k) = state_.points[3 * j + k];
    }
  }
}

int PatchProblem::num_effective_parameters() const {
  const auto free = std::count(held_.begin(), held_.end(), 0);
  return columns_.num_columns() + static_cast<int>(free) * schur_.point_size;
}

}  // namespace raylign::native
