// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cmath>
#include <memory>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/geometry/se3.h"
#include "raylign/photometric/adjuster.h"
#include "raylign/photometric/views.h"
#include "raylign/synthetic/render/renderer.h"
#include "raylign/synthetic/render/sensor.h"
#include "support/named_rng.h"

namespace raylign::test {

struct SmallRoomOptions {
  int num_images = 5;
  int spacing = 12;     ///< px between points, in each direction
  double extent = 0.2;  ///< cameras stand within ± this, m
  double sigma = 1.0;   ///< noise, grey levels
  double gain = 0.0;    ///< a and b of image i: ± these, signs alternating; none of image 0
  double bias = 0.0;
  bool with_board = false;  ///< a board stands in front of the far wall
  bool stored = false;      ///< patches are given instead of hosts
};

/// A rendered room of 4 x 2.6 x 4 m seen from its middle: points in the pixel centres of all images
/// by turns, exact.
class SmallRoom {
 public:
  static constexpr int kWidth = 200;
  static constexpr int kHeight = 150;

  explicit SmallRoom(const SmallRoomOptions& options = {}) : options_(options) {
    TextureOptions texture;
    texture.seed = 7;
    texture.min_wavelength = 0.12;
    RenderScene room;
    room.add_box(Matrix4::Identity(), {4.0, 2.6, 4.0}, texture);
    if (options.with_board) {
      texture.seed = 8;
      Matrix4 T_ws = Matrix4::Identity();
      T_ws(2, 3) = 1.0;
      room.add_rectangle(T_ws, 0.5, 0.5, texture);
    }
    truth_.intrinsics.resize(1, 4);
    truth_.intrinsics << kFocal, kFocal, 0.5 * (kWidth - 1), 0.5 * (kHeight - 1);
    truth_.T_cw.resize(options.num_images, 16);
    for (int i = 0; i < options.num_images; ++i) add_image(room, i);
    add_points();
  }

  /// Hosts, their pixels and normals are given.
  const PhotometricProblem& truth() const { return truth_; }

  /// Inner cameras turned by `degrees` and moved by `metres`, depths changed by a normal draw of
  /// share `depth`, points still on their hosts' rays.
  PhotometricProblem start(double degrees, double metres, double depth) const {
    NamedRng rng = make_rng("small room start");
    PhotometricProblem problem = truth_;
    for (int i = 1; i + 1 < options_.num_images; ++i) {
      Vector6 xi;
      xi << metres * rng.unit_vector<3>(), degrees * M_PI / 180.0 * rng.unit_vector<3>();
      set_pose(problem, i, se3_exp(xi) * truth_.pose(i));
    }
    for (std::int64_t p = 0; p < truth_.num_points(); ++p) {
      const int h = host_[p];
      const Vector3 q = (1.0 + rng.normal(depth)) *
                        (truth_.pose(h) * truth_.points.row(p).transpose().homogeneous()).head<3>();
      problem.points.row(p) =
          (se3_inverse(problem.pose(h)) * q.homogeneous()).head<3>().transpose();
    }
    return problem;
  }

  /// Root mean square error of the camera centres, m.
  double centre_error(const Rows<double, 16>& T_cw) const {
    PhotometricProblem other = truth_;
    other.T_cw = T_cw;
    double sum = 0.0;
    for (int i = 0; i < options_.num_images; ++i) {
      sum += (centre(other.pose(i)) - centre(truth_.pose(i))).squaredNorm();
    }
    return std::sqrt(sum / options_.num_images);
  }

  static void set_pose(PhotometricProblem& problem, int i, const Matrix4& T) {
    const RowMajor<4, 4> rows = T;
    problem.T_cw.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 16>>(rows.data());
  }
  /// First and last camera held.
  BundleConfig config() const {
    BundleConfig config;
    config.constant_cameras = {0, options_.num_images - 1};
    return config;
  }
  const std::vector<RenderedFrame>& frames() const { return frames_; }

 private:
  static constexpr double kFocal = 140.0;

  static Vector3 centre(const Matrix4& T) { return se3_inverse(T).topRightCorner<3, 1>(); }

