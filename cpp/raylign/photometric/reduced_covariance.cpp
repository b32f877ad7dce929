// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/reduced_covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <cmath>

#include "raylign/geometry/so3.h"

namespace raylign {
namespace {

// Eigenvalues of a matrix of unit diagonal below this are rounding.
constexpr double kSingular = 1e-11;

}  // namespace

SymmetricInverse invert_symmetric(const Eigen::MatrixXd& A) {
  SymmetricInverse result;
  const Eigen::Index n = A.rows();
  Eigen::VectorXd scale = Eigen::VectorXd::Zero(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    if (A(i, i) > 0.0) scale[i] = 1.0 / std::sqrt(A(i, i));
  }
  const Eigen::MatrixXd scaled = scale.asDiagonal() * A * scale.asDiagonal();
  const Eigen::LLT<Eigen::MatrixXd> cholesky(scaled);
  if (n == 0 || (cholesky.info() == Eigen::Success && cholesky.rcond() > kSingular)) {
    result.inverse = cholesky.solve(Eigen::MatrixXd::Identity(n, n));
  } else {
    const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> eigen(scaled);
    Eigen::VectorXd inverse = Eigen::VectorXd::Zero(n);
    for (Eigen::Index i = 0; i < n; ++i) {
      const double value = eigen.eigenvalues()[i];
      if (value > kSingular * eigen.eigenvalues()[n - 1]) {
        inverse[i] = 1.0 / value;
      } else {
        ++result.nullity;
      }
    }
    result.inverse = eigen.eigenvectors() * inverse.asDiagonal() * eigen.eigenvectors().transpose();
  }
  result.inverse = scale.asDiagonal() * result.inverse * scale.asDiagonal();
  return result;
}

ReducedPoint::ReducedPoint(const PointSystem& system) {
  const SymmetricInverse inverse = invert_symmetric(system.V);
  V_inverse = inverse.inverse;
  nullity = inverse.nullity;
  Y = system.W * V_inverse;
}

WorldPointMotion world_point_motion(const PatchScene& scene,
                                    const PatchColumns& columns,
                                    const PointSystem& system,
                                    std::int64_t point) {
  const Eigen::Index d = system.V.rows();
  const auto L = static_cast<Eigen::Index>(system.columns.size());
  WorldPointMotion motion = {PointColumns::Identity(3, d), Eigen::MatrixXd::Zero(3, L)};
  if (!scene.inverse_depth) return motion;
  // X = T_h⁻¹ x, x = ray / ρ: T_h ← exp(ξ) T_h moves it by −R_hᵀ [I, −[x]×] ξ.
  const std::int32_t h = scene.hosts[point];
  const Matrix3 R_wh = scene.poses[h].q.toRotationMatrix().transpose();
  const Vector3 x = scene.poses[h].q * world_point(scene, point) + scene.poses[h].t;
  if (d > 0) motion.A = -R_wh * x / scene.points(point, 0);
  RowMajor<3, 6> by_pose;
  by_pose << -R_wh, R_wh * so3_hat(x);
  const Eigen::MatrixXd by_column = by_pose * columns.embeddings[h];
  // The ray moves with the host's intrinsics, x by z times as much.
  const auto& intrinsics = columns.intrinsics[scene.intrinsics_row(h)];
  const Eigen::RowVector4d K = scene.intrinsics.row(scene.intrinsics_row(h));
  RowMajor<3, 4> by_intrinsics;
  by_intrinsics << -x.x() / K[0], 0.0, -x.z() / K[0], 0.0,  //
      0.0, -x.y() / K[1], 0.0, -x.z() / K[1],               //
      0.0, 0.0, 0.0, 0.0;
  for (Eigen::Index l = 0; l < L; ++l) {
    const int column = system.columns[static_cast<std::size_t>(l)];
    const int of_pose = column - columns.poses[h];
    if (of_pose >= 0 && of_pose < by_column.cols()) motion.G.col(l) = by_column.col(of_pose);
    for (int k = 0; k < 4; ++k) {
      if (intrinsics[k] == column) motion.G.col(l) = R_wh * by_intrinsics.col(k);
    }
  }
  return motion;
}

Eigen::MatrixXd pose_covariance(const PatchColumns& columns, const Eigen::MatrixXd& covariance) {
  const auto M = static_cast<Eigen::Index>(columns.poses.size());
  Eigen::MatrixXd poses = Eigen::MatrixXd::Zero(6 * M, 6 * M);
  for (Eigen::Index i = 0; i < M; ++i) {
    const PoseEmbedding& E_i = columns.embeddings[static_cast<std::size_t>(i)];
    const int at_i = columns.poses[static_cast<std::size_t>(i)];
    for (Eigen::Index j = 0; j < M; ++j) {
      const PoseEmbedding& E_j = columns.embeddings[static_cast<std::size_t>(j)];
      const int at_j = columns.poses[static_cast<std::size_t>(j)];
      poses.block<6, 6>(6 * i, 6 * j) =
          E_i * covariance.block(at_i, at_j, E_i.cols(), E_j.cols()) * E_j.transpose();
    }
  }
  return poses;
}

void scatter(const std::vector<int>& columns, const Eigen::MatrixXd& block, Eigen::MatrixXd& sum) {
  for (std::size_t b = 0; b < columns.size(); ++b) {
    for (std::size_t a = 0; a < columns.size(); ++a) {
      sum(columns[a], columns[b]) +=
          block(static_cast<Eigen::Index>(a), static_cast<Eigen::Index>(b));
    }
  }
}

Eigen::MatrixXd gather(const std::vector<int>& columns, const Eigen::MatrixXd& matrix) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::MatrixXd block(n, n);
  for (Eigen::Index b = 0; b < n; ++b) {
    for (Eigen::Index a = 0; a < n; ++a) {
      block(a, b) =
          matrix(columns[static_cast<std::size_t>(a)], columns[static_cast<std::size_t>(b)]);
    }
  }
  return block;
}

}  // namespace raylign
