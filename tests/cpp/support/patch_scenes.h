// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/geometry/so3.h"
#include "raylign/parametrization/pose_update.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "support/named_rng.h"

namespace raylign::test {

struct PatchSceneOptions {
  int num_images = 5;
  int num_points = 40;
  int width = 160;
  int height = 120;
  SampleInterpolation interpolation = SampleInterpolation::CUBIC_BSPLINE;
  PatchBorder border = PatchBorder::REPLICATE;
  PatchPattern pattern = PatchPattern::square(4);
  bool hosted = true;  ///< patches belong to their host; else they are given, in true brightness
  bool inverse_depth = false;
  bool brightness = false;            ///< images differ by a in ±0.3, b in ±20
  bool intrinsics_per_image = false;  ///< else one row
  int level = 0;                      ///< of the pyramid, at which all edges are read
  double sigma = 0.0;                 ///< noise of the images, grey levels
  double noise_ratio = 0.0;           ///< PatchScene's
  int min_views = 3;                  ///< images that see a point, at least
};

/// The scene at the truth, and off it: inner images by about 0.3° and 6 mm, points by 2 % of their
/// depth, brightness by a third. The first and the last image stay at the truth.
struct PatchCase {
  PatchScene truth, start;
};

/// Two walls that meet in a vertical edge, z = 2 + |x| / 2, with a texture of sines in space, seen
/// by cameras on an arc: what a pixel shows is known to the last bit, nothing is hidden.
class PatchWorld {
 public:
  /// @param finest  shortest wavelength in scene units
  explicit PatchWorld(NamedRng& rng, double finest) {
    for (int i = 0; i < kNumWaves; ++i) {
      const double length = finest * std::pow(4.0, rng.uniform(0.0, 1.0));
      waves_.push_back({rng.unit_vector<3>() * (2.0 * M_PI / length), rng.uniform(0.0, 6.0)});
    }
  }
  double texture(const Vector3& X) const {
    double sum = 0.0;
    for (const Wave& wave : waves_) sum += std::sin(wave.k.dot(X) + wave.phase);
    return 128.0 + 20.0 * sum;
  }
  static Vector3 normal(const Vector3& X) { return {X.x() < 0.0 ? -0.5 : 0.5, 0.0, -1.0}; }
  /// Where the ray t + s d meets the walls.
  static Vector3 hit(const Vector3& t, const Vector3& d) {
    double s = -1e9;  // both walls are entered: the later entry counts
    for (const double slope : {-0.5, 0.5}) {
      const Vector3 n(slope, 0.0, -1.0);
      s = std::max(s, (-2.0 - n.dot(t)) / n.dot(d));
    }
    return t + s * d;
  }

 private:
  static constexpr int kNumWaves = 10;
  struct Wave {
    Vector3 k;
    double phase;
  };
  std::vector<Wave> waves_;
};

class PatchSceneBuilder {
 public:
  explicit PatchSceneBuilder(const PatchSceneOptions& options)
      : options_(options),
        rng_(make_rng("patch scene")),
        focal_(0.82 * options.width),
        // 12 px of the level that is read
        world_(rng_, 12.0 * std::ldexp(2.0 / focal_, options.level)) {
    place_cameras();
    for (int i = 0; i < options_.num_images; ++i) render(i);
    scene_.host_uv.resize(options_.num_points, 2);
    scene_.points.resize(options_.num_points, 3);
    scene_.starts = {0};
    for (int p = 0; p < options_.num_points; ++p) add_point(p);
  }

  PatchCase build() {
    PatchCase out{scene_, scene_};
    perturb(out.start);
    return out;
  }

