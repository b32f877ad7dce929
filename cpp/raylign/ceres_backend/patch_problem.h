// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <deque>
#include <string>

#include "raylign/ceres_backend/ceres_problem.h"
#include "raylign/ceres_backend/patch_costs.h"
#include "raylign/ceres_backend/patch_edges.h"
#include "raylign/ceres_backend/patch_priors.h"
#include "raylign/ceres_backend/patch_state.h"
#include "raylign/ceres_backend/robust_loss.h"

namespace raylign::ceres_backend {

/// A PatchScene as Ceres sees it: one residual block per edge (LossScope::PATCH) or per pixel
/// (PIXEL), and the priors.
class PatchProblem final : public CeresProblem {
 public:
  /// `scene` is at whatever state Ceres evaluated last; write_best puts things right.
  PatchProblem(PatchScene& scene,
               const PatchConstraints& constraints,
               const PatchSolveOptions& options);

  /// Empty when Ceres may have it: it aborts the process on NaN.
  std::string invalid_start() const;

  void save_state() override { state_.save(); }
  void restore_saved_state() override { state_.restore_saved(); }
  /// Writes what the blocks hold into the scene.
  void write_best() { state_.write(scene_); }

 private:
  void check_size() const;
  void add_edge(std::int64_t p, std::int64_t e);
  void add_block(PatchSlot slot, double* block, PatchBlocks& blocks);
  void add_priors();
  void add_linear_prior(const Eigen::VectorXd& value,
                        const Eigen::MatrixXd& information,
                        double* block);
  void register_blocks();
  void apply_constants();

  PatchScene& scene_;
  const PatchConstraints& held_;
  const PatchSolveOptions options_;
  PatchState state_;
  PatchEdges edges_;
  RobustLoss loss_;
  std::vector<double*> blocks_of_edge_;
  // deques: Ceres keeps the addresses, and cost functions cannot move
  std::deque<PatchCost> patch_costs_;
  std::deque<PatchPixelCost> pixel_costs_;
  std::deque<PosePriorCost> pose_priors_;
  std::deque<LinearPriorCost> linear_priors_;
};

}  // namespace raylign::ceres_backend