  void add_image(const RenderScene& room, int i) {
    const double s = 2.0 * i / (options_.num_images - 1.0) - 1.0;
    Vector6 xi;
    xi << options_.extent * s, 0.3 * options_.extent * std::sin(3.0 * s), 0.0,
        0.01 * std::sin(2.0 * i), 0.1 * s, 0.02 * s;
    Matrix4 T_wc = se3_exp(xi);
    T_wc(2, 3) -= 0.6;
    const Matrix4 T_cw = se3_inverse(T_wc);
    set_pose(truth_, i, T_cw);
    RenderOptions render;
    render.antialiasing = Antialiasing::NONE;
    const RadtanCamera camera(
        RadtanCamera::Params((RadtanCamera::Params() << kFocal, kFocal, 0.5 * (kWidth - 1),
                              0.5 * (kHeight - 1), 0, 0, 0, 0, 0)
                                 .finished()));
    frames_.push_back(render_frame(room, camera, T_cw, kWidth, kHeight, render));
    SensorOptions sensor;
    sensor.format = PixelType::FLOAT32;
    sensor.read_noise = options_.sigma;
    sensor.gain = i == 0 ? 0.0 : (i % 2 == 0 ? 1.0 : -1.0) * options_.gain;
    sensor.bias = i == 0 ? 0.0 : (i % 2 == 0 ? -1.0 : 1.0) * options_.bias;
    const Image image = expose(frames_.back().irradiance, sensor, 3, i);
    truth_.images.push_back(std::make_shared<ImagePyramid>(image.view()));
  }

  void add_points() {
    const int M = options_.num_images;
    std::vector<Vector3> points, normals;
    std::vector<Vector2> pixels;
    for (int v = 10; v < kHeight - 10; v += options_.spacing) {
      for (int u = 10; u < kWidth - 10; u += options_.spacing) {
        const int h = static_cast<int>(points.size()) % M;
        const double z = frames_[h].depth(v, u);
        const Vector3 q(z * (u - 0.5 * (kWidth - 1)) / kFocal,
                        z * (v - 0.5 * (kHeight - 1)) / kFocal, z);
        points.push_back((se3_inverse(truth_.pose(h)) * q.homogeneous()).head<3>());
        normals.push_back(frames_[h].normal.row(v * kWidth + u).transpose());
        pixels.push_back({double(u), double(v)});
        host_.push_back(h);
      }
    }
    const auto N = static_cast<Eigen::Index>(points.size());
    truth_.points.resize(N, 3);
    truth_.normals.resize(N, 3);
    truth_.host_uv.resize(N, 2);
    truth_.hosts = Eigen::Map<const Rows<std::int32_t, 1>>(host_.data(), N);
    for (Eigen::Index p = 0; p < N; ++p) {
      truth_.points.row(p) = points[p];
      truth_.normals.row(p) = normals[p];
      truth_.host_uv.row(p) = pixels[p];
    }
    if (options_.stored) store_patches();
  }

  void store_patches() {
    const PatchPattern pattern = PatchPattern::square(4);
    truth_.patches.resize(truth_.num_points(), pattern.size());
    for (Eigen::Index p = 0; p < truth_.num_points(); ++p) {
      for (int n = 0; n < pattern.size(); ++n) {
        truth_.patches(p, n) = truth_.images[host_[p]]->level(0).at(
            static_cast<int>(truth_.host_uv(p, 0) + pattern.offsets[n][0]),
            static_cast<int>(truth_.host_uv(p, 1) + pattern.offsets[n][1]));
      }
    }
    truth_.hosts.resize(0);
    truth_.host_uv.resize(0, 2);
    truth_.normals.resize(0, 3);
  }

  SmallRoomOptions options_;
  PhotometricProblem truth_;
  std::vector<std::int32_t> host_;
  std::vector<RenderedFrame> frames_;
};

/// What find_views and its like ask for.
struct SmallSetting {
  explicit SmallSetting(const PhotometricProblem& problem, const PhotometricOptions& options = {})
      : options_(options),
        pool(1),
        state(photometric::start_state(problem)),
        setting{problem, options_, pool, photometric::prepare_images(problem, options_), {}, {}} {
    setting.hosts = photometric::choose_hosts(problem, options_, setting.prepared, state);
    setting.candidates = photometric::list_candidates(problem, options_, setting.hosts);
  }

 private:
  PhotometricOptions options_;

 public:
  ThreadPool pool;
  photometric::PhotometricState state;
  photometric::Setting setting;
};

}  // namespace raylign::test
