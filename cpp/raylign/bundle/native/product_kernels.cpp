// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/product_kernels.h"

#include "raylign/bundle/native/landmark_group.h"

namespace raylign::native {
namespace {

// Four observations on the way back.
struct alignas(32) Returning {
  D4 u[2];  // F x
  JacobianOf<D4> J;
  D4 E[6];
  D4 a[3];
};
static_assert(sizeof(Returning) == sizeof(ProductScratch));

// s = Σ Eᵀ F x.
template <typename Point, typename Camera>
RAYLIGN_INLINE void multiply_forth(Point kind,
                                   Camera camera_kind,
                                   const DampedProblem& problem,
                                   const Group& group,
                                   const D4* X,
                                   const double* x,
                                   Returning* out,
                                   D4* s) {
  const std::int32_t* cameras = problem.observations.camera;
  const D4 w = weight(kind, X);
  const auto H = tangent_at(kind, X);
  for (std::int64_t step = 0; step < group.longest; ++step) {
    std::int64_t q[4];
    observations_at(group, step, q);
    CameraLanes camera;
    gather_cameras(camera_kind, problem.packets, cameras, q, camera);
    Returning& row = out[step];
    jacobians_at(kind, camera_kind, problem.J, q, camera, X, row.J);
    const double* rows[4];
    for (int lane = 0; lane < 4; ++lane) rows[lane] = x + std::int64_t{cameras[q[lane]]} * kRow;
    D4 d[9];
    gather<9>(rows, d);
    ray(kind, X, camera.c, row.a);
    D4 turned[3];  // F x = A (ω × a − w δc) + I δ(f, k1, k2)
    cross(d, row.a, turned);
    for (int k = 0; k < 3; ++k) turned[k] -= w * d[3 + k];
    row.u[0] = dot3(row.J.A, turned) + dot3(row.J.I, d + 6);
    row.u[1] = dot3(row.J.A + 3, turned) + dot3(row.J.I + 3, d + 6);
    point_rows(kind, H, row.J.A, camera.c, row.E);
    if (!group.is_whole(step)) {
      D4 live;
      live_lanes(group, step, live);
      for (D4& u : row.u) u *= live;
      for (D4& e : row.E) e *= live;
    }
    for (int k = 0; k < 3; ++k) s[k] += row.E[k] * row.u[0] + row.E[3 + k] * row.u[1];
  }
}

// y += Fᵀ v, v = F x − E z; Fᵀ v = [a × Aᵀv; −w Aᵀv; Iᵀv].
template <typename Point>
RAYLIGN_INLINE void multiply_back(Point kind,
                                  const DampedProblem& problem,
                                  const Group& group,
                                  const D4* X,
                                  const D4* z,
                                  const Returning* rows,
                                  double* y) {
  const D4 w = weight(kind, X);
  for (std::int64_t step = 0; step < group.longest; ++step) {
    const Returning& row = rows[step];
    const D4 v0 = row.u[0] - dot3(row.E, z);
    const D4 v1 = row.u[1] - dot3(row.E + 3, z);
    D4 force[3];
    for (int k = 0; k < 3; ++k) force[k] = row.J.A[k] * v0 + row.J.A[3 + k] * v1;
    D4 numbers[kRow] = {};
    cross(row.a, force, numbers);
    for (int k = 0; k < 3; ++k) numbers[3 + k] = -w * force[k];
    for (int k = 0; k < 3; ++k) numbers[6 + k] = row.J.I[k] * v0 + row.J.I[3 + k] * v1;
    alignas(32) double sums[4][kRow];
    double* out[4] = {sums[0], sums[1], sums[2], sums[3]};
    scatter<kRow>(numbers, out);
    for (int lane = 0; lane < 4; ++lane) {
      if (!group.has(lane, step)) continue;
      const std::int64_t i = problem.observations.camera[group.first[lane] + step];
      LooseLanes* y_i = loose_lanes(y + i * kRow);
      for (int v = 0; v < kLanes; ++v) y_i[v] += lanes(sums[lane])[v];
    }
  }
}

template <typename Point, typename Camera>
RAYLIGN_INLINE void multiply_groups(Point kind,
                                    Camera camera_kind,
                                    const DampedProblem& problem,
                                    std::int64_t begin,
                                    std::int64_t end,
                                    const double* x,
                                    double* y,
                                    ProductScratch* scratch) {
  auto* rows = reinterpret_cast<Returning*>(scratch);
  for (std::int64_t j = begin; j < end; j += 4) {
    const Group group = group_at(problem.observations, j, end);
    D4 X[Point::kStride];
    gather_points(kind, group, problem.X, X);
    D4 s[3] = {};
    multiply_forth(kind, camera_kind, problem, group, X, x, rows, s);
    D4 W[6];
    gather_records<6>(group, problem.factors, W);
    D4 half[3];
    D4 z[3];
    multiply_transposed(W, s, half);
    multiply(W, half, z);
    multiply_back(kind, problem, group, X, z, rows, y);
  }
}

// The one switch over cameras.
template <typename Point>
RAYLIGN_INLINE void multiply_cameras(Point kind,
                                     const DampedProblem& problem,
                                     std::int64_t begin,
                                     std::int64_t end,
                                     const double* x,
                                     double* y,
                                     ProductScratch* scratch) {
  switch (problem.observations.camera_kind) {
    case CameraKind::PINHOLE:
      return multiply_groups(kind, PinholeKind{}, problem, begin, end, x, y, scratch);
    case CameraKind::RADTAN:
      return multiply_groups(kind, RadtanKind{}, problem, begin, end, x, y, scratch);
    case CameraKind::BAL:
      break;
  }
  multiply_groups(kind, BalKind{}, problem, begin, end, x, y, scratch);
}

}  // namespace

RAYLIGN_CLONES void multiply_rows(const std::int64_t* starts,
                                  const std::int32_t* columns,
                                  const Block* blocks,
                                  std::int32_t row_begin,
                                  std::int32_t row_end,
                                  const double* x,
                                  double* y) {
  for (std::int64_t i = row_begin; i < row_end; ++i) {
    if (starts[i] == starts[i + 1]) continue;
    const double* x_i = x + i * kRow;
    Lanes sums[9] = {};
    for (std::int64_t b = starts[i]; b < starts[i + 1]; ++b) {
      const std::int64_t k = columns[b];
      const LooseLanes* x_k = loose_lanes(x + k * kRow);
      LooseLanes* y_k = loose_lanes(y + (k - row_begin) * kRow);
      Lanes mirrored[kLanes] = {};
      for (int row = 0; row < 9; ++row) {
        const Lanes* values = lanes(blocks[b].values + row * kRow);
        for (int v = 0; v < kLanes; ++v) {
          sums[row] += values[v] * x_k[v];
          mirrored[v] += x_i[row] * values[v];
        }
      }
      if (k == i) continue;  // the diagonal block is whole
      for (int v = 0; v < kLanes; ++v) y_k[v] += mirrored[v];
    }
    double* y_i = y + (i - row_begin) * kRow;
    for (int row = 0; row < 9; ++row) {
      y_i[row] += (sums[row][0] + sums[row][1]) + (sums[row][2] + sums[row][3]);
    }
  }
}

RAYLIGN_CLONES void multiply_landmarks(const DampedProblem& problem,
                                       std::int64_t begin,
                                       std::int64_t end,
                                       const double* x,
                                       double* y,
                                       ProductScratch* scratch) {
  if (problem.observations.point_kind == PointKind::HOMOGENEOUS) {
    multiply_cameras(HomogeneousPoint{}, problem, begin, end, x, y, scratch);
  } else {
    multiply_cameras(XyzPoint{}, problem, begin, end, x, y, scratch);
  }
}

RAYLIGN_CLONES void multiply_block(const Block& B, const double* x, double* y) {
  for (int row = 0; row < 9; ++row) {
    double sum = 0.0;
    for (int k = 0; k < 9; ++k) sum += B.values[row * kRow + k] * x[k];
    y[row] = sum;
  }
}

}  // namespace raylign::native
