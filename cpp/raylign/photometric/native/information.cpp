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
  check_solvable(scene, constraints, options);
  PatchProblem problem(scene, constraints, options);
  problem.linearize();
  ReducedInformation out{problem.columns(), problem.reduced_system(), {}, {}, {}, {}};
  const SchurArrays& schur = problem.schur();
  const std::vector<std::int64_t>& points = problem.layout().points();
  std::vector<std::size_t> places(points.size());
  for (std::size_t k = 0; k < points.size(); ++k) places[points[k]] = k;
  out.slot_starts.push_back(0);
  for (const std::size_t k : places) {
    out.point_inverse.push_back(inverse_of(schur.factors[k]));
    const std::int64_t first = schur.slot_starts[k];
    const std::int64_t last = schur.slot_starts[k + 1];
    out.slot_images.insert(out.slot_images.end(), schur.slot_images + first,
                           schur.slot_images + last);
    const int size = 3 * schur.num_columns;
    out.W.insert(out.W.end(), schur.W + first * size, schur.W + last * size);
    out.slot_starts.push_back(out.slot_starts.back() + last - first);
  }
  return out;
}

double max_diagonal(const PatchScene& scene,
                    const PatchConstraints& constraints,
                    const PatchSolveOptions& options) {
  check_solvable(scene, constraints, options);
  PatchProblem problem(scene, constraints, options);
  problem.linearize();
  return problem.max_diagonal();
}

}  // namespace raylign::native
