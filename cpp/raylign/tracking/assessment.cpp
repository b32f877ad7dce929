// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/assessment.h"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/geometry/so3.h"

namespace raylign::tracking {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
// Fewer blocks than this say nothing about a covariance of six.
constexpr int kMinTiles = 12;

using Dense = Eigen::MatrixXd;

Dense select(const Matrix9& full, const std::vector<int>& columns) {
  const auto n = static_cast<Eigen::Index>(columns.size());
  Dense part(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) part(i, j) = full(columns[i], columns[j]);
  }
  return part;
}

// Σ over blocks of (g − ḡ)(g − ḡ)ᵀ, with the small-sample factor of cluster-robust estimates.
Matrix9 scatter_of_gradients(const std::vector<Vector9>& gradients) {
  Vector9 mean = Vector9::Zero();
  for (const Vector9& g : gradients) mean += g;
  const auto n = static_cast<double>(gradients.size());
  mean /= n;
  Matrix9 scatter = Matrix9::Zero();
  for (const Vector9& g : gradients) scatter += (g - mean) * (g - mean).transpose();
  return scatter * (n / (n - 1.0));
}

// The pose's block of a covariance over `columns`, in the 7x7 of [υ; ω; σ]; the rest is zero.
Matrix7 pose_block(const Dense& covariance, const std::vector<int>& columns) {
  Matrix7 block = Matrix7::Zero();
  for (std::size_t i = 0; i < columns.size(); ++i) {
    for (std::size_t j = 0; j < columns.size(); ++j) {
      if (columns[i] < 7 && columns[j] < 7) {
        block(columns[i], columns[j]) =
            covariance(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(j));
      }
    }
  }
  return block;
}

// Agreement beyond chance, Cohen's kappa: 1 when all points agree, 0 when no more do than by
// chance.
double agreement(const std::vector<TileSums>& tiles) {
  double pairs = 0.0;
  double agree = 0.0;
  double by_chance = 0.0;
  for (const TileSums& tile : tiles) {
    pairs += static_cast<double>(tile.pairs);
    agree += static_cast<double>(tile.agree);
    by_chance += static_cast<double>(tile.agree_by_chance);
  }
  return pairs > by_chance ? (agree - by_chance) / (pairs - by_chance) : 0.0;
}

double residual_variance(const TermSums& sums) {
  return sums.weight > 0.0 ? sums.weighted_square / sums.weight : -1.0;
}

// Eigenvalues of the information with translation in units of the mean depth.
void set_eigenvalues(const Matrix7& information,
                     const std::vector<int>& columns,
                     AlignmentResult& result) {
  std::vector<int> pose;
  for (const int k : columns) {
    if (k < 7) pose.push_back(k);
  }
  const auto n = static_cast<Eigen::Index>(pose.size());
  const double depth = 1.0 / result.mean_inverse_depth;
  Dense scaled(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      scaled(i, j) =
          information(pose[i], pose[j]) * (pose[i] < 3 ? depth : 1.0) * (pose[j] < 3 ? depth : 1.0);
    }
  }
  if (!scaled.allFinite()) return;
  const Eigen::SelfAdjointEigenSolver<Dense> solver(scaled);
  result.information_eigenvalues.assign(solver.eigenvalues().data(),
                                        solver.eigenvalues().data() + n);
  for (Eigen::Index i = 0; i < n; ++i)
    result.weakest_direction[pose[i]] = solver.eigenvectors()(i, 0);
}

std::string as_percent(double share) {
  return format_double(std::round(1000.0 * share) / 10.0) + " %";
}

struct Verdict {
  AlignmentStatus status = AlignmentStatus::OK;
  std::string reason;
};

