// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <ceres/evaluation_callback.h>

#include <atomic>
#include <cstdint>
#include <string>
#include <vector>

#include "raylign/ceres_backend/patch_state.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"

namespace raylign::ceres_backend {

/// An edge at the state that Ceres evaluates.
struct EvaluatedEdge {
  EdgeSample sample;
  EdgeMotion motion;  ///< set when the edge is seen and Jacobians are wanted
};

/// What all cost functions of a patch problem share: the scene at the state that Ceres evaluates,
/// and the rules for edges that are out of view. Ceres announces each evaluation, so the scene
/// follows its parameter blocks and cost functions need not read them.
class PatchEdges final : public ceres::EvaluationCallback {
 public:
  /// `scene` follows `state` from now on. Both must outlive this object.
  PatchEdges(PatchScene& scene, const PatchState& state, const PatchSolveOptions& options);

  /// Empty when all residuals at the start are finite; else says which is not.
  const std::string& invalid_start() const { return invalid_start_; }
  /// Takes part in the solve: KEEP_COST asks that it is seen at the start.
  bool is_alive(std::int64_t edge) const { return alive_[static_cast<std::size_t>(edge)] != 0; }
  std::int64_t num_alive() const { return num_alive_; }

  void PrepareForEvaluation(bool evaluate_jacobians, bool new_evaluation_point) override;

  const PatchScene& scene() const { return scene_; }
  /// Of PIXEL, all edges are evaluated once, before their pixels are asked for.
  const EvaluatedEdge& evaluated(std::int64_t edge) const { return table_[edge]; }
  void evaluate(std::int64_t point,
                std::int64_t edge,
                bool with_motion,
                EvaluatedEdge& evaluated) const;
  /// What pixel n of an edge has for a residual that is not seen now.
  double left_residual(std::int64_t edge, int n) const {
    return keeps_ ? start_residuals_[edge * scene_.pattern.size() + n] : 0.0;
  }
  /// Counts an edge out of view; false when they are too many for a step.
  bool note_left(std::int64_t edge) const;
  /// An edge in view pulls at the state; of ZERO, only until it was out of view once, be it in a
  /// step that was refused.
  bool pulls(std::int64_t edge) const { return keeps_ || was_out_[edge] == 0; }
  /// Of PIXEL: whether all edges together leave a step acceptable.
  bool is_acceptable() const { return !refuses_ || num_left_ <= max_left_; }

 private:
  void evaluate_start();

  PatchScene& scene_;
  const PatchState& state_;
  const PatchSolveOptions options_;
  const bool keeps_;
  std::vector<unsigned char> alive_;            // (E,)
  std::vector<double> start_residuals_;         // (E, n) of KEEP_COST
  std::vector<EvaluatedEdge> table_;            // (E,) of PIXEL
  mutable std::vector<unsigned char> was_out_;  // (E,) of ZERO
  std::string invalid_start_;
  std::int64_t num_alive_ = 0;
  // Edges out of view, counted during an evaluation; the limit comes from the last one with
  // Jacobians, which is at the state that a step starts from.
  mutable std::atomic<std::int64_t> num_left_{0};
  std::int64_t max_left_ = 0;
  bool counted_current_ = false;
  bool refuses_ = false;
};

}  // namespace raylign::ceres_backend
