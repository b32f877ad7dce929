// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/product_kernels.h"

#include "raylign/bundle/native/point_kinds.h"

namespace raylign::native {

namespace {

template <typename Point>
RAYLIGN_INLINE void multiply_points(Point kind,
                                    const DampedProblem& problem,
                                    std::int64_t begin,
                                    std::int64_t end,
                                    const double* x,
                                    double* y,
                                    double* scratch) {
  const Observations& observations = problem.observations;
  for (std::int64_t j = begin; j < end; ++j) {
    const std::int64_t first = observations.starts[j];
    const std::int64_t last = observations.starts[j + 1];
    const double* X_j = problem.X + std::int64_t{Point::kStride} * j;
    const double weight_j = weight(kind, X_j);
    const auto H = tangent_at(kind, X_j);
    double s[3] = {};  // Σ Eᵀ F x
    for (std::int64_t q = first; q < last; ++q) {
      const ObservationJacobian J = load(problem.J, q);
      const std::int64_t i = observations.camera[q];
      const double* d = x + i * kRow;
      const double* c = problem.packets[i].c;
      double a[3];
      ray(kind, X_j, c, a);
      double E[6];
      point_rows(kind, H, J.A, c, E);
      double moved[3];  // F x = A (ω × a − w δc) + I δ(f, k1, k2)
      cross(d, a, moved);
      for (int k = 0; k < 3; ++k) moved[k] -= weight_j * d[3 + k];
      double* u = scratch + 2 * (q - first);
      u[0] = dot3(J.A, moved) + dot3(J.I, d + 6);
      u[1] = dot3(J.A + 3, moved) + dot3(J.I + 3, d + 6);
      for (int k = 0; k < 3; ++k) s[k] += E[k] * u[0] + E[3 + k] * u[1];
    }
    double w[3];
    double z[3];
    multiply_transposed(problem.factors[j].W, s, w);
    multiply(problem.factors[j].W, w, z);
    for (std::int64_t q = first; q < last; ++q) {
      const ObservationJacobian J = load(problem.J, q);
      const std::int64_t i = observations.camera[q];
      const double* c = problem.packets[i].c;
      double a[3];
      ray(kind, X_j, c, a);
      double E[6];
      point_rows(kind, H, J.A, c, E);
      const double* u = scratch + 2 * (q - first);
      const double v0 = u[0] - dot3(E, z);
      const double v1 = u[1] - dot3(E + 3, z);
      double force[3];  // Aᵀ v; Fᵀ v = [a × Aᵀv; −w Aᵀv; Iᵀv]
      for (int k = 0; k < 3; ++k) force[k] = J.A[k] * v0 + J.A[3 + k] * v1;
      double torque[3];
      cross(a, force, torque);
      double* out = y + i * kRow;
      for (int k = 0; k < 3; ++k) out[k] += torque[k];
      for (int k = 0; k < 3; ++k) out[3 + k] -= weight_j * force[k];
      for (int k = 0; k < 3; ++k) out[6 + k] += J.I[k] * v0 + J.I[3 + k] * v1;
    }
  }
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
                                       double* scratch) {
  if (problem.observations.point_kind == PointKind::HOMOGENEOUS) {
    multiply_points(HomogeneousPoint{}, problem, begin, end, x, y, scratch);
  } else {
    multiply_points(XyzPoint{}, problem, begin, end, x, y, scratch);
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
