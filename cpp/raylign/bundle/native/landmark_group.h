// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <cstdint>

#include "raylign/base/clones.h"
#include "raylign/base/double_lanes.h"
#include "raylign/bundle/native/camera_kinds.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/landmark_math.h"
#include "raylign/bundle/native/point_kinds.h"

/// Four landmarks side by side, one per lane: the passes walk their observations in step, and
/// nothing is ever summed across lanes. Landmarks of a window lie by the length of their tracks, so
/// nearly all lanes are busy. For the files of the kernels alone.
namespace raylign::native {

/// Up to four consecutive landmarks. Lanes without one repeat the last; a lane whose track has
/// ended repeats its last observation.
struct Group {
  std::int64_t landmark[4];
  std::int64_t first[4];
  std::int64_t last[4];
  std::int64_t shortest, longest;  ///< tracks; shortest is 0 where there are less than four
  int count;                       ///< of landmarks

  bool is_whole(std::int64_t step) const { return step < shortest; }
  bool has(int lane, std::int64_t step) const {
    return lane < count && first[lane] + step <= last[lane];
  }
};

RAYLIGN_INLINE Group group_at(const Observations& observations,
                              std::int64_t begin,
                              std::int64_t end) {
  Group group;
  group.count = end - begin < 4 ? static_cast<int>(end - begin) : 4;
  group.longest = 0;
  group.shortest = INT64_MAX;
  for (int lane = 0; lane < 4; ++lane) {
    const std::int64_t j = lane < group.count ? begin + lane : begin + group.count - 1;
    group.landmark[lane] = j;
    group.first[lane] = observations.starts[j];
    group.last[lane] = observations.starts[j + 1] - 1;
    const std::int64_t length = group.last[lane] + 1 - group.first[lane];
    if (length > group.longest) group.longest = length;
    if (length < group.shortest) group.shortest = length;
  }
  if (group.count < 4) group.shortest = 0;
  return group;
}

/// Step `step` of the four tracks.
RAYLIGN_INLINE void observations_at(const Group& group, std::int64_t step, std::int64_t* q) {
  for (int lane = 0; lane < 4; ++lane) {
    const std::int64_t at = group.first[lane] + step;
    q[lane] = at < group.last[lane] ? at : group.last[lane];
  }
}

/// 1 for lanes that have a landmark.
RAYLIGN_INLINE void live_lanes(const Group& group, D4& live) {
  for (int lane = 0; lane < 4; ++lane) live[lane] = lane < group.count ? 1.0 : 0.0;
}

/// 1 for lanes that have an observation at the step.
RAYLIGN_INLINE void live_lanes(const Group& group, std::int64_t step, D4& live) {
  for (int lane = 0; lane < 4; ++lane) live[lane] = group.has(lane, step) ? 1.0 : 0.0;
}

template <typename Point>
RAYLIGN_INLINE void gather_points(Point /*kind*/, const Group& group, const double* X, D4* out) {
  const double* rows[4];
  for (int lane = 0; lane < 4; ++lane) rows[lane] = X + Point::kStride * group.landmark[lane];
  gather<Point::kStride>(rows, out);
}

template <typename Point>
RAYLIGN_INLINE void scatter_points(Point /*kind*/, const Group& group, const D4* in, double* X) {
  for (int lane = 0; lane < group.count; ++lane) {
    double* row = X + Point::kStride * group.landmark[lane];
    for (int k = 0; k < Point::kStride; ++k) row[k] = in[k][lane];
  }
}

/// The first `kCount` numbers of a landmark's record of doubles.
template <int kCount, typename Record>
RAYLIGN_INLINE void gather_records(const Group& group, const Record* records, D4* out) {
  const double* rows[4];
  for (int lane = 0; lane < 4; ++lane) {
    rows[lane] = reinterpret_cast<const double*>(records + group.landmark[lane]);
  }
  gather<kCount>(rows, out);
}
template <int kCount, typename Record>
RAYLIGN_INLINE void scatter_records(const Group& group, const D4* in, Record* records) {
  Record unused;
  double* rows[4];
  for (int lane = 0; lane < 4; ++lane) {
    Record* record = lane < group.count ? records + group.landmark[lane] : &unused;
    rows[lane] = reinterpret_cast<double*>(record);
  }
  scatter<kCount>(in, rows);
}

template <typename Camera>
RAYLIGN_INLINE void gather_cameras(Camera /*kind*/,
                                   const CameraPacket* packets,
                                   const std::int32_t* camera,
                                   const std::int64_t* q,
                                   CameraLanes& out) {
  constexpr int kIntrinsics = Camera::kNumIntrinsics == 3 ? 5 : Camera::kNumIntrinsics + 1;
  constexpr int kCount = 15 + kIntrinsics;  // a multiple of four where that reads on in the packet
  const double* rows[4];
  for (int lane = 0; lane < 4; ++lane) {
    out.packets[lane] = packets + camera[q[lane]];
    rows[lane] = reinterpret_cast<const double*>(out.packets[lane]);
  }
  D4 numbers[kCount];
  gather<kCount>(rows, numbers);
  for (int k = 0; k < 9; ++k) out.R[k] = numbers[k];
  for (int k = 0; k < 3; ++k) out.t[k] = numbers[9 + k];
  for (int k = 0; k < 3; ++k) out.c[k] = numbers[12 + k];
  for (int k = 0; k < Camera::kNumIntrinsics; ++k) out.intrinsics[k] = numbers[15 + k];
  out.max_radius_squared = numbers[kCount - 1];
}

// A homogeneous point beyond infinity is an ordinary point.
template <typename Projection, typename Mask>
RAYLIGN_INLINE Mask is_in_front(XyzPoint /*kind*/, const Projection& p, const Mask& projects) {
  return projects & (p.w > 0.0);
}
template <typename Projection, typename Mask>
RAYLIGN_INLINE Mask is_in_front(HomogeneousPoint /*kind*/,
                                const Projection& /*p*/,
                                const Mask& projects) {
  return projects;
}

/// Four observations as their cameras see them: r, NaN where a camera has no projection, ρ(‖r‖²);
/// J and r weighted. Lanes without an observation are zero in all of these.
struct Sight {
  JacobianOf<D4> J;
  D4 r[2];
  D4 rho;
  D4 behind;  ///< 1 where the landmark is not in front of the camera
};

/// J is left alone unless asked for.
template <bool kJacobian, typename Point, typename Camera>
RAYLIGN_INLINE void look(Point kind,
                         Camera camera_kind,
                         const State& state,
                         const Group& group,
                         std::int64_t step,
                         const std::int64_t* q,
                         const CameraLanes& camera,
                         const D4* X,
                         Sight& out) {
  const D4 zero = {};
  D4 P[3];
  transform(kind, camera, X, P);
  typename Camera::template Projection<D4> p;
  const M4 projects = project(camera_kind, camera, P, p);
  const double* uv = state.observations.uv;
  const D4 seen[2] = {{uv[2 * q[0]], uv[2 * q[1]], uv[2 * q[2]], uv[2 * q[3]]},
                      {uv[2 * q[0] + 1], uv[2 * q[1] + 1], uv[2 * q[2] + 1], uv[2 * q[3] + 1]}};
  residual(camera_kind, camera, p, seen, out.r);
  for (D4& r : out.r) r = projects ? r : zero + NAN;
  out.behind = is_in_front(kind, p, projects) ? zero : zero + 1.0;
  out.rho = out.r[0] * out.r[0] + out.r[1] * out.r[1];
  if (kJacobian) {
    jacobian(camera_kind, camera, p, out.J);
    if (state.loss != nullptr) apply_loss(*state.loss, out.J, out.r, out.rho);
  } else if (state.loss != nullptr) {
    for (int lane = 0; lane < 4; ++lane) {
      out.rho[lane] = state.loss->evaluate(out.rho[lane]).rho;
    }
  }
  if (group.is_whole(step)) return;
  D4 live;
  live_lanes(group, step, live);
  if (kJacobian) {
    for (D4& a : out.J.A) a *= live;
    for (D4& i : out.J.I) i *= live;
  }
  for (D4& r : out.r) r *= live;
  out.rho *= live;
  out.behind *= live;
}

/// J of four observations at the state that was linearised: from the table, or computed again.
template <typename Point, typename Camera>
RAYLIGN_INLINE void jacobians_at(Point kind,
                                 Camera camera_kind,
                                 const Jacobians& table,
                                 const std::int64_t* q,
                                 const CameraLanes& camera,
                                 const D4* X,
                                 JacobianOf<D4>& out) {
  if (table.exact == nullptr && table.rounded == nullptr) {
    D4 P[3];
    transform(kind, camera, X, P);
    typename Camera::template Projection<D4> p;
    project(camera_kind, camera, P, p);
    jacobian(camera_kind, camera, p, out);
    return;
  }
  ObservationJacobian J[4];
  const double* rows[4];
  for (int lane = 0; lane < 4; ++lane) {
    if (table.rounded != nullptr) J[lane] = load(table, q[lane]);
    rows[lane] = reinterpret_cast<const double*>(table.rounded != nullptr ? J + lane
                                                                          : table.exact + q[lane]);
  }
  D4 numbers[12];
  gather<12>(rows, numbers);
  for (int k = 0; k < 6; ++k) out.A[k] = numbers[k];
  for (int k = 0; k < 6; ++k) out.I[k] = numbers[6 + k];
}

}  // namespace raylign::native
