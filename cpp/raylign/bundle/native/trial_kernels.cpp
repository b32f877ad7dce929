// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/trial_kernels.h"

#include <cmath>

#include "raylign/base/clones.h"
#include "raylign/bundle/native/camera_kinds.h"
#include "raylign/bundle/native/landmark_math.h"
#include "raylign/bundle/native/point_kinds.h"

namespace raylign::native {
namespace {

// Gauss-Newton steps of a point after the joint step, at most.
constexpr int kMaxRefinements = 3;
// A point is worth another one that promises to lower its cost by this share.
constexpr double kWorthwhile = 1e-3;

// A point as its observations see it from given cameras.
struct PointView {
  double cost = 0.0;            // ½ Σ ρ(‖r‖²), NaN when it lies in a camera's plane
  std::int64_t num_behind = 0;  // cameras that it does not lie in front of
  LandmarkBlock block = {};
};

// A homogeneous point beyond infinity is an ordinary point.
template <typename Projection>
RAYLIGN_INLINE bool is_in_front(XyzPoint /*kind*/, const Projection& p) {
  return p.w > 0.0;
}
template <typename Projection>
RAYLIGN_INLINE bool is_in_front(HomogeneousPoint /*kind*/, const Projection& /*p*/) {
  return true;
}

// Far from its model a step may be of any length: a point moves no farther than its distance from
// the first camera. (A step on the sphere has no such freedom.)
RAYLIGN_INLINE void shorten(XyzPoint kind, const double* X, const double* c, double* step) {
  double a[3];
  ray(kind, X, c, a);
  const double ratio2 = dot3(step, step) / dot3(a, a);
  if (!(ratio2 > 1.0)) return;
  for (int k = 0; k < 3; ++k) step[k] /= std::sqrt(ratio2);
}
RAYLIGN_INLINE void shorten(HomogeneousPoint /*kind*/,
                            const double* /*X*/,
                            const double* /*c*/,
                            double* /*step*/) {}

template <typename Point, typename Camera>
RAYLIGN_INLINE double cost_of_point(Point kind,
                                    Camera camera_kind,
                                    const State& state,
                                    std::int64_t j,
                                    const CameraPacket* packets,
                                    const double* X_j) {
  const Observations& observations = state.observations;
  double cost = 0.0;
  for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
    const CameraPacket& camera = packets[observations.camera[q]];
    double P[3];
    transform(kind, camera, X_j, P);
    typename Camera::Projection p;
    if (!project(camera_kind, camera, P, p)) return NAN;
    double r[2];
    residual(camera_kind, camera, p, observations.uv + 2 * q, r);
    const double s = r[0] * r[0] + r[1] * r[1];
    cost += 0.5 * (state.loss == nullptr ? s : state.loss->evaluate(s).rho);
  }
  return cost;
}

template <typename Point, typename Camera>
RAYLIGN_INLINE std::int64_t count_behind(Point kind,
                                         Camera camera_kind,
                                         const Observations& observations,
                                         std::int64_t j,
                                         const CameraPacket* packets,
                                         const double* X_j) {
  std::int64_t count = 0;
  for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
    const CameraPacket& camera = packets[observations.camera[q]];
    double P[3];
    transform(kind, camera, X_j, P);
    typename Camera::Projection p;
    count += project(camera_kind, camera, P, p) && is_in_front(kind, p) ? 0 : 1;
  }
  return count;
}

template <typename Point, typename Camera>
RAYLIGN_INLINE PointView view_point(Point kind,
                                    Camera camera_kind,
                                    const State& state,
                                    std::int64_t j,
                                    const CameraPacket* packets,
                                    const double* X_j) {
  const Observations& observations = state.observations;
  const Householder H = tangent_at(kind, X_j);
  PointView view;
  for (std::int64_t q = observations.starts[j]; q < observations.starts[j + 1]; ++q) {
    const CameraPacket& camera = packets[observations.camera[q]];
    double P[3];
    transform(kind, camera, X_j, P);
    typename Camera::Projection p;
    if (!project(camera_kind, camera, P, p)) {
      view.cost = NAN;
      ++view.num_behind;
      return view;
    }
    view.num_behind += is_in_front(kind, p) ? 0 : 1;
    double r[2];
    residual(camera_kind, camera, p, observations.uv + 2 * q, r);
    ObservationJacobian J;
    jacobian(camera_kind, camera, p, J);
    const double s = r[0] * r[0] + r[1] * r[1];
    view.cost += 0.5 * (state.loss == nullptr ? s : apply_loss(*state.loss, s, J, r));
    double E[6];
    point_rows(kind, H, J.A, camera.c, E);
    add_gradient(E, r, view.block);
    add_hessian(E, view.block);
  }
  return view;
}

