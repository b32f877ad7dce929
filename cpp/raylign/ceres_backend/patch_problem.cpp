// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_problem.h"

#include <limits>
#include <string>

#include "raylign/base/error.h"
#include "raylign/ceres_backend/pose_manifold.h"

namespace raylign::ceres_backend {
namespace {

// Two poses, two brightnesses, two rows of intrinsics and a point, in one pixel's row.
constexpr double kMaxColumns = 2.0 * (7 + 2 + 4) + 3.0;

}  // namespace

PatchProblem::PatchProblem(PatchScene& scene,
                           const PatchConstraints& constraints,
                           const PatchSolveOptions& options)
    : scene_(scene),
      held_(constraints),
      options_(options),
      state_(scene),
      edges_(scene, state_, options),
      loss_(options.loss) {
  check_size();
  ceres::Problem::Options ceres_options = problem_options();
  ceres_options.evaluation_callback = &edges_;
  ceres_ = std::make_unique<ceres::Problem>(ceres_options);
  for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
    for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
      if (edges_.is_alive(e)) add_edge(p, e);
    }
  }
  add_priors();
  register_blocks();
  apply_constants();
  // Blocks without a free parameter are evaluated before Ceres announces an evaluation.
  edges_.PrepareForEvaluation(false, true);
}

std::string PatchProblem::invalid_start() const {
  for (const double* block : blocks_) {
    if (!Eigen::Map<const Eigen::VectorXd>(block, ceres_->ParameterBlockSize(block)).allFinite()) {
      return "a pose, point, brightness or camera at the start is not finite";
    }
  }
  return edges_.invalid_start();
}

void PatchProblem::check_size() const {
  const double limit = std::numeric_limits<int>::max() / (kMaxColumns * scene_.pattern.size());
  if (static_cast<double>(scene_.num_edges()) <= limit) return;
  throw OptionsError("backend ceres holds at most " +
                     std::to_string(static_cast<std::int64_t>(limit)) + " edges, got " +
                     std::to_string(scene_.num_edges()));
}

void PatchProblem::add_block(PatchSlot slot, double* block, PatchBlocks& blocks) {
  blocks.slots[static_cast<std::size_t>(blocks.count++)] = slot;
  blocks_of_edge_.push_back(block);
}

// Pose and point are always there, so that no residual block is without parameters; the others
// where they may move.
void PatchProblem::add_edge(std::int64_t p, std::int64_t e) {
  const PatchEdge& edge = scene_.edges[e];
  const std::int32_t j = edge.image;
  const std::int32_t h = scene_.hosts[p];
  const std::int64_t row = scene_.intrinsics_row(j);
  const bool has_other_host = h >= 0 && h != j;  // else its brightness cancels
  PatchBlocks blocks{p, e, 0, {}};
  blocks_of_edge_.clear();
  add_block(PatchSlot::POSE, state_.pose(j), blocks);
  add_block(PatchSlot::POINT, state_.point(p), blocks);
  if (h != j && !all_held(held_.brightness[j])) {
    add_block(PatchSlot::BRIGHTNESS, state_.brightness(j), blocks);
  }
  if (has_other_host && !all_held(held_.brightness[h])) {
    add_block(PatchSlot::HOST_BRIGHTNESS, state_.brightness(h), blocks);
  }
  if (!all_held(held_.intrinsics[row])) {
    add_block(PatchSlot::INTRINSICS, state_.intrinsics(row), blocks);
  }
  if (scene_.inverse_depth && has_other_host) {
    const std::int64_t host_row = scene_.intrinsics_row(h);
    if (!held_.poses[h].all()) add_block(PatchSlot::HOST_POSE, state_.pose(h), blocks);
    if (host_row != row && !all_held(held_.intrinsics[host_row])) {
      add_block(PatchSlot::HOST_INTRINSICS, state_.intrinsics(host_row), blocks);
    }
  }
  ceres::LossFunction* loss = options_.loss.type == LossType::TRIVIAL ? nullptr : &loss_;
  if (options_.scope == LossScope::PATCH) {
    patch_costs_.emplace_back(edges_, blocks);
    ceres_->AddResidualBlock(&patch_costs_.back(), loss, blocks_of_edge_);
    return;
  }
  for (int n = 0; n < scene_.pattern.size(); ++n) {
    if ((edge.mask >> n & 1u) == 0u) continue;
    pixel_costs_.emplace_back(edges_, blocks, n);
    ceres_->AddResidualBlock(&pixel_costs_.back(), loss, blocks_of_edge_);
  }
}