Verdict judge_motion(const AcceptanceOptions& limits, const AlignmentResult& result) {
  const double translation = result.T_th.topRightCorner<3, 1>().norm() * result.mean_inverse_depth;
  const double scale = std::cbrt(result.T_th.topLeftCorner<3, 3>().determinant());
  const double rotation = so3_log(result.T_th.topLeftCorner<3, 3>() / scale).norm();
  if (!(translation <= limits.max_translation)) {
    return {AlignmentStatus::MOTION_BOUND,
            "translation is " + as_percent(translation) + " of the mean depth (max_translation)"};
  }
  if (!(rotation <= limits.max_rotation)) {
    return {AlignmentStatus::MOTION_BOUND,
            "rotation is " + format_double(rotation) + " rad (max_rotation)"};
  }
  return {};
}

// The standard deviation along the weakest direction, inflated as the block-wise covariance says.
Verdict judge_certainty(const AcceptanceOptions& limits, const AlignmentResult& result) {
  if (result.information_eigenvalues.empty() || !(result.information_eigenvalues.front() > 0.0)) {
    return {AlignmentStatus::DEGENERATE, "a direction of the pose has no information"};
  }
  double sigma = 1.0 / std::sqrt(result.information_eigenvalues.front());
  sigma *= std::sqrt(std::max(1.0, result.inflation));
  if (sigma <= limits.max_sigma) return {};
  return {AlignmentStatus::DEGENERATE, "standard deviation along the weakest direction is " +
                                           format_double(sigma) + " (max_sigma)"};
}

Verdict judge_agreement(const AcceptanceOptions& limits, const AlignmentResult& result) {
  if (!(result.good_ratio >= limits.min_good_ratio)) {
    return {AlignmentStatus::DIVERGED,
            as_percent(result.good_ratio) + " of the points in view agree (min_good_ratio)"};
  }
  if (!(result.agreement >= limits.min_agreement)) {
    return {AlignmentStatus::DIVERGED,
            "agreement beyond chance is " + format_double(result.agreement) + " (min_agreement)"};
  }
  return {};
}

}  // namespace

double over_dispersion(const BlockSums& blocks, const TrackingOptions& options, bool of_depth) {
  const NormalEquations equations =
      of_depth
          ? depth_equations(blocks.sums.depth, options.motion == MotionGroup::SIM3)
          : photometric_equations(blocks.sums.photometric, options.affine.mode != AffineMode::NONE);
  std::vector<Vector9> gradients;
  for (const TileSums& tile : blocks.tiles) {
    if (!(tile.count > 0.0F)) continue;
    Vector9 g = Vector9::Zero();
    for (int k = 0; k < 6; ++k)
      g[k] = static_cast<double>(of_depth ? tile.g_depth[k] : tile.g_photometric[k]);
    gradients.push_back(g);
  }
  if (gradients.size() < kMinTiles) return kNan;
  const Matrix6 H = equations.H.topLeftCorner<6, 6>();
  const Matrix6 S = scatter_of_gradients(gradients).topLeftCorner<6, 6>();
  return H.ldlt().solve(S).trace() / 6.0;
}

void set_uncertainty(const BlockSums& blocks,
                     const std::vector<int>& columns,
                     const TrackingOptions& options,
                     double depth_weight,
                     AlignmentResult& result) {
  const bool brightness = options.affine.mode != AffineMode::NONE;
  const bool with_scale = options.motion == MotionGroup::SIM3;
  const NormalEquations photometric = photometric_equations(blocks.sums.photometric, brightness);
  const NormalEquations depth = depth_equations(blocks.sums.depth, with_scale);
  const Dense H = select(photometric.H + depth_weight * depth.H, columns);
  const Dense inverse = H.ldlt().solve(Dense::Identity(H.rows(), H.cols()));
  if (!inverse.allFinite()) return;
  result.hessian_covariance = pose_block(inverse, columns);
  std::vector<int> pose;
  for (const int k : columns) {
    if (k < 7) pose.push_back(k);
  }
  const auto n = static_cast<Eigen::Index>(pose.size());
  const Dense information = Dense(inverse.topLeftCorner(n, n)).inverse();
  result.information = pose_block(information, pose);
  set_eigenvalues(result.information, columns, result);
  std::vector<Vector9> gradients;
  for (const TileSums& tile : blocks.tiles) {
    if (tile.count > 0.0F) gradients.push_back(tile_gradient(tile, depth_weight, with_scale));
  }
  if (gradients.size() < kMinTiles) return;
  const Dense S = select(scatter_of_gradients(gradients), columns);
  const Dense sandwich = inverse * S * inverse;
  result.covariance = pose_block(sandwich, columns);
  result.inflation = (information * sandwich.topLeftCorner(n, n)).trace() / static_cast<double>(n);
}

