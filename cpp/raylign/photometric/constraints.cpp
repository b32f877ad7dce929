// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/constraints.h"

#include <Eigen/LU>
#include <cmath>

#include "raylign/parametrization/constants.h"
#include "raylign/scene/bundle_problem.h"
#include "raylign/scene/bundle_scene.h"

namespace raylign::photometric {
namespace {

// The same cameras and points as a reprojection problem, whose observations are the candidates that
// are in view: what the rules of the gauge look at.
BundleProblem reprojection_twin(const Setting& setting, const PhotometricState& start) {
  const PhotometricProblem& problem = setting.problem;
  BundleProblem twin;
  twin.camera_model = CameraModel::PINHOLE;
  twin.T_cw = problem.T_cw;
  twin.points = problem.points;
  twin.intrinsics.resize(problem.num_images(), 4);
  for (std::int64_t i = 0; i < problem.num_images(); ++i) {
    twin.intrinsics.row(i) = problem.intrinsics.row(problem.intrinsics_row(i));
  }
  std::vector<std::int32_t> image, point;
  std::vector<Vector2> pixels;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    for (std::int64_t e = setting.candidates.starts[p]; e < setting.candidates.starts[p + 1]; ++e) {
      const std::int32_t j = setting.candidates.image[e];
      Vector2 uv;
      if (!start.project(j, problem.points.row(p), uv)) continue;
      if (!setting.prepared.images[j]->plane(0).contains(uv.x(), uv.y())) continue;
      image.push_back(j);
      point.push_back(static_cast<std::int32_t>(p));
      pixels.push_back(uv);
    }
  }
  const auto n = static_cast<Eigen::Index>(image.size());
  twin.camera_index = Eigen::Map<const Rows<std::int32_t, 1>>(image.data(), n);
  twin.point_index = Eigen::Map<const Rows<std::int32_t, 1>>(point.data(), n);
  twin.observations.resize(n, 2);
  for (Eigen::Index i = 0; i < n; ++i) twin.observations.row(i) = pixels[i];
  return twin;
}

void set_points(const Setting& setting, const Constants& held, PatchConstraints& constraints) {
  constraints.points.assign(setting.num_points(), !setting.options.refine_points);
  for (std::size_t p = 0; p < held.points.size(); ++p) {
    if (count_free(held.points[p]) == 3) continue;
    if (!all_held(held.points[p])) {
      throw OptionsError(
          "BundleConfig.constant_coordinates of a point must hold x, y and z in photometric bundle "
          "adjustment, point " +
          std::to_string(p) + " has one of them free");
    }
    constraints.points[p] = true;
  }
}

void set_cameras(const Setting& setting, const Constants& held, PatchConstraints& constraints) {
  constraints.poses = held.poses;
  if (!setting.options.refine_poses) {
    PoseMask all;
    all.translation.fill(true);
    all.rotation = true;
    constraints.poses.assign(held.poses.size(), all);
  }
  const bool refine = setting.options.refine_intrinsics;
  constraints.intrinsics.assign(setting.problem.intrinsics.rows(),
                                {!refine, !refine, !refine, !refine});
  for (std::size_t i = 0; i < held.intrinsics.size(); ++i) {
    auto& mask =
        constraints.intrinsics[setting.problem.intrinsics_row(static_cast<std::int64_t>(i))];
    for (int k = 0; k < 4; ++k) mask[k] = mask[k] || held.intrinsics[i][k];
  }
}

void set_brightness(const Setting& setting, PatchConstraints& constraints) {
  const BrightnessModel model = setting.options.brightness.model;
  constraints.brightness.assign(setting.problem.num_images(),
                                {model == BrightnessModel::NONE, model != BrightnessModel::AFFINE});
  const auto& hosts = setting.hosts.image;
  const bool has_stored =
      setting.problem.has_patches() && std::find(hosts.begin(), hosts.end(), -1) != hosts.end();
  if (!has_stored && !constraints.brightness.empty()) constraints.brightness.front() = {true, true};
}

template <int N>
Eigen::Matrix<double, N, N> inverse_of(const Rows<double, N * N>& table, Eigen::Index row) {
  const RowMajor<N, N> C = Eigen::Map<const RowMajor<N, N>>(table.row(row).data());
  return C.inverse();
}

void add_pose_priors(const Setting& setting,
                     const PhotometricState& start,
                     double unit,
                     PatchConstraints& constraints) {
  const auto& covariances = setting.problem.pose_covariances;
  for (Eigen::Index i = 0; i < covariances.rows(); ++i) {
    if (std::isnan(covariances(i, 0)) || constraints.poses[i].all()) continue;
    PosePrior prior;
    prior.image = static_cast<std::int32_t>(i);
    prior.T_cw = start.poses[i].matrix();
    prior.information = unit * inverse_of<6>(covariances, i);
    constraints.pose_priors.push_back(prior);
  }
}

// Information of the prior of point p in the world frame; zero without one.
Matrix3 point_information(const Setting& setting, const PhotometricState& start, std::int64_t p) {
  const PhotometricProblem& problem = setting.problem;
  Matrix3 information = Matrix3::Zero();
  if (problem.point_covariances.rows() > 0 && !std::isnan(problem.point_covariances(p, 0))) {
    information = inverse_of<3>(problem.point_covariances, p);
  }
  const std::int32_t host = setting.hosts.image[p];
  if (problem.depth_sigmas.rows() > 0 && !std::isnan(problem.depth_sigmas[p]) && host >= 0) {
    const Vector3 axis = start.poses[host].q.conjugate() * Vector3::UnitZ();
    information += axis * axis.transpose() / (problem.depth_sigmas[p] * problem.depth_sigmas[p]);
  }
  return information;
}

// dX/dρ = −z² R_hᵀ r_h: the prior of a point on its host's ray.
double inverse_depth_information(const Setting& setting,
                                 const PhotometricState& start,
                                 std::int64_t p,
                                 const Matrix3& information,
                                 double z) {
  const std::int32_t host = setting.hosts.image[p];
  const Vector3 along =
      z * z * (start.poses[host].q.conjugate() * start.ray(host, setting.hosts.uv.row(p)));
  return along.dot(information * along);
}

void add_point_priors(const Setting& setting,
                      const PhotometricState& start,
                      double unit,
                      PatchConstraints& constraints) {
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    const Matrix3 information = unit * point_information(setting, start, p);
    if (information.isZero(0.0) || constraints.points[p]) continue;
    PatchPointPrior prior;
    prior.point = p;
    prior.value = start.points.row(p).transpose();
    prior.information = information;
    if (setting.options.point_parametrization == PointParametrization::INVERSE_DEPTH) {
      const double z = start.in_camera(setting.hosts.image[p], start.points.row(p)).z();
      prior.value = Vector3(1.0 / z, 0.0, 0.0);
      prior.information.setZero();
      prior.information(0, 0) = inverse_depth_information(setting, start, p, information, z);
    }
    constraints.point_priors.push_back(prior);
  }
}

}  // namespace

