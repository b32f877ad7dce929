// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/covariance.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/geometry/se3.h"
#include "raylign/photometric/reduced_covariance.h"

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

// Second moments of a point's part of the gradient, over v: what H would be if all noise were
// independent and everywhere, less what is not.
struct PointNoise {
  PointBlock point;         // (d, d)
  PointColumns cross;       // (d, L) of the point's gradient and the reduced one, stored transposed
  Eigen::MatrixXd reduced;  // (L, L)
};

PointNoise point_noise(const PointSystem& system, const ReducedPoint& reduced, double share) {
  const Eigen::MatrixXd S = system.H - reduced.Y * system.W.transpose();
  const Eigen::MatrixXd host = system.host - system.host_point * reduced.Y.transpose();
  const Eigen::MatrixXd shared = system.shared - system.shared_point * reduced.Y.transpose();
  const PointColumns prior = reduced.Y * system.prior;
  const PointBlock host_point = system.host_point.transpose() * system.host_point;
  const PointColumns host_cross = host.transpose() * system.host_point;
  const Eigen::MatrixXd of_images = S - host.transpose() * host;
  PointNoise noise;
  noise.reduced =
      of_images - share * (of_images - prior * reduced.Y.transpose() - shared.transpose() * shared);
  noise.cross =
      -host_cross - share * (prior - host_cross - shared.transpose() * system.shared_point);
  noise.point = system.V - host_point -
                share * (system.V - host_point - system.prior -
                         system.shared_point.transpose() * system.shared_point);
  return noise;
}

// P Σ P of gradients of variance 1, P taking out what the point can follow.
Eigen::MatrixXd reduced_steepness(const PointSystem& system, const ReducedPoint& reduced) {
  const Eigen::MatrixXd half = system.steep_W * reduced.Y.transpose();
  return system.steep_H - half - half.transpose() +
         reduced.Y * system.steep_V * reduced.Y.transpose();
}

// Variance of the interpolated gradient, mean over the position in the cell, for noise of variance
// one: of white noise through the interpolant's frequency response.
double gradient_noise_gain(SampleInterpolation interpolation) {
  switch (interpolation) {
    case SampleInterpolation::CUBIC_BSPLINE:
      return 2.163;
    case SampleInterpolation::CENTRAL_DIFFERENCE:
      return 2.0 / 9.0;
    case SampleInterpolation::BILINEAR:
      break;
  }
  return 4.0 / 3.0;
}

// Noise of the gradients makes H larger than the curvature of the cost that it stands for by a
// share e, and C, in which H⁻¹ stands three times and H twice, too small by (1 − e)².
double gradient_noise_factor(SampleInterpolation interpolation,
                             double image_variance,
                             double steep_share) {
  const double share = gradient_noise_gain(interpolation) * image_variance * steep_share;
  const double rest = 1.0 - std::min(share, 0.5);  // beyond, nothing here is an expansion any more
  return 1.0 / (rest * rest);
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

}  // namespace

PhotometricCovariance photometric_covariance(const PatchScene& scene,
                                             const PatchConstraints& constraints,
                                             const PatchSolveOptions& options,
                                             const CovarianceOptions& covariance) {
  require_option(covariance.shared_noise <= 1.0, "CovarianceOptions.shared_noise", "<= 1",
                 covariance.shared_noise);
  const std::int64_t N = scene.num_points();
  const PatchColumns columns = patch_columns(scene, constraints);
  PointSystemBuilder builder(scene, columns, constraints, options.loss, options.scope);
  ResidualMoments moments;
  for (std::int64_t p = 0; p < N; ++p) add_point(scene, options, p, moments);

  PhotometricCovariance result;
  result.shared_noise = shared_noise_of(moments, covariance.shared_noise);
  result.overlap = overlap_of(scene);
  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(columns.size, columns.size);
  Eigen::MatrixXd B = S;
  Eigen::MatrixXd scattered = S;
  Eigen::MatrixXd steep = S;
  auto num_parameters = static_cast<double>(columns.size);
  for (std::int64_t p = 0; p < N; ++p) {
    const PointSystem& system = builder.build(p);
    const ReducedPoint reduced(system);
    num_parameters += static_cast<double>(system.V.rows() - reduced.nullity);
    scatter(system.columns, system.H - reduced.Y * system.W.transpose(), S);
    scatter(system.columns, point_noise(system, reduced, result.shared_noise).reduced, B);
    scatter(system.columns, reduced_steepness(system, reduced), steep);
    const Eigen::VectorXd gradient = system.gradient - reduced.Y * system.point_gradient;
    scatter(system.columns, gradient * gradient.transpose(), scattered);
  }
  const Eigen::MatrixXd priors = prior_information(scene, constraints, columns);
  S += priors;
  const SymmetricInverse inverse = invert_symmetric(S);
  result.free_directions = inverse.nullity;
  const double expected = inverse.inverse.cwiseProduct(B).sum();
  result.variance =
      expected > 0.0
          ? scattered_variance(moments, inverse.inverse.cwiseProduct(scattered).sum(), expected)
          : variance_of(moments, num_parameters);
  B += priors;
  result.variance *= gradient_noise_factor(
      scene.interpolation, (1.0 - result.shared_noise) * result.variance,
      inverse.inverse.cwiseProduct(steep).sum() / double(std::max<std::int64_t>(columns.size, 1)));
  const Eigen::MatrixXd of_columns = inverse.inverse * B * inverse.inverse;
  result.poses = result.variance * pose_covariance(columns, of_columns);
  if (!covariance.points) return result;

  result.points.resize(N, 9);
  for (std::int64_t p = 0; p < N; ++p) {
    const PointSystem& system = builder.build(p);
    const ReducedPoint reduced(system);
    Matrix3 C = Matrix3::Constant(std::numeric_limits<double>::quiet_NaN());
    if (reduced.nullity == 0 && !system.columns.empty()) {
      fill_point(world_point_motion(scene, columns, system, p), system, reduced,
                 point_noise(system, reduced, result.shared_noise), inverse.inverse, of_columns, C);
    }
    result.points.row(p) = result.variance * Eigen::Map<const Rows<double, 9>>(C.data(), 1, 9);
  }
  return result;
}

}  // namespace raylign
