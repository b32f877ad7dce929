// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/two_level.h"

#include <Eigen/Dense>
#include <algorithm>
#include <atomic>
#include <cmath>

#include "raylign/base/eigen.h"
#include "raylign/solver/blocked_cholesky.h"
#include "raylign/solver/cholesky_kernels.h"

namespace raylign::native {
namespace {

constexpr int kMinClusterSize = 12;
// The coarse system stays small: a dense factor of 7 · 200 columns takes 0.02 s.
constexpr int kMaxClusters = 200;
// Relative to the diagonal: the gauge makes the coarse system as singular as the whole one.
constexpr double kRegularization = 1e-12;

using Rows = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;
using Modes = Eigen::Map<Eigen::Matrix<double, 9, kModeRow, Eigen::RowMajor>>;
using ConstModes = Eigen::Map<const Eigen::Matrix<double, 9, kModeRow, Eigen::RowMajor>>;
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
    : cameras_(context.cameras),
      pool_(context.pool),
      fine_(context.cameras, Preconditioner::SCHUR_JACOBI) {
  const std::int32_t count = pattern.num_cameras();
  cluster_ = cluster_cameras(pattern, std::max(kMinClusterSize, count / kMaxClusters + 1));
  for (const std::int32_t k : cluster_) num_clusters_ = std::max(num_clusters_, k + 1);
  members_.resize(num_clusters_);
  for (std::int32_t i = 0; i < count; ++i) {
    if (cluster_[i] >= 0) members_[cluster_[i]].push_back(i);
  }
  modes_.assign(static_cast<std::size_t>(count) * kModeSize, 0.0);
  const auto n = static_cast<std::size_t>(kModes * num_clusters_);
  panels_.assign(pool_.num_threads(), Table<double>(n * kModeRow));
  coarse_.resize(n * n);
  scales_.resize(n);
  restricted_.resize(n);
}

void TwoLevel::set_modes(int cluster, const DampedProblem& problem) {
  Vector3 centroid = Vector3::Zero();
  for (const std::int32_t i : members_[cluster]) {
    centroid += Eigen::Map<const Vector3>(problem.packets[i].c);
  }
  centroid /= static_cast<double>(members_[cluster].size());
  for (const std::int32_t i : members_[cluster]) {
    const Eigen::Map<const Vector3> center(problem.packets[i].c);
    const CanonicalModes canonical = canonical_modes(center - centroid);
    Modes modes(modes_.data() + std::int64_t{i} * kModeSize);
    const int size = cameras_.size(i);
    const Rows B(cameras_.map(i).values);
    if (size == 9) {
      modes.leftCols<kModes>() = B.leftCols<9>().partialPivLu().solve(canonical);
    } else {  // the nearest motion that the free columns allow; the other rows stay zero
      modes.topRows(size).leftCols<kModes>() = B.leftCols(size).householderQr().solve(canonical);
    }
  }
}

// The lower triangle of ZᵀSZ: each cluster has its columns to itself.
void TwoLevel::form_coarse(const SchurSystem& system) {
  const SchurPattern& pattern = system.pattern();
  const CoarseProjection projection{pattern.starts.data(), pattern.columns.data(),
                                    system.blocks().data(), modes_.data(), cluster_.data()};
  const std::int64_t n = kModes * std::int64_t{num_clusters_};
  std::atomic<int> next{0};
  pool_.run(pool_.num_threads(), [&](int worker) {
    Table<double>& panel = panels_[worker];
    for (int a = next++; a < num_clusters_; a = next++) {
      std::fill(panel.begin(), panel.end(), 0.0);
      for (const std::int32_t i : members_[a]) project_row(projection, i, panel.data());
      for (int m = 0; m < kModes; ++m) {
        double* column = coarse_.data() + (kModes * std::int64_t{a} + m) * n;
        for (std::int64_t row = 0; row < n; ++row) column[row] = panel[row * kModeRow + m];
      }
    }
  });
  pool_.run(num_clusters_, [&](int a) { add_mirror_images(a); });
}

// S has the blocks of its upper triangle only: what is below comes from the columns of the others,
// above the diagonal, where nobody writes by now.
void TwoLevel::add_mirror_images(int a) {
  const Eigen::Index n = kModes * num_clusters_;
  Eigen::Map<Eigen::MatrixXd> coarse(coarse_.data(), n, n);
  const Eigen::Index first = kModes * a;
  const Eigen::Index below = first + kModes;
  coarse.block<kModes, kModes>(first, first) +=
      coarse.block<kModes, kModes>(first, first).transpose().eval();
  coarse.block(below, first, n - below, kModes) +=
      coarse.block(first, below, kModes, n - below).transpose();
}

// To a unit diagonal, a little more than that.
void TwoLevel::scale_coarse() {
  const int n = kModes * num_clusters_;
  Eigen::Map<Eigen::MatrixXd> coarse(coarse_.data(), n, n);
  for (int k = 0; k < n; ++k) {
    const double diagonal = coarse(k, k);
    scales_[k] = diagonal > 0.0 ? 1.0 / std::sqrt(diagonal) : 0.0;
  }
  const Eigen::Map<const Eigen::VectorXd> scales(scales_.data(), n);
  for (int k = 0; k < n; ++k) {
    coarse.col(k).tail(n - k).array() *= scales.tail(n - k).array() * scales[k];
    coarse(k, k) = 1.0 + kRegularization;
  }
}

void TwoLevel::prepare(const SchurSystem& system, const DampedProblem& problem) {
  fine_.prepare(system, problem);
  pool_.run(num_clusters_, [&](int cluster) { set_modes(cluster, problem); });
  form_coarse(system);
  scale_coarse();
  has_coarse_ = factor_cholesky(coarse_.data(), kModes * num_clusters_, pool_);
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
  const auto modes = [&](std::size_t i) {
    return ConstModes(modes_.data() + i * kModeSize).leftCols<kModes>();
  };
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] >= 0) coarse(i) += modes(i).transpose() * rows(r, i);
  }
  const auto n = static_cast<int>(restricted_.size());
  for (int k = 0; k < n; ++k) restricted_[k] *= scales_[k];
  solve_in_registers(coarse_.data(), n, restricted_.data());
  for (int k = 0; k < n; ++k) restricted_[k] *= scales_[k];
  for (std::size_t i = 0; i < cluster_.size(); ++i) {
    if (cluster_[i] >= 0) rows(z, i) += modes(i) * coarse(i);
  }
}

}  // namespace raylign::native
