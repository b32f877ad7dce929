// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/preconditioner.h"

#include <Eigen/Cholesky>

#include "raylign/base/eigen.h"

namespace raylign::native {
namespace {

using Rows = Eigen::Map<Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;
using ConstRows = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;
using SmallMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor, 9, 9>;

// U + λD in the user's tangent.
Block damped_camera(const CameraBlocks& cameras, const DampedProblem& problem, int i) {
  Block block;
  fold_block(problem.cameras[i].U, cameras.map(i), cameras.map(i), 9, kRow, block.values, kRow);
  for (int a = 0; a < cameras.size(i); ++a) {
    block.values[a * kRow + a] += problem.damping[cameras.offset(i) + a];
  }
  return block;
}

}  // namespace

BlockJacobi::BlockJacobi(const CameraBlocks& cameras, Preconditioner kind)
    : cameras_(cameras), kind_(kind), inverses_(cameras.num_cameras(), Block{}) {}

bool BlockJacobi::invert(int i, const Block& block) {
  const int size = cameras_.size(i);
  const Eigen::LLT<SmallMatrix> llt(ConstRows(block.values).topLeftCorner(size, size));
  if (llt.info() != Eigen::Success) return false;
  Rows inverse(inverses_[i].values);
  inverse.topLeftCorner(size, size) = llt.solve(SmallMatrix::Identity(size, size));
  return inverse.allFinite();
}

void BlockJacobi::prepare(const SchurSystem& system, const DampedProblem& problem) {
  if (kind_ == Preconditioner::IDENTITY) return;
  for (int i = 0; i < cameras_.num_cameras(); ++i) {
    const int size = cameras_.size(i);
    if (size == 0) continue;
    if (kind_ == Preconditioner::SCHUR_JACOBI && invert(i, system.diagonal(i))) continue;
    if (invert(i, damped_camera(cameras_, problem, i))) continue;
    Rows(inverses_[i].values).setZero();
    Rows(inverses_[i].values).topLeftCorner(size, size).setIdentity();
  }
}

void BlockJacobi::apply(const double* r, double* z) {
  for (std::int64_t i = 0; i < cameras_.num_cameras(); ++i) {
    if (kind_ == Preconditioner::IDENTITY) {
      for (int a = 0; a < kRow; ++a) z[i * kRow + a] = r[i * kRow + a];
    } else {
      multiply_block(inverses_[i], r + i * kRow, z + i * kRow);
      for (int a = 9; a < kRow; ++a) z[i * kRow + a] = 0.0;
    }
  }
}

}  // namespace raylign::native
