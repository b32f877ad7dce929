// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/image_columns.h"

#include <algorithm>

namespace raylign::native {
namespace {

using RowMatrix = Eigen::Matrix<double, Eigen::Dynamic, Eigen::Dynamic, Eigen::RowMajor>;

int num_free_pose(const PoseMask& mask) {
  int n = 0;
  for (int k = 0; k < 6; ++k) n += mask.is_free(k) ? 1 : 0;
  return n;
}

}  // namespace

ImageColumns::ImageColumns(const PatchScene& scene, const PatchConstraints& constraints)
    : masks_(constraints.poses) {
  for (const auto& row : constraints.intrinsics) {
    with_intrinsics_ |= std::any_of(row.begin(), row.end(), [](bool held) { return !held; });
  }
  const auto M = scene.num_images();
  columns_.resize(M);
  bases_.resize(M);
  for (std::int64_t i = 0; i < M; ++i) {
    const int pose = num_free_pose(masks_[i]);
    for (int k = 0; k < pose; ++k) columns_[i].push_back(num_columns_++);
    for (int k = 0; k < 2; ++k) {
      if (!constraints.brightness[i][k]) columns_[i].push_back(num_columns_++);
    }
  }
  std::vector<std::array<int, 4>> of_row(constraints.intrinsics.size(), {-1, -1, -1, -1});
  for (std::size_t row = 0; with_intrinsics_ && row < of_row.size(); ++row) {
    for (int k = 0; k < 4; ++k) {
      if (!constraints.intrinsics[row][k]) of_row[row][k] = num_columns_++;
    }
  }
  for (std::int64_t i = 0; i < M; ++i) {
    const int pose = num_free_pose(masks_[i]);
    const std::array<int, 4>& shared = of_row[scene.intrinsics_row(i)];
    for (const int column : shared) {
      if (column >= 0) columns_[i].push_back(column);
    }
    Eigen::MatrixXd& B = bases_[i];
    B.setZero(C(), static_cast<Eigen::Index>(columns_[i].size()));
    int next = pose;
    for (int k = 0; k < 2; ++k) {
      if (!constraints.brightness[i][k]) B(6 + k, next++) = 1.0;
    }
    for (int k = 0; k < 4; ++k) {
      if (shared[k] >= 0) B(8 + k, next++) = 1.0;
    }
  }
  set_poses(scene.poses);
}

void ImageColumns::set_poses(const std::vector<PatchPose>& poses) {
  for (std::size_t i = 0; i < poses.size(); ++i) {
    const int pose = num_free_pose(masks_[i]);
    bases_[i].topLeftCorner(6, pose) =
        pose_embedding(TranslationUpdate::COUPLED, masks_[i], poses[i].t);
  }
}

void ImageColumns::add_block(std::int64_t i,
                             std::int64_t k,
                             const double* block,
                             Eigen::MatrixXd& lower) const {
  const Eigen::Map<const RowMatrix> full(block, C(), C());
  const Eigen::MatrixXd free = bases_[i].transpose() * full * bases_[k];
  for (Eigen::Index a = 0; a < free.rows(); ++a) {
    for (Eigen::Index b = 0; b < free.cols(); ++b) {
      const int row = columns_[i][a];
      const int column = columns_[k][b];
      if (i == k) {
        if (row >= column) lower(row, column) += free(a, b);
      } else {  // stands for the block below the diagonal, too
        const double twice = row == column ? 2.0 : 1.0;
        lower(std::max(row, column), std::min(row, column)) += twice * free(a, b);
      }
    }
  }
}

void ImageColumns::add_vector(std::int64_t i, const double* full, Eigen::VectorXd& free) const {
  const Eigen::VectorXd part = bases_[i].transpose() * Eigen::Map<const Eigen::VectorXd>(full, C());
  for (Eigen::Index a = 0; a < part.size(); ++a) free[columns_[i][a]] += part[a];
}

void ImageColumns::expand(const Eigen::VectorXd& free, double* full) const {
  for (std::size_t i = 0; i < columns_.size(); ++i) {
    Eigen::VectorXd part(columns_[i].size());
    for (Eigen::Index a = 0; a < part.size(); ++a) part[a] = free[columns_[i][a]];
    Eigen::Map<Eigen::VectorXd>(full + static_cast<std::int64_t>(i) * C(), C()) = bases_[i] * part;
  }
}

}  // namespace raylign::native