ReadoutEquation readout_equation(const std::vector<PassSums>& bands,
                                 const std::vector<Vector6>& twists,
                                 const std::vector<int>& columns,
                                 const TrackingOptions& options,
                                 double depth_weight) {
  const bool brightness = options.affine.mode != AffineMode::NONE;
  const bool with_scale = options.motion == MotionGroup::SIM3;
  Matrix9 H = Matrix9::Zero();
  Vector9 g = Vector9::Zero();
  Vector9 cross = Vector9::Zero();
  ReadoutEquation own;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const NormalEquations photometric = photometric_equations(bands[i].photometric, brightness);
    const NormalEquations depth = depth_equations(bands[i].depth, with_scale);
    const Matrix9 H_band = photometric.H + depth_weight * depth.H;
    const Vector9 g_band = photometric.g + depth_weight * depth.g;
    const Vector9 H_twist = H_band.leftCols<6>() * twists[i];
    H += H_band;
    g += g_band;
    cross += H_twist;
    own.information += twists[i].dot(H_twist.head<6>());
    own.gradient += twists[i].dot(g_band.head<6>());
  }
  // pose and brightness follow: the Schur complement
  const auto n = static_cast<Eigen::Index>(columns.size());
  Eigen::VectorXd c(n);
  Eigen::VectorXd r(n);
  for (Eigen::Index i = 0; i < n; ++i) {
    c[i] = cross[columns[i]];
    r[i] = g[columns[i]];
  }
  const Eigen::VectorXd follow = select(H, columns).ldlt().solve(c);
  own.information -= c.dot(follow);
  own.gradient -= r.dot(follow);
  const bool is_sound = std::isfinite(own.gradient) && own.information > 0.0;
  return is_sound ? own : ReadoutEquation{};
}

void set_agreement(const BlockSums& blocks, int num_points, AlignmentResult& result) {
  const PassSums& sums = blocks.sums;
  const double in_view = sums.photometric.count;
  result.num_points = num_points;
  result.overlap = num_points > 0 ? in_view / num_points : 0.0;
  result.usage = num_points > 0 ? sums.usage / num_points : 0.0;
  result.good_ratio = in_view > 0.0 ? sums.good / in_view : 0.0;
  result.agreement = agreement(blocks.tiles);
  result.residual_variance = residual_variance(sums.photometric);
  result.depth_residual_variance = residual_variance(sums.depth);
}

void set_status(const TrackingOptions& options, AlignmentResult& result) {
  const AcceptanceOptions& limits = options.acceptance;
  const Summary& last = result.levels.back().summary;
  Verdict verdict;
  if (!(result.overlap >= limits.min_overlap)) {
    verdict = {AlignmentStatus::LOST_OVERLAP,
               as_percent(result.overlap) + " of the points are in view (min_overlap)"};
  }
  if (verdict.status == AlignmentStatus::OK && last.termination == Termination::FAILURE) {
    verdict = {AlignmentStatus::DIVERGED, last.message};
  }
  if (verdict.status == AlignmentStatus::OK) verdict = judge_motion(limits, result);
  if (verdict.status == AlignmentStatus::OK) verdict = judge_agreement(limits, result);
  if (verdict.status == AlignmentStatus::OK) verdict = judge_certainty(limits, result);
  if (verdict.status == AlignmentStatus::OK && last.termination != Termination::CONVERGENCE) {
    verdict = {AlignmentStatus::NOT_CONVERGED, last.message};
  }
  result.status = verdict.status;
  result.reason = verdict.status == AlignmentStatus::OK ? "converged" : verdict.reason;
}

}  // namespace raylign::tracking
