// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/engine.h"

#include <algorithm>

#include "raylign/base/error.h"
#include "raylign/photometric/native/solve.h"

namespace raylign::photometric {
namespace {

// Σ w g gᵀ over the pixels of an edge that count.
Eigen::Matrix2d gradient_tensor(const PatchScene& scene,
                                const PatchEdge& edge,
                                const EdgeSample& sample,
                                const PatchSolveOptions& options) {
  double squared_norm = 0.0;
  for (int n = 0; n < scene.pattern.size(); ++n) {
    squared_norm += sample.residual[n] * sample.residual[n];
  }
  Eigen::Matrix2d G = Eigen::Matrix2d::Zero();
  for (int n = 0; n < scene.pattern.size(); ++n) {
    if (!sample.counts(edge, n)) continue;
    const double s =
        options.scope == LossScope::PATCH ? squared_norm : sample.residual[n] * sample.residual[n];
    const Vector2 g(sample.gradient[n][0], sample.gradient[n][1]);
    G += options.loss.evaluate(s).d_rho * g * g.transpose();
  }
  return G;
}

}  // namespace

Summary solve_scene(PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options,
                    Backend backend,
                    const IterationCallback& callback,
                    const InterruptCheck& interrupted) {
  if (scene.num_edges() == 0) return nothing_to_adjust(to_string(backend));
  if (backend == Backend::NATIVE) {
    return native::solve_patches(scene, constraints, options, callback, interrupted);
  }
  throw OptionsError("PhotometricOptions.backend must be NATIVE, got ceres");
}

double max_hessian_diagonal(const PatchScene& scene,
                            const PatchConstraints& constraints,
                            const PatchSolveOptions& options) {
  std::vector<Vector6> poses(scene.poses.size(), Vector6::Zero());
  double largest = 0.0;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    Vector3 point = Vector3::Zero();
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      const PatchEdge& edge = scene.edges[e];
      const EdgeSample sample = evaluate_edge(scene, p, edge);
      if (!sample.is_seen) continue;
      const EdgeMotion motion = edge_motion(scene, p, edge, sample);
      const Eigen::Matrix2d G = gradient_tensor(scene, edge, sample, options);
      poses[edge.image] += (motion.pose.transpose() * G * motion.pose).diagonal();
      point += (motion.point.transpose() * G * motion.point).diagonal();
    }
    if (!constraints.points.empty() && constraints.points[p]) continue;
    largest = std::max(largest, point.maxCoeff());
  }
  for (std::size_t i = 0; i < poses.size(); ++i) {
    for (int k = 0; k < 6; ++k) {
      if (constraints.poses[i].is_free(k)) largest = std::max(largest, poses[i][k]);
    }
  }
  return largest;
}

}  // namespace raylign::photometric