// The point X after the joint step, in turn: it follows the cameras that have moved by Gauss-Newton
// steps of its own (variable projection; Ceres' inner iterations), as long as they pay. A point
// that the joint step put behind a camera stays where it was before. Returns the cost; adds to
// `gain` what the steps gained.
template <typename Point, typename Camera>
RAYLIGN_INLINE double refine_point(Point kind,
                                   Camera camera_kind,
                                   const TrialStep& step,
                                   std::int64_t j,
                                   double* X,
                                   double& gain) {
  const State& state = step.state;
  const double* X_before = state.X + std::int64_t{Point::kStride} * j;
  PointView view = view_point(kind, camera_kind, state, j, step.trial_packets, X);
  if (view.num_behind > 0 && view.num_behind > count_behind(kind, camera_kind, state.observations,
                                                            j, state.packets, X_before)) {
    for (int k = 0; k < Point::kStride; ++k) X[k] = X_before[k];
    view = view_point(kind, camera_kind, state, j, step.trial_packets, X);
  }
  const CameraPacket& first_camera =
      step.trial_packets[state.observations.camera[state.observations.starts[j]]];
  const double* W = step.factors[j].W;
  const bool held[3] = {W[0] == 0.0, W[3] == 0.0, W[5] == 0.0};
  if (held[0] && held[1] && held[2]) return view.cost;
  for (int i = 0; i < kMaxRefinements; ++i) {
    const double* H = view.block.H;
    const double diagonal[3] = {H[0], H[3], H[5]};
    const LandmarkFactor factor = factor_block(H, diagonal, held);
    double z[3];
    multiply_transposed(factor.W, view.block.g, z);
    if (!(0.5 * dot3(z, z) > kWorthwhile * view.cost)) break;  // what the step promises
    double delta[3];
    multiply(factor.W, z, delta);
    for (double& d : delta) d = -d;
    shorten(kind, X, first_camera.c, delta);
    double X_next[Point::kStride];
    move_point(kind, tangent_at(kind, X), X, delta, X_next);
    const PointView next = view_point(kind, camera_kind, state, j, step.trial_packets, X_next);
    if (!(next.cost < view.cost) || next.num_behind > view.num_behind) break;
    gain += view.cost - next.cost;
    for (int k = 0; k < Point::kStride; ++k) X[k] = X_next[k];
    view = next;
  }
  return view.cost;
}

template <typename Point, typename Camera>
RAYLIGN_INLINE TrialSums try_points(Point kind,
                                    Camera camera_kind,
                                    const TrialStep& trial,
                                    std::int64_t begin,
                                    std::int64_t end,
                                    double* scratch) {
  const Observations& observations = trial.state.observations;
  const CameraPacket* packets = trial.state.packets;
  TrialSums sums;
  for (std::int64_t j = begin; j < end; ++j) {
    const std::int64_t first = observations.starts[j];
    const std::int64_t last = observations.starts[j + 1];
    const double* X_j = trial.state.X + std::int64_t{Point::kStride} * j;
    double* X_new = trial.X_trial + std::int64_t{Point::kStride} * j;
    const double w = weight(kind, X_j);
    const Householder H = tangent_at(kind, X_j);
    const double* g = trial.blocks[j].g;
    double y[3] = {g[0], g[1], g[2]};  // g + Σ Eᵀ F δ
    for (std::int64_t q = first; q < last; ++q) {
      const std::int32_t i = observations.camera[q];
      const double* d = trial.delta + std::int64_t{i} * kRow;
      const double* c = packets[i].c;
      double a[3];
      ray(kind, X_j, c, a);
      double moved[3];  // Fδ = A (ω × a − w δc) + I δ(f, k1, k2)
      cross(d, a, moved);
      for (int k = 0; k < 3; ++k) moved[k] -= w * d[3 + k];
      const ObservationJacobian J_q = load(trial.J, q);
      double* v = scratch + 2 * (q - first);
      v[0] = dot3(J_q.A, moved) + dot3(J_q.I, d + 6);
      v[1] = dot3(J_q.A + 3, moved) + dot3(J_q.I + 3, d + 6);
      double E[6];
      point_rows(kind, H, J_q.A, c, E);
      for (int k = 0; k < 3; ++k) y[k] += E[k] * v[0] + E[3 + k] * v[1];
    }
    const double* W = trial.factors[j].W;
    double z[3];
    double step[3];
    multiply_transposed(W, y, z);
    multiply(W, z, step);
    const bool moves = W[0] != 0.0 || W[3] != 0.0 || W[5] != 0.0;
    for (int k = 0; k < 3; ++k) {
      step[k] = -step[k];
      sums.squared_step += step[k] * step[k];
    }
    for (int k = 0; k < Point::kStride; ++k) sums.squared_state += moves ? X_j[k] * X_j[k] : 0.0;
    move_point(kind, H, X_j, step, X_new);
    sums.model_decrease -= dot3(g, step);
    for (std::int64_t q = first; q < last; ++q) {
      const ObservationJacobian J_q = load(trial.J, q);
      const double* v = scratch + 2 * (q - first);
      double E[6];
      point_rows(kind, H, J_q.A, packets[observations.camera[q]].c, E);
      const double u0 = v[0] + dot3(E, step);
      const double u1 = v[1] + dot3(E + 3, step);
      sums.model_decrease -= 0.5 * (u0 * u0 + u1 * u1);
    }
    sums.cost += trial.refine_points
                     ? refine_point(kind, camera_kind, trial, j, X_new, sums.model_decrease)
                     : cost_of_point(kind, camera_kind, trial.state, j, trial.trial_packets, X_new);
  }
  return sums;
}

// The one switch over cameras.
template <typename Point>
RAYLIGN_INLINE TrialSums try_cameras(
    Point kind, const TrialStep& step, std::int64_t begin, std::int64_t end, double* scratch) {
  switch (step.state.observations.camera_kind) {
    case CameraKind::PINHOLE:
      return try_points(kind, PinholeKind{}, step, begin, end, scratch);
    case CameraKind::RADTAN:
      return try_points(kind, RadtanKind{}, step, begin, end, scratch);
    case CameraKind::BAL:
      break;
  }
  return try_points(kind, BalKind{}, step, begin, end, scratch);
}

}  // namespace

RAYLIGN_CLONES TrialSums try_landmarks(const TrialStep& step,
                                       std::int64_t begin,
                                       std::int64_t end,
                                       double* scratch) {
  if (step.state.observations.point_kind == PointKind::HOMOGENEOUS) {
    return try_cameras(HomogeneousPoint{}, step, begin, end, scratch);
  }
  return try_cameras(XyzPoint{}, step, begin, end, scratch);
}

}  // namespace raylign::native
