// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/two_level.h"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

#include "raylign/base/eigen.h"
#include "raylign/solver/lapack.h"

namespace raylign::native {
namespace {

constexpr int kMinClusterSize = 12;
// The coarse system stays small: a dense factor of 7 · 200 columns takes 0.03 s.
constexpr int kMaxClusters = 200;
// Relative to the diagonal: the gauge makes the coarse system as singular as the whole one.
constexpr double kRegularization = 1e-12;

using Rows = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;
using Modes = Eigen::Map<Eigen::Matrix<double, 9, 7, Eigen::RowMajor>>;
using ConstModes = Eigen::Map<const Eigen::Matrix<double, 9, 7, Eigen::RowMajor>>;
using CanonicalModes = Eigen::Matrix<double, 9, 7>;

// [ω; δc; 0] when the world around the camera turns by θ, moves by t and grows by s about the
// centroid: the centre goes along, the camera turns against the points' motion.
CanonicalModes canonical_modes(const Vector3& arm) {
  CanonicalModes modes = CanonicalModes::Zero();
  modes.topLeftCorner<3, 3>() = -Matrix3::Identity();
  modes.block<3, 3>(3, 0) << 0.0, arm.z(), -arm.y(), -arm.z(), 0.0, arm.x(), arm.y(), -arm.x(), 0.0;
  modes.block<3, 3>(3, 3) = Matrix3::Identity();
  modes.block<3, 1>(3, 6) = arm;
  return modes;
}

// The neighbours of each camera in both directions: starts (C + 1,), cameras.
struct Adjacency {
  std::vector<std::int64_t> starts;
  std::vector<std::int32_t> neighbors;

  explicit Adjacency(const SchurPattern& pattern) : starts(pattern.num_cameras() + 1, 0) {
    const auto visit = [&](auto&& use) {
      for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
        for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
          if (pattern.columns[b] == i) continue;
          use(i, pattern.columns[b]);
          use(pattern.columns[b], i);
        }
      }
    };
    visit([&](std::int32_t i, std::int32_t) { ++starts[i + 1]; });
    for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) starts[i + 1] += starts[i];
    neighbors.resize(starts.back());
    std::vector<std::int64_t> next(starts.begin(), starts.end() - 1);
    visit([&](std::int32_t i, std::int32_t k) { neighbors[next[i]++] = k; });
  }
};

}  // namespace

// Grown one after the other: of the cameras next to a cluster, the one with most neighbours inside.
std::vector<std::int32_t> cluster_cameras(const SchurPattern& pattern, int max_size) {
  const Adjacency graph(pattern);
  std::vector<std::int32_t> cluster(pattern.num_cameras(), -1);
  std::vector<int> links(pattern.num_cameras(), 0);  // to the growing cluster
  std::vector<std::int32_t> frontier;
  std::int32_t num_clusters = 0;
  for (std::int32_t seed = 0; seed < pattern.num_cameras(); ++seed) {
    if (pattern.active[seed] == 0 || cluster[seed] >= 0) continue;
    frontier.assign(1, seed);
    for (int size = 0; size < max_size && !frontier.empty(); ++size) {
      const auto best = std::max_element(frontier.begin(), frontier.end(), [&](auto a, auto b) {
        return links[a] != links[b] ? links[a] < links[b] : a > b;
      });
      const std::int32_t camera = *best;
      frontier.erase(best);
      cluster[camera] = num_clusters;
      for (auto n = graph.starts[camera]; n < graph.starts[camera + 1]; ++n) {
        const std::int32_t other = graph.neighbors[n];
        if (cluster[other] >= 0) continue;
        if (links[other]++ == 0 && other != seed) frontier.push_back(other);
      }
    }
    for (const std::int32_t left : frontier) links[left] = 0;
    ++num_clusters;
  }
  return cluster;
}

TwoLevel::TwoLevel(const SolverContext& context, const SchurPattern& pattern)
    : cameras_(context.cameras), fine_(context.cameras, Preconditioner::SCHUR_JACOBI) {
  const int count = pattern.num_cameras();
  cluster_ = cluster_cameras(pattern, std::max(kMinClusterSize, count / kMaxClusters + 1));
  for (const std::int32_t k : cluster_) num_clusters_ = std::max(num_clusters_, k + 1);
  centroids_.resize(3 * num_clusters_);
  counts_.resize(num_clusters_);
  modes_.resize(std::size_t{9 * kModes} * count);
  const auto n = static_cast<std::size_t>(kModes * num_clusters_);
  coarse_.resize(n * n);
  scales_.resize(n);
  restricted_.resize(n);
}

