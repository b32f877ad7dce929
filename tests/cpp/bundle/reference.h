// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/bundle/native/schur_system.h"
#include "raylign/geometry/so3.h"
#include "raylign/residuals/reprojection.h"
#include "raylign/solver/lm.h"

namespace raylign::test {

using Rows9 = Eigen::Matrix<double, 2, 9>;

/// The scalar twin of the kernels: one observation through the one definition of the residual.
struct ReferenceObservation {
  double cost = 0.0;  ///< ½ ρ
  Vector2 r;          ///< weighted, as the rest
  RowMajor<2, 3> A;
  Rows9 F;  ///< by the canonical tangent [ω; δc; δ(f, k1, k2)]
};

inline ReferenceObservation reference_observation(const native::CameraPacket& camera,
                                                  const Vector3& X,
                                                  const Vector2& uv,
                                                  const Loss& loss) {
  const Matrix3 R = Eigen::Map<const RowMajor<3, 3>>(camera.R);
  const Vector3 a = X - Eigen::Map<const Vector3>(camera.c);
  RowMajor<2, 3> J_p = RowMajor<2, 3>::Zero();
  RowMajor<2, 3> J_intrinsics = RowMajor<2, 3>::Zero();
  ReferenceObservation out;
  reprojection_residual(R * X + Eigen::Map<const Vector3>(camera.t),
                        Eigen::Map<const Vector3>(camera.intrinsics), uv, out.r, &J_p,
                        &J_intrinsics);
  const LossValue value = loss.evaluate(out.r.squaredNorm());
  const double weight = std::sqrt(value.d_rho);
  out.cost = 0.5 * value.rho;
  out.r *= weight;
  out.A = weight * J_p * R;
  out.F << -out.A * so3_hat(a), -out.A, weight * J_intrinsics;
  return out;
}

/// S of the native engine as one matrix over the free columns.
inline Eigen::MatrixXd dense_schur(const native::SchurSystem& system) {
  using RowMajorBlock = Eigen::Matrix<double, 9, native::kRow, Eigen::RowMajor>;
  const native::SchurPattern& pattern = system.pattern();
  const native::CameraBlocks& cameras = system.cameras();
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(cameras.num_columns(), cameras.num_columns());
  for (int i = 0; i < cameras.num_cameras(); ++i) {
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const int k = pattern.columns[b];
      const Eigen::Map<const RowMajorBlock> values(system.blocks()[b].values);
      const auto block = values.topLeftCorner(cameras.size(i), cameras.size(k));
      S.block(cameras.offset(i), cameras.offset(k), block.rows(), block.cols()) = block;
      S.block(cameras.offset(k), cameras.offset(i), block.cols(), block.rows()) = block.transpose();
    }
  }
  return S;
}

/// The whole linear system, dense, from the Jacobian of the Ceres path: JᵀJ and Jᵀr over all free
/// columns, the first `num_camera_columns` of them the cameras'.
struct DenseSystem {
  Eigen::MatrixXd J;
  Eigen::VectorXd r;

  DenseSystem(const BalProblem& problem, const BundleConfig& config, const BundleOptions& options) {
    const Linearization linear = linearize(problem, config, options);
    const auto rows = static_cast<Eigen::Index>(linear.residuals.size());
    J = Eigen::MatrixXd::Zero(rows, linear.num_columns);
    r = Eigen::Map<const Eigen::VectorXd>(linear.residuals.data(), rows);
    for (Eigen::Index row = 0; row < rows; ++row) {
      for (auto k = linear.row_starts[row]; k < linear.row_starts[row + 1]; ++k) {
        J(row, linear.columns[k]) = linear.values[k];
      }
    }
  }

  /// λD of the loop at the start of a solve.
  Eigen::VectorXd damping(double lambda, const LmOptions& options) const {
    return J.colwise().squaredNorm().transpose().unaryExpr(
        [&](double h) { return lambda * lm_damping(h, lm_column_scale(h, options), options); });
  }

  /// Step of the augmented system [J; √(λD)] δ = [−r; 0] by QR: no normal equations.
  Eigen::VectorXd step(double lambda, const LmOptions& options) const {
    const Eigen::Index n = J.cols();
    Eigen::MatrixXd augmented(J.rows() + n, n);
    augmented << J, Eigen::MatrixXd(damping(lambda, options).cwiseSqrt().asDiagonal());
    Eigen::VectorXd rhs = Eigen::VectorXd::Zero(J.rows() + n);
    rhs.head(J.rows()) = -r;
    return augmented.householderQr().solve(rhs);
  }
};

}  // namespace raylign::test
