// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/patch_scene.h"

#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/camera/pinhole.h"
#include "raylign/geometry/se3.h"
#include "raylign/residuals/photometric.h"
#include "raylign/residuals/reprojection.h"

namespace raylign {
namespace {

void require_shape(bool ok, const std::string& what) {
  if (!ok) throw ShapeError("PatchScene: " + what);
}

PinholeCamera camera_of(const PatchScene& scene, std::int64_t image) {
  return PinholeCamera(
      PinholeCamera::Params(scene.intrinsics.row(scene.intrinsics_row(image)).transpose()));
}

Vector3 host_ray(const PatchScene& scene, std::int64_t p) {
  const PinholeCamera camera = camera_of(scene, scene.hosts[p]);
  return {(scene.host_uv(p, 0) - camera.cx()) / camera.fx(),
          (scene.host_uv(p, 1) - camera.cy()) / camera.fy(), 1.0};
}

Matrix4 host_to_image(const PatchScene& scene, std::int64_t point, const PatchEdge& edge) {
  return scene.poses[edge.image].matrix() * se3_inverse(scene.poses[scene.hosts[point]].matrix());
}

// A positive multiple of the point in the camera's frame: X itself, or with inverse depth
// R_jh ray + ρ t_jh.
Vector3 camera_point(const PatchScene& scene, std::int64_t point, const PatchEdge& edge) {
  if (!scene.inverse_depth) {
    const PatchPose& pose = scene.poses[edge.image];
    return pose.q * scene.points.row(point).transpose() + pose.t;
  }
  const Matrix4 T = host_to_image(scene, point, edge);
  return T.topLeftCorner<3, 3>() * host_ray(scene, point) +
         scene.points(point, 0) * T.topRightCorner<3, 1>();
}

}  // namespace

Matrix4 PatchPose::matrix() const {
  Matrix4 T = Matrix4::Identity();
  T.topLeftCorner<3, 3>() = q.toRotationMatrix();
  T.topRightCorner<3, 1>() = t;
  return T;
}

void PatchScene::validate() const {
  const auto M = images.size();
  const std::int64_t N = num_points();
  require_shape(poses.size() == M && brightness.rows() == static_cast<std::int64_t>(M),
                "images, poses and brightness must have one row per image");
  require_shape(intrinsics.rows() == 1 || intrinsics.rows() == static_cast<std::int64_t>(M),
                "intrinsics must have one row, or one per image");
  require_shape(static_cast<std::int64_t>(starts.size()) == N + 1 && starts.front() == 0 &&
                    starts.back() == num_edges(),
                "starts must lead from 0 to the number of edges, one more than points");
  require_shape(points.rows() == N && host_uv.rows() == N &&
                    static_cast<std::int64_t>(patches.size()) == N * pattern.size(),
                "points, hosts, host_uv and patches must have one row per point");
  pattern.validate();
  require_option(std::isfinite(noise_ratio) && noise_ratio >= 0.0, "PatchScene.noise_ratio",
                 "finite and >= 0", noise_ratio);
  for (const auto& image : images) require_shape(image != nullptr, "an image is missing");
  for (std::int64_t p = 0; p < N; ++p) {
    require_shape(starts[p] <= starts[p + 1], "starts must not fall");
    require_shape(hosts[p] >= -1 && hosts[p] < num_images(), "a host must be an image or -1");
    if (inverse_depth && hosts[p] < 0) {
      throw OptionsError("inverse depth needs a host image for every point, point " +
                         std::to_string(p) + " has none");
    }
  }
  for (const PatchEdge& edge : edges) {
    require_shape(edge.image >= 0 && edge.image < num_images(), "an edge must name an image");
    require_shape(edge.level >= 0 && edge.level < images[edge.image]->num_levels(),
                  "an edge must name a level of its image");
  }
}

Vector3 world_point(const PatchScene& scene, std::int64_t p) {
  if (!scene.inverse_depth) return scene.points.row(p).transpose();
  const PatchPose& host = scene.poses[scene.hosts[p]];
  return host.q.conjugate() * (host_ray(scene, p) / scene.points(p, 0) - host.t);
}

EdgeBrightness edge_brightness(const PatchScene& scene, std::int64_t point, const PatchEdge& edge) {
  const std::int32_t host = scene.hosts[point];
  const double a_h = host < 0 ? 0.0 : scene.brightness(host, 0);
  const double b_h = host < 0 ? 0.0 : scene.brightness(host, 1);
  EdgeBrightness brightness;
  brightness.gain = std::exp(scene.brightness(edge.image, 0) - a_h);
  brightness.host_gain = std::exp(-a_h);
  brightness.offset = brightness.host_gain * (scene.brightness(edge.image, 1) - b_h);
  const double of_image = scene.noise_ratio * brightness.gain * brightness.gain;
  brightness.scale = std::sqrt((1.0 + scene.noise_ratio) / (1.0 + of_image));
  brightness.fall = of_image / (1.0 + of_image);
  return brightness;
}

std::array<double, 2> EdgeSample::by_brightness(int n) const {
  const auto i = static_cast<std::size_t>(n);
  return {-(brightness.scale * value[i] + brightness.fall * residual[i]),
          -brightness.scale * brightness.host_gain};
}

std::array<double, 2> EdgeSample::by_host_brightness(int n) const {
  const auto [a, b] = by_brightness(n);
  return {brightness.scale * brightness.offset - a, -b};
}

EdgeSample evaluate_edge(const PatchScene& scene, std::int64_t point, const PatchEdge& edge) {
  EdgeSample sample;
  sample.q = camera_point(scene, point, edge);
  const bool any_depth = std::isinf(scene.min_depth);  // then only the plane z = 0 is out of view
  if (!(any_depth ? sample.q.z() != 0.0 : sample.q.z() > scene.min_depth)) return sample;
  const PinholeCamera camera = camera_of(scene, edge.image);
  sample.uv = {camera.fx() * sample.q.x() / sample.q.z() + camera.cx(),
               camera.fy() * sample.q.y() / sample.q.z() + camera.cy()};
  sample.brightness = edge_brightness(scene, point, edge);
  const PatchPlane& plane = scene.images[edge.image]->plane(edge.level);
  const double scale = std::ldexp(1.0, -edge.level);
  const double slope = sample.brightness.scale * sample.brightness.gain * scale;
  Vector2 centre = (sample.uv.array() + 0.5) * scale - 0.5;  // px of the level
  if (scene.interpolation == SampleInterpolation::CENTRAL_DIFFERENCE) {
    centre = centre.cast<float>().cast<double>();  // as the original exercise
  }
  const float* c = scene.patch(point);
  EdgeSample out = sample;
  for (int n = 0; n < scene.pattern.size(); ++n) {
    const auto& o = scene.pattern.offsets[n];
    const double u = centre.x() + edge.A[0] * o[0] + edge.A[1] * o[1];
    const double v = centre.y() + edge.A[2] * o[0] + edge.A[3] * o[1];
    if (!plane.contains(u, v)) return sample;
    const Sample<double> I = sample_patch_plane(plane, scene.interpolation, u, v);
    out.value[n] = sample.brightness.gain * I.value;
    out.gradient[n] = {slope * I.du, slope * I.dv};
    if (!out.counts(edge, n)) continue;
    out.residual[n] = sample.brightness.scale *
                      photometric_residual<double>(c[n], I.value, sample.brightness.gain,
                                                   sample.brightness.offset);
  }
  out.is_seen = true;
  return out;
}

EdgeMotion edge_motion(const PatchScene& scene,
                       std::int64_t point,
                       const PatchEdge& edge,
                       const EdgeSample& sample) {
  const PinholeCamera camera = camera_of(scene, edge.image);
  const Vector3& q = sample.q;
  const double inverse_z = 1.0 / q.z();
  const double x = q.x() * inverse_z;
  const double y = q.y() * inverse_z;
  RowMajor<2, 3> J_q;
  J_q << camera.fx() * inverse_z, 0.0, -camera.fx() * x * inverse_z,  //
      0.0, camera.fy() * inverse_z, -camera.fy() * y * inverse_z;
  EdgeMotion motion;
  motion.intrinsics << x, 0.0, 1.0, 0.0,  //
      0.0, y, 0.0, 1.0;
  motion.host_pose.setZero();
  motion.host_intrinsics.setZero();
  if (!scene.inverse_depth) {
    motion.pose = pose_jacobian(J_q, q);
    motion.point = point_jacobian(J_q, scene.poses[edge.image].q.toRotationMatrix());
    return motion;
  }
  const Matrix4 T = host_to_image(scene, point, edge);
  motion.pose = pose_jacobian(J_q, q, scene.points(point, 0));
  motion.host_pose = -motion.pose * se3_adjoint(T);
  motion.point.setZero();
  motion.point.col(0) = J_q * T.topRightCorner<3, 1>();
  const PinholeCamera host = camera_of(scene, scene.hosts[point]);
  const Vector3 ray = host_ray(scene, point);
  const RowMajor<2, 3> J_ray = J_q * T.topLeftCorner<3, 3>();
  motion.host_intrinsics.col(0) = J_ray.col(0) * (-ray.x() / host.fx());
  motion.host_intrinsics.col(1) = J_ray.col(1) * (-ray.y() / host.fy());
  motion.host_intrinsics.col(2) = J_ray.col(0) * (-1.0 / host.fx());
  motion.host_intrinsics.col(3) = J_ray.col(1) * (-1.0 / host.fy());
  return motion;
}

}  // namespace raylign
