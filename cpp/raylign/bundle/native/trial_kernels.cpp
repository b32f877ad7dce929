// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/trial_kernels.h"

#include "raylign/base/clones.h"
#include "raylign/bundle/native/landmark_group.h"

namespace raylign::native {
namespace {

// Gauss-Newton steps of a point after the joint step, at most.
constexpr int kMaxRefinements = 3;
// A point is worth another one that promises to lower its cost by this share.
constexpr double kWorthwhile = 1e-3;

// Four points as their observations see them from given cameras.
struct PointView {
  D4 cost;    // ½ Σ ρ(‖r‖²), NaN when it lies in a camera's plane
  D4 behind;  // how many cameras it does not lie in front of
  LandmarkBlockOf<D4> block;
};

// Far from its model a step may be of any length: a point moves no farther than its distance from
// the first camera. (A step on the sphere has no such freedom.)
RAYLIGN_INLINE void shorten(XyzPoint kind, const D4* X, const D4* c, D4* step) {
  D4 a[3];
  ray(kind, X, c, a);
  const D4 ratio2 = dot3(step, step) / dot3(a, a);
  if (!any(ratio2 > 1.0)) return;
  D4 ratio;
  square_root(ratio2, ratio);
  for (int k = 0; k < 3; ++k) step[k] = ratio2 > 1.0 ? step[k] / ratio : step[k];
}
RAYLIGN_INLINE void shorten(HomogeneousPoint /*kind*/,
                            const D4* /*X*/,
                            const D4* /*c*/,
                            D4* /*step*/) {}

// Without kJacobian: without the block.
template <bool kJacobian, typename Point, typename Camera>
RAYLIGN_INLINE void view_points(Point kind,
                                Camera camera_kind,
                                const State& state,
                                const Group& group,
                                const CameraPacket* packets,
                                const D4* X,
                                PointView& view) {
  const auto H = tangent_at(kind, X);
  const PointView nothing = {};
  view = nothing;
  for (std::int64_t step = 0; step < group.longest; ++step) {
    std::int64_t q[4];
    observations_at(group, step, q);
    CameraLanes camera;
    gather_cameras(camera_kind, packets, state.observations.camera, q, camera);
    Sight sight;
    look<kJacobian>(kind, camera_kind, state, group, step, q, camera, X, sight);
    view.cost += 0.5 * sight.rho;
    view.behind += sight.behind;
    if (!kJacobian) continue;
    D4 E[6];
    point_rows(kind, H, sight.J.A, camera.c, E);
    add_gradient(E, sight.r, view.block);
    add_hessian(E, view.block);
  }
}

RAYLIGN_INLINE void choose(const M4& mask, const D4& chosen, D4& kept) {
  kept = mask ? chosen : kept;
}

RAYLIGN_INLINE void choose(const M4& mask, const PointView& chosen, PointView& kept) {
  choose(mask, chosen.cost, kept.cost);
  choose(mask, chosen.behind, kept.behind);
  for (int k = 0; k < 6; ++k) choose(mask, chosen.block.H[k], kept.block.H[k]);
  for (int k = 0; k < 3; ++k) choose(mask, chosen.block.g[k], kept.block.g[k]);
}

// Points that the joint step put behind a camera go back to where they were; whether there are any.
template <typename Point, typename Camera>
RAYLIGN_INLINE bool retreat(Point kind,
                            Camera camera_kind,
                            const State& state,
                            const Group& group,
                            const D4& behind,
                            D4* X) {
  if (!any(behind > 0.0)) return false;
  D4 X_before[Point::kStride];
  gather_points(kind, group, state.X, X_before);
  PointView before;
  view_points<false>(kind, camera_kind, state, group, state.packets, X_before, before);
  const M4 is_worse = behind > before.behind;
  for (int k = 0; k < Point::kStride; ++k) choose(is_worse, X_before[k], X[k]);
  return any(is_worse);
}

// The Gauss-Newton step of a point by itself and the decrease that it promises.
template <typename Point>
RAYLIGN_INLINE void point_step(Point kind,
                               const PointView& view,
                               const M4* held,
                               const D4* X,
                               const D4* c,
                               D4* step,
                               D4& promise) {
  const D4* H = view.block.H;
  const D4 diagonal[3] = {H[0], H[3], H[5]};
  D4 W[6];
  factor_block(H, diagonal, held, W);
  D4 z[3];
  multiply_transposed(W, view.block.g, z);
  promise = 0.5 * dot3(z, z);
  multiply(W, z, step);
  for (int k = 0; k < 3; ++k) step[k] = -step[k];
  shorten(kind, X, c, step);
}

// The points X after the joint step, in turn: they follow the cameras that have moved by
// Gauss-Newton steps of their own (variable projection; Ceres' inner iterations), as long as they
// pay. A point that the joint step put behind a camera stays where it was before. Adds to `gain`
// what the steps gained.
template <typename Point, typename Camera>
RAYLIGN_INLINE void refine_points(Point kind,
                                  Camera camera_kind,
                                  const TrialStep& trial,
                                  const Group& group,
                                  const D4* W,
                                  D4* X,
                                  D4& cost,
                                  D4& gain) {
  const D4 zero = {};
  const M4 held[3] = {W[0] == zero, W[3] == zero, W[5] == zero};
  D4 live;
  live_lanes(group, live);
  D4 c[3];  // of the first cameras
  const double* centers[4];
  for (int lane = 0; lane < 4; ++lane) {
    centers[lane] = trial.trial_packets[trial.state.observations.camera[group.first[lane]]].c;
  }
  gather<3>(centers, c);
  D4 X_next[Point::kStride];
  for (int k = 0; k < Point::kStride; ++k) X_next[k] = X[k];
  M4 goes_on = (live > 0.0) & ~(held[0] & held[1] & held[2]);
  PointView view;
  int num_steps = 0;
  for (int look = 0;; ++look) {
    PointView next;
    view_points<true>(kind, camera_kind, trial.state, group, trial.trial_packets, X_next, next);
    if (look == 0 && retreat(kind, camera_kind, trial.state, group, next.behind, X_next)) continue;
    if (num_steps == 0) {
      view = next;
      for (int k = 0; k < Point::kStride; ++k) X[k] = X_next[k];
    } else {
      goes_on = goes_on & (next.cost < view.cost) & ~(next.behind > view.behind);
      gain += goes_on ? view.cost - next.cost : zero;
      for (int k = 0; k < Point::kStride; ++k) choose(goes_on, X_next[k], X[k]);
      choose(goes_on, next, view);
    }
    if (num_steps++ == kMaxRefinements) break;
    D4 step[3];
    D4 promise;
    point_step(kind, view, held, X, c, step, promise);
    goes_on = goes_on & (promise > kWorthwhile * view.cost);
    if (!any(goes_on)) break;
    move_point(kind, tangent_at(kind, X), X, step, X_next);
  }
  cost = view.cost;
}

// Fδ of an observation and its E: what the substitution needs of it.
struct alignas(32) Moved {
  D4 v[2];
  D4 E[6];
};
static_assert(sizeof(Moved) == sizeof(TrialScratch) && alignof(Moved) == alignof(TrialScratch));

// TrialSums, lane by lane.
struct GroupSums {
  D4 cost = {};
  D4 model_decrease = {};
  D4 squared_step = {};
  D4 squared_state = {};
};

// y = g + Σ Eᵀ F δ.
template <typename Point, typename Camera>
RAYLIGN_INLINE void substitute_cameras(Point kind,
                                       Camera camera_kind,
                                       const TrialStep& trial,
                                       const Group& group,
                                       const D4* X,
                                       Moved* moved,
                                       D4* y) {
  const Observations& observations = trial.state.observations;
  const D4 w = weight(kind, X);
  const auto H = tangent_at(kind, X);
  for (std::int64_t step = 0; step < group.longest; ++step) {
    std::int64_t q[4];
    observations_at(group, step, q);
    CameraLanes camera;
    gather_cameras(camera_kind, trial.state.packets, observations.camera, q, camera);
    JacobianOf<D4> J;
    jacobians_at(kind, camera_kind, trial.J, q, camera, X, J);
    const double* rows[4];
    for (int lane = 0; lane < 4; ++lane) {
      rows[lane] = trial.delta + std::int64_t{observations.camera[q[lane]]} * kRow;
    }
    D4 d[9];
    gather<9>(rows, d);
    D4 a[3];
    ray(kind, X, camera.c, a);
    D4 turned[3];  // Fδ = A (ω × a − w δc) + I δ(f, k1, k2)
    cross(d, a, turned);
    for (int k = 0; k < 3; ++k) turned[k] -= w * d[3 + k];
    Moved& out = moved[step];
    out.v[0] = dot3(J.A, turned) + dot3(J.I, d + 6);
    out.v[1] = dot3(J.A + 3, turned) + dot3(J.I + 3, d + 6);
    point_rows(kind, H, J.A, camera.c, out.E);
    if (!group.is_whole(step)) {
      D4 live;
      live_lanes(group, step, live);
      for (D4& v : out.v) v *= live;
      for (D4& e : out.E) e *= live;
    }
    for (int k = 0; k < 3; ++k) y[k] += out.E[k] * out.v[0] + out.E[3 + k] * out.v[1];
  }
}

template <typename Point, typename Camera>
RAYLIGN_INLINE void try_group(Point kind,
                              Camera camera_kind,
                              const TrialStep& trial,
                              const Group& group,
                              Moved* moved,
                              GroupSums& sums) {
  const D4 zero = {};
  D4 X[Point::kStride];
  gather_points(kind, group, trial.state.X, X);
  D4 block[9];
  gather_records<9>(group, trial.blocks, block);
  const D4* g = block + 6;
  D4 W[6];
  gather_records<6>(group, trial.factors, W);
  D4 y[3] = {g[0], g[1], g[2]};
  substitute_cameras(kind, camera_kind, trial, group, X, moved, y);
  D4 z[3];
  D4 step[3];
  multiply_transposed(W, y, z);
  multiply(W, z, step);
  for (D4& s : step) s = -s;
  D4 live;
  live_lanes(group, live);
  D4 decrease = -dot3(g, step);
  for (std::int64_t k = 0; k < group.longest; ++k) {
    const D4 u0 = moved[k].v[0] + dot3(moved[k].E, step);
    const D4 u1 = moved[k].v[1] + dot3(moved[k].E + 3, step);
    decrease -= 0.5 * (u0 * u0 + u1 * u1);
  }
  const M4 moves = (W[0] != zero) | (W[3] != zero) | (W[5] != zero);
  D4 squared_state = {};
  for (const D4& x : X) squared_state += x * x;
  sums.squared_step += live * dot3(step, step);
  sums.squared_state += moves ? live * squared_state : zero;
  D4 X_new[Point::kStride];
  move_point(kind, tangent_at(kind, X), X, step, X_new);
  D4 cost;
  if (trial.refine_points) {
    refine_points(kind, camera_kind, trial, group, W, X_new, cost, decrease);
  } else {
    PointView view;
    view_points<false>(kind, camera_kind, trial.state, group, trial.trial_packets, X_new, view);
    cost = view.cost;
  }
  sums.cost += cost;
  sums.model_decrease += live * decrease;
  scatter_points(kind, group, X_new, trial.X_trial);
}

template <typename Point, typename Camera>
RAYLIGN_INLINE TrialSums try_points(Point kind,
                                    Camera camera_kind,
                                    const TrialStep& trial,
                                    std::int64_t begin,
                                    std::int64_t end,
                                    TrialScratch* scratch) {
  GroupSums sums;
  for (std::int64_t j = begin; j < end; j += 4) {
    try_group(kind, camera_kind, trial, group_at(trial.state.observations, j, end),
              reinterpret_cast<Moved*>(scratch), sums);
  }
  return {sum_of(sums.cost), sum_of(sums.model_decrease), sum_of(sums.squared_step),
          sum_of(sums.squared_state)};
}

// The one switch over cameras.
template <typename Point>
RAYLIGN_INLINE TrialSums try_cameras(Point kind,
                                     const TrialStep& step,
                                     std::int64_t begin,
                                     std::int64_t end,
                                     TrialScratch* scratch) {
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
                                       TrialScratch* scratch) {
  if (step.state.observations.point_kind == PointKind::HOMOGENEOUS) {
    return try_cameras(HomogeneousPoint{}, step, begin, end, scratch);
  }
  return try_cameras(XyzPoint{}, step, begin, end, scratch);
}

}  // namespace raylign::native