void PatchProblem::add_linear_prior(const Eigen::VectorXd& value,
                                    const Eigen::MatrixXd& information,
                                    double* block) {
  ceres_->AddResidualBlock(&linear_priors_.emplace_back(value, information), nullptr, block);
}

void PatchProblem::add_priors() {
  for (const PosePrior& prior : held_.pose_priors) {
    ceres_->AddResidualBlock(&pose_priors_.emplace_back(prior), nullptr, state_.pose(prior.image));
  }
  const int size = state_.point_size();
  for (const PatchPointPrior& prior : held_.point_priors) {
    add_linear_prior(prior.value.head(size), prior.information.topLeftCorner(size, size),
                     state_.point(prior.point));
  }
  if (held_.weight_a == 0.0 && held_.weight_b == 0.0) return;
  for (std::int64_t i = 0; i < scene_.num_images(); ++i) {
    const auto& held = held_.brightness[i];
    if (all_held(held)) continue;
    const Vector2 weights(held[0] ? 0.0 : held_.weight_a, held[1] ? 0.0 : held_.weight_b);
    add_linear_prior(Vector2::Zero(), weights.asDiagonal().toDenseMatrix(), state_.brightness(i));
  }
}

void PatchProblem::register_blocks() {
  const auto add = [&](double* block, std::vector<double*>& blocks) {
    if (ceres_->HasParameterBlock(block)) blocks.push_back(block);
  };
  for (std::int64_t i = 0; i < scene_.num_images(); ++i) {
    add(state_.pose(i), blocks_);
    add(state_.brightness(i), blocks_);
  }
  for (std::int64_t row = 0; row < scene_.intrinsics.rows(); ++row) {
    add(state_.intrinsics(row), blocks_);
  }
  for (std::int64_t p = 0; p < scene_.num_points(); ++p) add(state_.point(p), point_blocks_);
  blocks_.insert(blocks_.end(), point_blocks_.begin(), point_blocks_.end());
}

void PatchProblem::apply_constants() {
  ceres::Manifold* free_pose = nullptr;  // one object serves every free image
  for (std::int64_t i = 0; i < scene_.num_images(); ++i) {
    if (ceres_->HasParameterBlock(state_.brightness(i))) {
      hold_coordinates<2>(*ceres_, state_.brightness(i), held_.brightness[i]);
    }
    double* pose = state_.pose(i);
    if (!ceres_->HasParameterBlock(pose)) continue;
    const PoseMask& mask = held_.poses[i];
    if (mask.all()) {
      ceres_->SetParameterBlockConstant(pose);
    } else if (mask.any()) {
      ceres_->SetManifold(pose, new PoseManifold(TranslationUpdate::COUPLED, mask));
    } else {
      if (free_pose == nullptr) free_pose = new PoseManifold(TranslationUpdate::COUPLED);
      ceres_->SetManifold(pose, free_pose);
    }
  }
  for (std::int64_t row = 0; row < scene_.intrinsics.rows(); ++row) {
    if (ceres_->HasParameterBlock(state_.intrinsics(row))) {
      hold_coordinates<4>(*ceres_, state_.intrinsics(row), held_.intrinsics[row]);
    }
  }
  if (held_.points.empty()) return;
  for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
    if (held_.points[p] && ceres_->HasParameterBlock(state_.point(p))) {
      ceres_->SetParameterBlockConstant(state_.point(p));
    }
  }
}

}  // namespace raylign::ceres_backend
