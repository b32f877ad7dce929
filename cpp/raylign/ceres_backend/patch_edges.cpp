// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_edges.h"

#include <algorithm>
#include <cmath>

namespace raylign::ceres_backend {

PatchEdges::PatchEdges(PatchScene& scene, const PatchState& state, const PatchSolveOptions& options)
    : scene_(scene),
      state_(state),
      options_(options),
      keeps_(options.leaving == LeavingRule::KEEP_COST),
      alive_(static_cast<std::size_t>(scene.num_edges()), 1) {
  if (options_.scope == LossScope::PIXEL) {
    table_.resize(static_cast<std::size_t>(scene_.num_edges()));
  }
  evaluate_start();
}

void PatchEdges::evaluate_start() {
  const int n = scene_.pattern.size();
  const auto num_edges = static_cast<std::size_t>(scene_.num_edges());
  if (keeps_) {
    start_residuals_.assign(num_edges * static_cast<std::size_t>(n), 0.0);
  } else {
    was_out_.assign(num_edges, 0);
  }
  for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
    for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
      const EdgeSample sample = evaluate_edge(scene_, p, scene_.edges[e]);
      if (!sample.is_seen) {
        (keeps_ ? alive_[e] : was_out_[e]) = keeps_ ? 0 : 1;
        continue;
      }
      const double* r = sample.residual.data();
      if (!std::all_of(r, r + n, [](double x) { return std::isfinite(x); })) {
        invalid_start_ = "the start has a residual that is not finite, of point " +
                         std::to_string(p) + " in image " + std::to_string(scene_.edges[e].image);
      }
      if (keeps_) std::copy(r, r + n, &start_residuals_[e * n]);
    }
  }
  num_alive_ = std::count(alive_.begin(), alive_.end(), 1);
}

void PatchEdges::PrepareForEvaluation(bool evaluate_jacobians, bool /*new_evaluation_point*/) {
  state_.write(scene_);
  if (counted_current_) {
    const auto num_seen = static_cast<double>(num_alive_ - num_left_);
    const auto kept =
        static_cast<std::int64_t>(std::ceil((1.0 - options_.max_leaving_share) * num_seen));
    max_left_ = num_alive_ - kept;
  }
  counted_current_ = evaluate_jacobians;
  refuses_ = keeps_ && !evaluate_jacobians;
  num_left_ = 0;
  if (table_.empty()) return;
  for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
    for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
      if (!is_alive(e)) continue;
      evaluate(p, e, evaluate_jacobians, table_[e]);
      if (!table_[e].sample.is_seen) note_left(e);
    }
  }
}

void PatchEdges::evaluate(std::int64_t point,
                          std::int64_t edge,
                          bool with_motion,
                          EvaluatedEdge& evaluated) const {
  evaluated.sample = evaluate_edge(scene_, point, scene_.edges[edge]);
  if (!with_motion || !evaluated.sample.is_seen) return;
  evaluated.motion = edge_motion(scene_, point, scene_.edges[edge], evaluated.sample);
}

bool PatchEdges::note_left(std::int64_t edge) const {
  if (!keeps_) was_out_[edge] = 1;
  const std::int64_t count = ++num_left_;
  return !refuses_ || count <= max_left_;
}

}  // namespace raylign::ceres_backend
