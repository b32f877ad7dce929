// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/linear_solver_choice.h"

#include <cmath>
#include <cstdint>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/solver/summary.h"

namespace raylign::ceres_backend {
namespace {

// Measured (docs/theory/why-bundle-adjustment-is-not-slow.md): OpenBLAS factors a dense S faster
// than CHOLMOD a sparse one up to about 200 cameras. Conjugate gradients are faster long before
// 1000, but inexact, and slow on long chains of cameras: they are left to the sizes where a factor
// no longer fits.
constexpr std::int64_t kMaxCamerasDense = 200;
constexpr std::int64_t kMaxCamerasSparse = 1000;
constexpr double kMaxDenseBytes = 8e9;  // past this the machine would swap
constexpr double kMaxInt = std::numeric_limits<int>::max();

void check_dense_matrices(LinearSolverType type, double rows, double columns) {
  const double bytes = 8.0 * columns * (rows + columns);
  const bool too_long = columns * columns > kMaxInt || rows * columns > kMaxInt;  // int indices
  if (bytes <= kMaxDenseBytes && !too_long) return;
  throw OptionsError("LinearSolverOptions.type " + to_string(type) + " would allocate " +
                     std::to_string(static_cast<std::int64_t>(std::ceil(bytes / 1e9))) +
                     " GB of dense matrices for this problem (limit 8 GB); use sparse_schur or "
                     "iterative_schur");
}

}  // namespace

LinearSolverChoice choose_linear_solver(LinearSolverType requested,
                                        std::int64_t num_cameras,
                                        bool has_free_point) {
  if (requested != LinearSolverType::AUTO) return {requested, "requested"};
  if (!has_free_point) {
    return {LinearSolverType::SPARSE_SCHUR,
            "auto: no free point to eliminate, so the cameras' JᵀJ "
            "is factored sparsely"};
  }
  const std::string count = std::to_string(num_cameras) + " cameras";
  if (num_cameras <= kMaxCamerasDense) {
    return {LinearSolverType::DENSE_SCHUR, "auto: " + count +
                                               " <= " + std::to_string(kMaxCamerasDense) +
                                               ", so a dense S is cheapest"};
  }
  const std::string limit = std::to_string(kMaxCamerasSparse);
  if (num_cameras <= kMaxCamerasSparse) {
    return {LinearSolverType::SPARSE_SCHUR, "auto: " + std::to_string(kMaxCamerasDense) + " < " +
                                                count + " <= " + limit +
                                                ", so S is factored sparsely"};
  }
  return {LinearSolverType::ITERATIVE_SCHUR,
          "auto: " + count + " > " + limit + ", so S is not factored"};
}

void check_preconditioner(const LinearSolverOptions& options) {
  const Preconditioner kind = options.preconditioner;
  if (kind == Preconditioner::TWO_LEVEL || kind == Preconditioner::STALE_FACTOR) {
    throw OptionsError("LinearSolverOptions.preconditioner " + to_string(kind) +
                       " is backend NATIVE's; backend CERES has cluster_jacobi and "
                       "cluster_tridiagonal");
  }
  if (options.explicit_schur && kind != Preconditioner::AUTO &&
      kind != Preconditioner::SCHUR_JACOBI) {
    throw OptionsError(
        "LinearSolverOptions.explicit_schur with backend CERES needs preconditioner "
        "SCHUR_JACOBI, got " +
        to_string(kind));
  }
}

void check_ceres_limits(const BundleScene& scene, LinearSolverType type, bool has_free_point) {
  const int num_camera_columns = 6 + scene.num_intrinsics();
  const double max_nonzeros_per_observation =
      2.0 * (num_camera_columns + 3 + 6);  // inverse depth: two poses
  const auto num_observations = static_cast<double>(scene.num_observations());
  const double camera_columns = num_camera_columns * static_cast<double>(scene.num_cameras());
  const double point_columns = 3.0 * static_cast<double>(scene.num_points());
  if (max_nonzeros_per_observation * num_observations > kMaxInt ||
      2.0 * (camera_columns + point_columns) > kMaxInt) {
    throw OptionsError(
        "BundleOptions.backend ceres holds at most " +
        std::to_string(static_cast<std::int64_t>(kMaxInt / max_nonzeros_per_observation)) +
        " observations, got " + std::to_string(scene.num_observations()));
  }
  if (type == LinearSolverType::DENSE_NORMAL_CHOLESKY) {
    check_dense_matrices(type, 2.0 * num_observations, camera_columns + point_columns);
  } else if (type == LinearSolverType::DENSE_SCHUR) {
    // Without a point to eliminate Ceres solves the whole camera problem by dense QR.
    check_dense_matrices(type, has_free_point ? 0.0 : 2.0 * num_observations, camera_columns);
  }
}

}  // namespace raylign::ceres_backend