 private:
  void place_cameras() {
    scene_.pattern = options_.pattern;
    scene_.interpolation = options_.interpolation;
    scene_.noise_ratio = options_.noise_ratio;
    scene_.inverse_depth = options_.inverse_depth;
    const int M = options_.num_images;
    const double last = std::max(1, M - 1);
    scene_.brightness.setZero(M, 2);
    scene_.intrinsics.resize(options_.intrinsics_per_image ? M : 1, 4);
    for (int i = 0; i < scene_.intrinsics.rows(); ++i) {
      scene_.intrinsics.row(i) << focal_ + 0.5 * i, 0.98 * focal_ - 0.3 * i,
          0.5 * options_.width - 0.7 + 0.2 * i, 0.5 * options_.height - 0.4;
    }
    for (int i = 0; i < M; ++i) {
      const double s = 2.0 * i / last - 1.0;  // −1 … 1 along the arc
      PatchPose pose;
      pose.q = quaternion_exp({0.03 * std::cos(3.0 * i), 0.1 * s, 0.04 * std::sin(2.0 * i)});
      pose.t = pose.q * Vector3(-0.25 * s, 0.08 * std::sin(2.5 * i), 0.05 * std::cos(2.0 * i));
      scene_.poses.push_back(pose);
      if (options_.brightness && i > 0) {
        scene_.brightness.row(i) << rng_.uniform(-0.3, 0.3), rng_.uniform(-20.0, 20.0);
      }
    }
  }

  Eigen::RowVector4d intrinsics(int i) const {
    return scene_.intrinsics.row(scene_.intrinsics_row(i));
  }
  Vector3 ray(int i, double u, double v) const {  // in the camera's frame
    const Eigen::RowVector4d k = intrinsics(i);
    return {(u - k[2]) / k[0], (v - k[3]) / k[1], 1.0};
  }
  Vector3 surface(int i, double u, double v) const {
    const PatchPose& pose = scene_.poses[i];
    const Quaternion R_wc = pose.q.conjugate();
    return PatchWorld::hit(-(R_wc * pose.t), R_wc * ray(i, u, v));
  }

  void render(int i) {
    const double gain = std::exp(-scene_.brightness(i, 0));
    const double b = scene_.brightness(i, 1);
    Plane<float> image(options_.width, options_.height);
    for (int v = 0; v < options_.height; ++v) {
      for (int u = 0; u < options_.width; ++u) {
        const double grey = gain * (world_.texture(surface(i, u, v)) - b);
        image.at(u, v) =
            static_cast<float>(options_.sigma > 0.0 ? grey + rng_.normal(options_.sigma) : grey);
      }
    }
    const ImageView view = {image.data(),
                            PixelType::FLOAT32,
                            options_.width,
                            options_.height,
                            1,
                            sizeof(float) * static_cast<std::size_t>(options_.width)};
    scene_.images.push_back(std::make_shared<PatchImage>(
        ImagePyramid(view, {options_.level + 1, 1}), options_.interpolation, options_.border));
  }

  void add_point(int p) {
    const int host = p % options_.num_images;
    const double margin = std::ldexp(6.0, options_.level);
    Vector3 X;
    Vector2 uv;
    do {
      uv = {rng_.uniform(margin, options_.width - margin),
            rng_.uniform(margin, options_.height - margin)};
      X = surface(host, uv.x(), uv.y());
    } while (std::abs(X.x()) < 5.0 * margin / focal_ ||
             count_views(X, margin) < options_.min_views);
    scene_.hosts.push_back(options_.hosted ? host : -1);
    scene_.host_uv.row(p) = uv.transpose();
    scene_.points.row(p) = X.transpose();
    const Vector3 X_h = in_camera(host, X);
    if (options_.inverse_depth) scene_.points.row(p) << 1.0 / X_h.z(), 0.0, 0.0;
    read_patch(host, uv);
    for (int i = 0; i < options_.num_images; ++i) {
      const bool own = i == host && options_.inverse_depth;  // sees nothing move
      if (!own && is_seen(i, X, margin)) scene_.edges.push_back(edge(i, host, X));
    }
    scene_.starts.push_back(scene_.num_edges());
  }

  Vector3 in_camera(int i, const Vector3& X) const {
    return scene_.poses[i].q * X + scene_.poses[i].t;
  }
  bool is_seen(int i, const Vector3& X, double margin) const {
    const Vector3 q = in_camera(i, X);
    const Eigen::RowVector4d k = intrinsics(i);
    const double u = k[0] * q.x() / q.z() + k[2];
    const double v = k[1] * q.y() / q.z() + k[3];
    return u > margin && u < options_.width - margin && v > margin && v < options_.height - margin;
  }
  int count_views(const Vector3& X, double margin) const {
    int count = 0;
    for (int i = 0; i < options_.num_images; ++i) count += is_seen(i, X, margin) ? 1 : 0;
    return count;
  }

