// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/cramer_rao.h"

#include <cmath>
#include <limits>
#include <string>

#include "raylign/base/error.h"
#include "raylign/photometric/reduced_covariance.h"

namespace raylign {
namespace {

// The scene with the coordinate that a point has on its host's ray.
PatchScene on_host_rays(PatchScene scene) {
  if (scene.inverse_depth) return scene;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    if (scene.hosts[p] < 0) {
      throw OptionsError("noisy patches need a host image for every point, point " +
                         std::to_string(p) + " has none");
    }
    const PatchPose& host = scene.poses[scene.hosts[p]];
    const Vector3 x = host.q * scene.points.row(p).transpose() + host.t;
    scene.points.row(p) = Vector3(1.0 / x.z(), 0.0, 0.0).transpose();
  }
  scene.inverse_depth = true;
  return scene;
}

// Eliminates the unknown grey values of a patch. The host's own edge says nothing: its ray is held.
PointSystem with_unknown_patch(const PointSystem& system) {
  PointSystem out = system;
  for (Eigen::Index n = 0; n < system.shared.rows(); ++n) {
    const double views = 1.0 + system.views[n];
    const auto camera = system.shared.row(n);
    const auto point = system.shared_point.row(n);
    out.H -= camera.transpose() * camera / views;
    out.W -= camera.transpose() * point / views;
    out.V -= point.transpose() * point / views;
  }
  return out;
}

Matrix3 center_covariance(const PatchPose& pose, const Eigen::MatrixXd& poses, Eigen::Index j) {
  const Matrix3 R_wc = pose.q.toRotationMatrix().transpose();  // c = −Rᵀ t moves by −Rᵀ υ
  return R_wc * poses.block<3, 3>(6 * j, 6 * j) * R_wc.transpose();
}

}  // namespace

void CramerRaoOptions::validate() const {
  require_option(std::isfinite(sigma) && sigma > 0.0, "CramerRaoOptions.sigma", "finite and > 0",
                 sigma);
}

CramerRaoBound cramer_rao(const PatchScene& truth,
                          const PatchConstraints& constraints,
                          const CramerRaoOptions& options) {
  options.validate();
  PatchScene scene = options.has_noisy_patches ? on_host_rays(truth) : truth;
  scene.noise_ratio = 0.0;  // whose noise a residual has is said by NoiseSite here
  const PatchColumns columns = patch_columns(scene, constraints);
  const double variance = options.sigma * options.sigma + (options.is_rounded ? 1.0 / 12.0 : 0.0);
  PatchConstraints without_priors = constraints;
  without_priors.point_priors.clear();
  PointSystemBuilder builder(scene, columns, without_priors, Loss{}, LossScope::PIXEL,
                             NoiseSite::IMAGE);
  const auto system_of = [&](std::int64_t p) {
    const PointSystem& system = builder.build(p);
    return options.has_noisy_patches ? with_unknown_patch(system) : system;
  };

  Eigen::MatrixXd S = Eigen::MatrixXd::Zero(columns.size, columns.size);
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const PointSystem system = system_of(p);
    const ReducedPoint reduced(system);
    scatter(system.columns, system.H - reduced.Y * system.W.transpose(), S);
  }
  const SymmetricInverse inverse = invert_symmetric(S);
  const Eigen::MatrixXd of_columns = variance * inverse.inverse;
  CramerRaoBound bound;
  bound.free_directions = inverse.nullity;
  bound.poses = pose_covariance(columns, of_columns);
  bound.centers.resize(scene.num_images(), 9);
  for (Eigen::Index j = 0; j < scene.num_images(); ++j) {
    const Matrix3 C = center_covariance(scene.poses[j], bound.poses, j);
    bound.centers.row(j) = Eigen::Map<const Rows<double, 9>>(C.data(), 1, 9);
  }
  bound.points.resize(scene.num_points(), 9);
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const PointSystem system = system_of(p);
    const ReducedPoint reduced(system);
    Matrix3 C = Matrix3::Constant(std::numeric_limits<double>::quiet_NaN());
    if (reduced.nullity == 0 && !system.columns.empty()) {
      const WorldPointMotion motion = world_point_motion(scene, columns, system, p);
      const Eigen::MatrixXd K = motion.A * reduced.Y.transpose() - motion.G;
      C = variance * motion.A * reduced.V_inverse * motion.A.transpose() +
          K * gather(system.columns, of_columns) * K.transpose();
    }
    bound.points.row(p) = Eigen::Map<const Rows<double, 9>>(C.data(), 1, 9);
  }
  return bound;
}

}  // namespace raylign