PatchConstraints base_constraints(const Setting& setting,
                                  const PhotometricState& start,
                                  const BundleConfig& config) {
  const BundleProblem twin = reprojection_twin(setting, start);
  const BundleScene scene(twin);
  const Constants held = resolve_constants(scene, config);
  PatchConstraints constraints;
  set_cameras(setting, held, constraints);
  set_points(setting, held, constraints);
  set_brightness(setting, constraints);
  return constraints;
}

void set_priors(const Setting& setting,
                const PhotometricState& start,
                double unit,
                PatchConstraints& constraints) {
  const BrightnessOptions& brightness = setting.options.brightness;
  constraints.weight_a = unit / (brightness.prior_sigma_a * brightness.prior_sigma_a);
  constraints.weight_b = unit / (brightness.prior_sigma_b * brightness.prior_sigma_b);
  constraints.pose_priors.clear();
  constraints.point_priors.clear();
  add_pose_priors(setting, start, unit, constraints);
  add_point_priors(setting, start, unit, constraints);
}

double cost_unit(const Loss& loss, double sigma) {
  if (loss.type != LossType::STUDENT_T) return sigma * sigma;
  const double nu = loss.degrees_of_freedom;
  return loss.scale * loss.scale * nu / (nu + 1.0);
}

void hold_unused(const PatchScene& scene,
                 const std::vector<bool>& held,
                 PatchConstraints& constraints) {
  constraints.points = held;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    if (scene.starts[p] == scene.starts[p + 1]) constraints.points[p] = true;
  }
}

void hold_image(std::size_t i, PatchConstraints& constraints) {
  constraints.poses[i].translation.fill(true);
  constraints.poses[i].rotation = true;
  constraints.brightness[i] = {true, true};
}

std::string describe_gauge(const Setting& setting, const BundleConfig& config) {
  std::string text;
  const auto add = [&](const std::string& what) { text += (text.empty() ? "" : ", ") + what; };
  const PhotometricProblem& problem = setting.problem;
  if (config.gauge == Gauge::FIRST_CAMERA) add("first camera held");
  if (config.gauge == Gauge::TWO_CAMERAS) add("first camera and distance of the farthest held");
  if (!setting.options.refine_poses) add("all cameras held");
  if (!setting.options.refine_points) add("all points held");
  if (!config.constant_cameras.empty()) {
    add(std::to_string(config.constant_cameras.size()) + " cameras held by the config");
  }
  if (!config.constant_points.empty()) {
    add(std::to_string(config.constant_points.size()) + " points held by the config");
  }
  if (problem.pose_covariances.rows() > 0) add("priors of poses");
  if (problem.point_covariances.rows() > 0) add("priors of points");
  if (problem.depth_sigmas.rows() > 0) add("priors of depth");
  return text.empty() ? "free" : text;
}

}  // namespace raylign::photometric
