// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/information.h"

#include <algorithm>

#include "raylign/photometric/native/patch_problem.h"
#include "raylign/photometric/native/solve.h"

namespace raylign::native {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

Matrix3 inverse_of(const PointFactor& factor) {
  const double* v = factor.values;
  Matrix3 L_inverse;
  L_inverse << v[0], 0.0, 0.0,  //
      v[1], v[2], 0.0,          //
      v[3], v[4], v[5];
  return L_inverse.transpose() * L_inverse;
}

}  // namespace

Matrix3 ReducedInformation::point_covariance(std::int64_t p,
                                             const Eigen::MatrixXd& covariance) const {
  const int C = num_image_columns();
  // W over the free columns that this point's images have
  std::vector<int> free;
  std::vector<Eigen::Vector3d> rows;
  for (auto s = slot_starts[p]; s < slot_starts[p + 1]; ++s) {
    const Eigen::Map<const RowMatrix> full(W.data() + s * 3 * C, 3, C);
    const Eigen::MatrixXd part = full * columns.basis(slot_images[s]);
    for (Eigen::Index k = 0; k < part.cols(); ++k) {
      free.push_back(columns.columns(slot_images[s])[k]);
      rows.emplace_back(part.col(k));
    }
  }
  Matrix3 spread = Matrix3::Zero();
  for (std::size_t a = 0; a < free.size(); ++a) {
    for (std::size_t b = 0; b < free.size(); ++b) {
      spread += covariance(free[a], free[b]) * rows[a] * rows[b].transpose();
    }
  }
  return point_inverse[p] + point_inverse[p] * spread * point_inverse[p];
}

ReducedInformation reduced_information(const PatchScene& scene,
                                       const PatchConstraints& constraints,
                                       const PatchSolveOptions& options) {
  check_solvable(scene, constraints);
  PatchProblem problem(scene, constraints, options);
  problem.linearize();
  ReducedInformation out{problem.columns(), problem.reduced_system(), {}, {}, {}, {}};
  const SchurArrays& schur = problem.schur();
  const std::int64_t N = scene.num_points();
  for (std::int64_t p = 0; p < N; ++p) out.point_inverse.push_back(inverse_of(schur.factors[p]));
  out.slot_starts.assign(schur.slot_starts, schur.slot_starts + N + 1);
  out.slot_images.assign(schur.slot_images, schur.slot_images + out.slot_starts.back());
  out.W.assign(schur.W, schur.W + out.slot_starts.back() * 3 * schur.num_columns);
  return out;
}

double max_diagonal(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options) {
  check_solvable(scene, constraints);
  PatchProblem problem(scene, constraints, options);
  problem.linearize();
  return problem.max_diagonal();
}

}  // namespace raylign::native
