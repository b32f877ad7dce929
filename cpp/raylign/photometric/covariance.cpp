// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/covariance.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/geometry/se3.h"
#include "raylign/photometric/reduced_covariance.h"
#include "raylign/photometric/sampled_noise.h"

namespace raylign {
namespace {

// Sums over the pixels of all edges but those of a patch in its own host.
struct ResidualMoments {
  double count = 0.0;
  double psi_squared = 0.0;  // ψ = ρ′ r
  double psi_slope = 0.0;    // ψ′ = ρ′ + 2 ρ″ r²
  double weight = 0.0;       // ρ′
  double cross = 0.0;        // Σ_v≠v′ ψ_v ψ_v′ of each pixel
  double cross_scale = 0.0;  // what that would be if ψ_v = ψ_v′
};

double slope(const Loss& loss, LossScope scope, double r, double squared_norm) {
  const LossValue law = loss.evaluate(scope == LossScope::PATCH ? squared_norm : r * r);
  return law.d_rho + 2.0 * law.d2_rho * r * r;
}

void add_point(const PatchScene& scene,
               const PatchSolveOptions& options,
               std::int64_t point,
               ResidualMoments& moments) {
  const int n = scene.pattern.size();
  std::array<double, PatchPattern::kMaxPixels> sum{}, squares{}, views{};
  for (std::int64_t e = scene.starts[point]; e < scene.starts[point + 1]; ++e) {
    const PatchEdge& edge = scene.edges[e];
    if (edge.image == scene.hosts[point]) continue;
    const EdgeSample sample = evaluate_edge(scene, point, edge);
    if (!sample.is_seen) continue;
    const auto weights = pixel_weights(edge, sample, n, options.loss, options.scope);
    double squared_norm = 0.0;
    for (int i = 0; i < n; ++i) squared_norm += sample.residual[i] * sample.residual[i];
    for (int i = 0; i < n; ++i) {
      if (!sample.counts(edge, i)) continue;
      const double psi = weights[i] * sample.residual[i];
      moments.count += 1.0;
      moments.weight += weights[i];
      moments.psi_slope += slope(options.loss, options.scope, sample.residual[i], squared_norm);
      sum[i] += psi;
      squares[i] += psi * psi;
      views[i] += 1.0;
    }
  }
  for (int i = 0; i < n; ++i) {
    moments.psi_squared += squares[i];
    moments.cross += sum[i] * sum[i] - squares[i];
    moments.cross_scale += (views[i] - 1.0) * squares[i];
  }
}

// v of independent residuals. The fit has taken `num_parameters` degrees of freedom out of them.
double variance_of(const ResidualMoments& moments, double num_parameters) {
  if (!(moments.count > num_parameters)) return std::numeric_limits<double>::quiet_NaN();
  const double mean_slope = moments.psi_slope / moments.count;
  return moments.psi_squared / (moments.count - num_parameters) * (moments.weight / moments.count) /
         (mean_slope * mean_slope);
}

// v from how the points' gradients of the reduced system scatter, against what B makes of it.
double scattered_variance(const ResidualMoments& moments, double found, double expected) {
  const double ratio = moments.weight / moments.psi_slope;
  return ratio * ratio * found / expected;
}

double shared_noise_of(const ResidualMoments& moments, double chosen) {
  if (chosen >= 0.0) return chosen;
  if (!(moments.cross_scale > 0.0)) return 0.0;
  return std::clamp(moments.cross / moments.cross_scale, 0.0, 1.0);
}

// Second moments of a point's part of the gradient, over v.
struct PointNoise {
  PointBlock point;         // (d, d)
  PointColumns cross;       // (d, L) of the point's gradient and the reduced one, stored transposed
  Eigen::MatrixXd reduced;  // (L, L)
};

// Zᵀ Σ Z of rows Z = J_c − J_p Yᵀ, from Jᵀ Σ J in blocks.
Eigen::MatrixXd reduced_by(const PointColumns& Y,
                           const Eigen::MatrixXd& H,
                           const PointColumns& W,
                           const PointBlock& V) {
  const Eigen::MatrixXd half = (W - 0.5 * Y * V) * Y.transpose();
  return H - half - half.transpose();
}

// Whose noise the gradient has, over v.
struct NoiseShares {
  double patch = 0.0;  // of a residual: the same in all images of a pixel
  double prior = 1.0;  // of a prior whose information is one
};

PointNoise point_noise(const PointSystem& system,
                       const ReducedPoint& reduced,
                       const NoiseShares& shares) {
  const PointColumns& Y = reduced.Y;
  const PointBlock V = system.V - system.prior;
  const PointBlock prior = shares.prior * system.prior;
  const Eigen::MatrixXd host = system.host - system.host_point * Y.transpose();
  const Eigen::MatrixXd shared = system.shared - system.shared_point * Y.transpose();
  const double own = 1.0 - shares.patch;
  PointNoise noise;
  noise.reduced = own * (reduced_by(Y, system.H, system.W, V) - host.transpose() * host) +
                  shares.patch * shared.transpose() * shared + Y * prior * Y.transpose();
  noise.cross = own * (system.W - Y * V - host.transpose() * system.host_point) +
                shares.patch * shared.transpose() * system.shared_point - Y * prior;
  noise.point = own * (V - system.host_point.transpose() * system.host_point) +
                shares.patch * system.shared_point.transpose() * system.shared_point + prior;
  return noise;
}

// Noise of the gradients adds to H what the cost does not have as curvature. At most this share is
// taken away again: beyond, nothing here is an expansion any more.
constexpr double kMaxNoiseShare = 0.5;

// Largest xᵀ A x / xᵀ B x of the directions that B has.
double largest_ratio(const PointBlock& A, const PointBlock& B) {
  if (B.rows() == 0) return 0.0;
  const Eigen::SelfAdjointEigenSolver<PointBlock> roots(invert_symmetric(B).inverse);
  const PointBlock whitened = roots.operatorSqrt() * A * roots.operatorSqrt();
  return Eigen::SelfAdjointEigenSolver<PointBlock>(whitened, Eigen::EigenvaluesOnly)
      .eigenvalues()
      .maxCoeff();
}

PointSystem without_gradient_noise(PointSystem system, double variance) {
  if (variance == 0.0) return system;
  const double share = largest_ratio(system.steep_V, system.V);
  if (share > 0.0) variance = std::min(variance, kMaxNoiseShare / share);
  system.H -= variance * system.steep_H;
  system.W -= variance * system.steep_W;
  system.V -= variance * system.steep_V;
  return system;
}

// `reduced`, or where that takes too much from `noisy` in some direction, the mean of all.
Eigen::MatrixXd without_gradient_noise(const Eigen::MatrixXd& noisy,
                                       const Eigen::MatrixXd& noisy_inverse,
                                       const Eigen::MatrixXd& reduced) {
  Eigen::MatrixXd rest = reduced - (1.0 - kMaxNoiseShare) * noisy;
  rest.diagonal() += 1e-9 * noisy.diagonal();  // what no edge determines
  if (rest.rows() == 0 || Eigen::LLT<Eigen::MatrixXd>(rest).info() == Eigen::Success) {
    return reduced;
  }
  const double share =
      noisy_inverse.cwiseProduct(noisy - reduced).sum() / static_cast<double>(noisy.rows());
  return (1.0 - std::min(share, kMaxNoiseShare)) * noisy;
}

// Of the priors on poses and brightness.
Eigen::MatrixXd prior_information(const PatchScene& scene,
                                  const PatchConstraints& constraints,
                                  const PatchColumns& columns) {
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(columns.size, columns.size);
  for (const PosePrior& prior : constraints.pose_priors) {
    const PatchPose& pose = scene.poses[prior.image];
    const Matrix4 T = pose.matrix();
    const Eigen::MatrixXd J = se3_left_jacobian_inverse(se3_log(T * se3_inverse(prior.T_cw))) *
                              columns.embeddings[prior.image];
    S.block(columns.poses[prior.image], columns.poses[prior.image], J.cols(), J.cols()) +=
        J.transpose() * prior.information * J;
  }
  for (const auto& brightness : columns.brightness) {
    if (brightness[0] >= 0) S(brightness[0], brightness[0]) += constraints.weight_a;
    if (brightness[1] >= 0) S(brightness[1], brightness[1]) += constraints.weight_b;
  }
  return S;
}

// Mean over the pixels that are read of how many reads have the same pixel nearest.
double overlap_of(const PatchScene& scene) {
  std::vector<std::vector<int>> reads;
  for (const auto& image : scene.images) {
    reads.emplace_back(static_cast<std::size_t>(image->width(0)) *
                       static_cast<std::size_t>(image->height(0)));
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      const PatchEdge& edge = scene.edges[e];
      const EdgeSample sample = evaluate_edge(scene, p, edge);
      if (!sample.is_seen || edge.level > 0) continue;
      for (int n = 0; n < scene.pattern.size(); ++n) {
        const auto& o = scene.pattern.offsets[n];
        const double u = sample.uv.x() + edge.A[0] * o[0] + edge.A[1] * o[1];
        const double v = sample.uv.y() + edge.A[2] * o[0] + edge.A[3] * o[1];
        const int width = scene.images[edge.image]->width(0);
        const int height = scene.images[edge.image]->height(0);
        const auto column = std::clamp(static_cast<int>(std::lround(u)), 0, width - 1);
        const auto row = std::clamp(static_cast<int>(std::lround(v)), 0, height - 1);
        ++reads[edge.image][static_cast<std::size_t>(row) * static_cast<std::size_t>(width) +
                            static_cast<std::size_t>(column)];
      }
    }
  }
  double sum = 0.0;
  double squares = 0.0;
  for (const std::vector<int>& image : reads) {
    for (const double count : image) {
      sum += count;
      squares += count * count;
    }
  }
  return sum > 0.0 ? squares / sum : 1.0;
}

void fill_point(const WorldPointMotion& motion,
                const PointSystem& system,
                const ReducedPoint& reduced,
                const PointNoise& noise,
                const Eigen::MatrixXd& S_inverse,
                const Eigen::MatrixXd& covariance,
                Eigen::Ref<Matrix3> out) {
  // δX = −A V⁻¹ g_p + K S⁻¹ g_r, of the gradients of the point and of the reduced system.
  const PointColumns by_gradient = motion.A * reduced.V_inverse;
  const Eigen::MatrixXd K = motion.A * reduced.Y.transpose() - motion.G;
  const Matrix3 cross =
      by_gradient * noise.cross.transpose() * gather(system.columns, S_inverse) * K.transpose();
  out = by_gradient * noise.point * by_gradient.transpose() - cross - cross.transpose() +
        K * gather(system.columns, covariance) * K.transpose();
}

// Sums over the points, each eliminated as if its gradients had noise of `gradient_variance` less.
struct ReducedSums {
  Eigen::MatrixXd S;          // curvature
  Eigen::MatrixXd B;          // what the gradient's covariance is expected to be, over v
  Eigen::MatrixXd scattered;  // what it is
  double num_free = 0.0;      // coordinates of points
};

ReducedSums sum_points(PointSystemBuilder& builder,
                       std::int64_t num_points,
                       Eigen::Index size,
                       const NoiseShares& shares,
                       double gradient_variance) {
  const Eigen::MatrixXd zero = Eigen::MatrixXd::Zero(size, size);
  ReducedSums sums = {zero, zero, zero};
  for (std::int64_t p = 0; p < num_points; ++p) {
    const PointSystem& system = builder.build(p);
    const PointSystem exact = without_gradient_noise(system, gradient_variance);
    const ReducedPoint reduced(exact);
    sums.num_free += static_cast<double>(system.V.rows() - reduced.nullity);
    scatter(system.columns, exact.H - reduced.Y * exact.W.transpose(), sums.S);
    scatter(system.columns, point_noise(system, reduced, shares).reduced, sums.B);
    const Eigen::VectorXd gradient = system.gradient - reduced.Y * system.point_gradient;
    scatter(system.columns, gradient * gradient.transpose(), sums.scattered);
  }
  return sums;
}

void validate(const CovarianceOptions& options) {
  require_option(options.shared_noise <= 1.0, "CovarianceOptions.shared_noise", "<= 1",
                 options.shared_noise);
  require_option(std::isfinite(options.presmooth) && options.presmooth >= 0.0,
                 "CovarianceOptions.presmooth", "finite and >= 0", options.presmooth);
  require_option(std::isfinite(options.prior_unit) && options.prior_unit >= 0.0,
                 "CovarianceOptions.prior_unit", "finite and >= 0", options.prior_unit);
}

}  // namespace

