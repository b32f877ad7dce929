// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_priors.h"

#include "raylign/geometry/se3.h"

namespace raylign::native {
namespace {

Vector6 distance(const PosePrior& prior, const PriorState& state) {
  return se3_log(state.poses[prior.image].matrix() * se3_inverse(prior.T_cw));
}

Vector3 distance(const PatchPointPrior& prior, const PriorState& state) {
  return Eigen::Map<const Vector3>(&state.points[3 * prior.point]) - prior.value;
}

void add_brightness(const PatchConstraints& constraints,
                    const PriorState& state,
                    const PriorTargets& targets) {
  const int C = targets.num_columns;
  const double weights[2] = {constraints.weight_a, constraints.weight_b};
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    double* H = targets.H + targets.block_starts[i] * C * C;
    double* g = targets.gradient + static_cast<std::int64_t>(i) * C;
    for (int k = 0; k < 2; ++k) {
      if (constraints.brightness[i][k]) continue;
      H[(6 + k) * C + 6 + k] += weights[k];
      g[6 + k] += weights[k] * state.brightness(static_cast<Eigen::Index>(i), k);
    }
  }
}

void add_pose(const PosePrior& prior, const PriorState& state, const PriorTargets& targets) {
  const int C = targets.num_columns;
  const Vector6 xi = distance(prior, state);
  const Matrix6 J = se3_left_jacobian_inverse(xi);
  const Matrix6 H = J.transpose() * prior.information * J;
  const Vector6 gradient = J.transpose() * prior.information * xi;
  double* block = targets.H + targets.block_starts[prior.image] * C * C;
  for (int r = 0; r < 6; ++r) {
    for (int k = 0; k < 6; ++k) block[r * C + k] += H(r, k);
    targets.gradient[std::int64_t{prior.image} * C + r] += gradient[r];
  }
}

void add_point(const PatchPointPrior& prior, const PriorState& state, const PriorTargets& targets) {
  PointBlock& block = targets.points[prior.point];
  const Vector3 d = distance(prior, state);
  const int size = state.inverse_depth ? 1 : 3;
  int n = 0;
  for (int r = 0; r < 3; ++r) {
    for (int k = r; k < 3; ++k, ++n) {
      if (k < size) block.H[n] += prior.information(r, k);
    }
    for (int k = 0; k < size && r < size; ++k) block.g[r] += prior.information(r, k) * d[k];
  }
}

}  // namespace

double prior_cost(const PatchConstraints& constraints, const PriorState& state) {
  double twice = 0.0;
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    const auto row = static_cast<Eigen::Index>(i);
    const double a = state.brightness(row, 0);
    const double b = state.brightness(row, 1);
    if (!constraints.brightness[i][0]) twice += constraints.weight_a * a * a;
    if (!constraints.brightness[i][1]) twice += constraints.weight_b * b * b;
  }
  for (const PosePrior& prior : constraints.pose_priors) {
    const Vector6 xi = distance(prior, state);
    twice += xi.dot(prior.information * xi);
  }
  for (const PatchPointPrior& prior : constraints.point_priors) {
    const Vector3 d = distance(prior, state);
    twice +=
        state.inverse_depth ? prior.information(0, 0) * d[0] * d[0] : d.dot(prior.information * d);
  }
  return 0.5 * twice;
}

void add_priors(const PatchConstraints& constraints,
                const PriorState& state,
                const PriorTargets& targets) {
  add_brightness(constraints, state, targets);
  for (const PosePrior& prior : constraints.pose_priors) add_pose(prior, state, targets);
  for (const PatchPointPrior& prior : constraints.point_priors) add_point(prior, state, targets);
}

}  // namespace raylign::native