  void read_patch(int host, const Vector2& uv) {
    const double scale = std::ldexp(1.0, -options_.level);
    const Vector2 centre = (uv + Vector2::Constant(0.5)) * scale - Vector2::Constant(0.5);
    const double a = options_.hosted ? 0.0 : scene_.brightness(host, 0);
    const double b = options_.hosted ? 0.0 : scene_.brightness(host, 1);
    for (const auto& o : scene_.pattern.offsets) {
      const double I =
          sample_patch_plane(scene_.images[host]->plane(options_.level), scene_.interpolation,
                             centre.x() + o[0], centre.y() + o[1])
              .value;
      scene_.patches.push_back(static_cast<float>(std::exp(a) * I + b));
    }
  }

  // ∂u_i / ∂u_h along the wall: photometric-bundle-adjustment, §2.
  PatchEdge edge(int i, int host, const Vector3& X) const {
    PatchEdge edge;
    edge.image = i;
    edge.level = options_.level;
    const Vector3 X_h = in_camera(host, X);
    const Vector3 n = scene_.poses[host].q * PatchWorld::normal(X);
    const Vector3 q = in_camera(i, X);
    const Eigen::RowVector4d k = intrinsics(i);
    const Eigen::RowVector4d k_h = intrinsics(host);
    RowMajor<2, 3> P;
    P << k[0] / q.z(), 0.0, -k[0] * q.x() / (q.z() * q.z()),  //
        0.0, k[1] / q.z(), -k[1] * q.y() / (q.z() * q.z());
    const Quaternion R = scene_.poses[i].q * scene_.poses[host].q.conjugate();
    for (int c = 0; c < 2; ++c) {
      const Vector3 d = (X_h.z() * Vector3::Unit(c) - X_h * (X_h.z() * n[c] / n.dot(X_h))) / k_h[c];
      const Vector2 column = P * (R * d);
      edge.A[c] = static_cast<float>(column[0]);
      edge.A[2 + c] = static_cast<float>(column[1]);
    }
    return edge;
  }

  void perturb(PatchScene& scene) {
    for (int i = 1; i + 1 < options_.num_images; ++i) {
      Vector6 xi;
      xi << rng_.normal_vector<3>(0.0035), rng_.normal_vector<3>(0.003);
      pose_plus(TranslationUpdate::COUPLED, {}, xi, scene.poses[i].q, scene.poses[i].t);
    }
    for (int p = 0; p < options_.num_points; ++p) {
      if (options_.inverse_depth) {
        scene.points(p, 0) *= 1.0 + rng_.normal(0.02);
      } else {  // about 2 % of the depth, on a ray of some image
        const Vector3 centre = -(scene.poses[p % options_.num_images].q.conjugate() *
                                 scene.poses[p % options_.num_images].t);
        const Vector3 X = scene.points.row(p).transpose();
        scene.points.row(p) = (X + rng_.normal(0.02) * (X - centre)).transpose();
      }
    }
    scene.brightness *= 2.0 / 3.0;
  }

  const PatchSceneOptions options_;
  NamedRng rng_;
  const double focal_;
  PatchWorld world_;
  PatchScene scene_;
};

inline PatchCase patch_case(const PatchSceneOptions& options = {}) {
  return PatchSceneBuilder(options).build();
}

/// The poses of the first and the last image held, brightness of the first; all brightness when
/// `brightness` is false, all intrinsics unless `intrinsics`.
inline PatchConstraints patch_constraints(const PatchScene& scene,
                                          bool brightness = false,
                                          bool intrinsics = false) {
  PatchConstraints held;
  const auto M = static_cast<std::size_t>(scene.num_images());
  held.poses.resize(M);
  held.poses.front() = held.poses.back() = {{true, true, true}, true};
  held.brightness.assign(M, {!brightness, !brightness});
  held.brightness.front() = {true, true};
  held.intrinsics.assign(static_cast<std::size_t>(scene.intrinsics.rows()),
                         {!intrinsics, !intrinsics, !intrinsics, !intrinsics});
  return held;
}

}  // namespace raylign::test