PhotometricCovariance photometric_covariance(const PatchScene& scene,
                                             const PatchConstraints& constraints,
                                             const PatchSolveOptions& options,
                                             const CovarianceOptions& covariance) {
  validate(covariance);
  const std::int64_t N = scene.num_points();
  const PatchColumns columns = patch_columns(scene, constraints);
  PointSystemBuilder builder(scene, columns, constraints, options.loss, options.scope);
  ResidualMoments moments;
  for (std::int64_t p = 0; p < N; ++p) add_point(scene, options, p, moments);

  PhotometricCovariance result;
  result.overlap = overlap_of(scene);
  result.shared_noise = shared_noise_of(moments, covariance.shared_noise);
  NoiseShares shares = {result.shared_noise, 0.0};
  const Eigen::MatrixXd priors = prior_information(scene, constraints, columns);
  const ReducedSums noisy = sum_points(builder, N, columns.size, shares, 0.0);
  const Eigen::MatrixXd noisy_S = noisy.S + priors;
  const SymmetricInverse noisy_inverse = invert_symmetric(noisy_S);
  result.free_directions = noisy_inverse.nullity;
  const double expected = noisy_inverse.inverse.cwiseProduct(noisy.B).sum();
  result.variance =
      expected > 0.0
          ? scattered_variance(moments, noisy_inverse.inverse.cwiseProduct(noisy.scattered).sum(),
                               expected)
          : variance_of(moments, static_cast<double>(columns.size) + noisy.num_free);
  shares.prior = covariance.prior_unit > 0.0 ? covariance.prior_unit / result.variance : 1.0;

  const double gradient_variance =
      SampledNoise(scene.interpolation, covariance.presmooth).mean_gradient() *
      (1.0 - result.shared_noise) * result.variance;
  const ReducedSums sums = sum_points(builder, N, columns.size, shares, gradient_variance);
  const Eigen::MatrixXd S_inverse =
      invert_symmetric(without_gradient_noise(noisy_S, noisy_inverse.inverse, sums.S + priors))
          .inverse;
  const Eigen::MatrixXd of_columns = S_inverse * (sums.B + shares.prior * priors) * S_inverse;
  result.poses = result.variance * pose_covariance(columns, of_columns);
  if (!covariance.points) return result;

  result.points.resize(N, 9);
  for (std::int64_t p = 0; p < N; ++p) {
    const PointSystem& system = builder.build(p);
    const ReducedPoint reduced(without_gradient_noise(system, gradient_variance));
    Matrix3 C = Matrix3::Constant(std::numeric_limits<double>::quiet_NaN());
    if (reduced.nullity == 0 && !system.columns.empty()) {
      fill_point(world_point_motion(scene, columns, system, p), system, reduced,
                 point_noise(system, reduced, shares), S_inverse, of_columns, C);
    }
    result.points.row(p) = result.variance * Eigen::Map<const Rows<double, 9>>(C.data(), 1, 9);
  }
  return result;
}

}  // namespace raylign