void TwoLevel::set_modes(const DampedProblem& problem) {
  std::fill(centroids_.begin(), centroids_.end(), 0.0);
  std::fill(counts_.begin(), counts_.end(), 0);
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] < 0) continue;
    ++counts_[cluster_[i]];
    for (int k = 0; k < 3; ++k) centroids_[3 * cluster_[i] + k] += problem.packets[i].c[k];
  }
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] < 0) continue;
    const Eigen::Map<const Vector3> sum(centroids_.data() + 3 * cluster_[i]);
    const Eigen::Map<const Vector3> center(problem.packets[i].c);
    const CanonicalModes canonical = canonical_modes(center - sum / counts_[cluster_[i]]);
    Modes modes(modes_.data() + i * 9 * kModes);
    modes.setZero();
    const int size = cameras_.size(static_cast<int>(i));
    const Rows B(cameras_.map(static_cast<int>(i)).values);
    if (size == 9) {
      modes = B.leftCols<9>().partialPivLu().solve(canonical);
    } else {  // the nearest motion that the free columns allow
      modes.topRows(size) = B.leftCols(size).householderQr().solve(canonical);
    }
  }
}

// ZᵀSZ, block row by block row.
void TwoLevel::form_coarse(const SchurSystem& system) {
  const SchurPattern& pattern = system.pattern();
  const Eigen::Index n = kModes * num_clusters_;
  Eigen::Map<Eigen::MatrixXd> coarse(coarse_.data(), n, n);
  coarse.setZero();
  for (std::int32_t i = 0; i < pattern.num_cameras(); ++i) {
    const ConstModes Z_i(modes_.data() + std::size_t{9 * kModes} * i);
    for (auto b = pattern.starts[i]; b < pattern.starts[i + 1]; ++b) {
      const std::int32_t k = pattern.columns[b];
      const ConstModes Z_k(modes_.data() + std::size_t{9 * kModes} * k);
      const Rows S_ik(system.blocks()[b].values);
      const Eigen::Matrix<double, 9, 7> S_Z = S_ik.leftCols<9>() * Z_k;
      const Eigen::Matrix<double, 7, 7> block = Z_i.transpose() * S_Z;
      const Eigen::Index row = kModes * cluster_[i];
      const Eigen::Index column = kModes * cluster_[k];
      coarse.block<7, 7>(row, column) += block;
      if (k != i) coarse.block<7, 7>(column, row) += block.transpose();
    }
  }
}

void TwoLevel::prepare(const SchurSystem& system, const DampedProblem& problem) {
  fine_.prepare(system, problem);
  set_modes(problem);
  form_coarse(system);
  const int n = kModes * num_clusters_;
  Eigen::Map<Eigen::MatrixXd> coarse(coarse_.data(), n, n);
  for (int k = 0; k < n; ++k) {
    const double diagonal = coarse(k, k);
    scales_[k] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 0.0;
  }
  const Eigen::Map<const Eigen::VectorXd> scales(scales_.data(), n);
  for (int k = 0; k < n; ++k) coarse.col(k).array() *= scales.array() * scales[k];
  for (int k = 0; k < n; ++k) coarse(k, k) = 1.0 + kRegularization;
  has_coarse_ = factor_dense(coarse_.data(), n);
}

void TwoLevel::apply(const double* r, double* z) {
  fine_.apply(r, z);
  if (!has_coarse_) return;
  std::fill(restricted_.begin(), restricted_.end(), 0.0);
  const auto rows = [](auto* values, std::size_t i) {
    return Eigen::Map<
        std::conditional_t<std::is_const_v<std::remove_pointer_t<decltype(values)>>,
                           const Eigen::Matrix<double, 9, 1>, Eigen::Matrix<double, 9, 1>>>(
        values + i * kRow);
  };
  const auto coarse = [&](std::size_t i) {
    return Eigen::Map<Eigen::Matrix<double, 7, 1>>(restricted_.data() + kModes * cluster_[i]);
  };
  const auto modes = [&](std::size_t i) { return ConstModes(modes_.data() + i * 9 * kModes); };
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] >= 0) coarse(i) += modes(i).transpose() * rows(r, i);
  }
  const auto n = static_cast<int>(restricted_.size());
  for (int k = 0; k < n; ++k) restricted_[k] *= scales_[k];
  solve_dense(coarse_.data(), n, restricted_.data());
  for (int k = 0; k < n; ++k) restricted_[k] *= scales_[k];
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] >= 0) rows(z, i) += modes(i) * coarse(i);
  }
}

}  // namespace raylign::native
