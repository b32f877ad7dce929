// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
//
// Photometric bundle adjustment from C++: a room is rendered from five places, the cameras and the
// points are disturbed, and the grey values bring them back.
#include <cmath>
#include <cstdio>
#include <exception>
#include <memory>
#include <random>

#include "raylign/geometry/se3.h"
#include "raylign/photometric/adjuster.h"
#include "raylign/synthetic/render/renderer.h"
#include "raylign/synthetic/render/sensor.h"

namespace {

constexpr int kNumImages = 5;
constexpr int kWidth = 320;
constexpr int kHeight = 240;
constexpr double kFocal = 220.0;  // px
constexpr double kCu = 0.5 * (kWidth - 1);
constexpr double kCv = 0.5 * (kHeight - 1);
constexpr int kSpacing = 10;  // px between points

void set_pose(raylign::PhotometricProblem& problem, int i, const raylign::Matrix4& T) {
  const raylign::RowMajor<4, 4> rows = T;
  problem.T_cw.row(i) = Eigen::Map<const Eigen::Matrix<double, 1, 16>>(rows.data());
}

raylign::Matrix4 true_pose(int i) {
  const double s = 2.0 * i / (kNumImages - 1.0) - 1.0;
  raylign::Vector6 xi;
  xi << 0.2 * s, 0.05 * std::sin(3.0 * s), -0.6, 0.0, 0.08 * s, 0.02 * s;
  return raylign::se3_inverse(raylign::se3_exp(xi));
}

// Images as an 8-bit camera takes them, and the depths behind them.
std::vector<raylign::RenderedFrame> render(raylign::PhotometricProblem& problem) {
  raylign::TextureOptions texture;
  texture.min_wavelength = 0.1;
  raylign::RenderScene room;
  room.add_box(raylign::Matrix4::Identity(), {4.0, 2.6, 4.0}, texture);
  raylign::RadtanCamera::Params camera = raylign::RadtanCamera::Params::Zero();
  camera.head<4>() << kFocal, kFocal, kCu, kCv;
  raylign::SensorOptions sensor;
  sensor.read_noise = 2.0;
  std::vector<raylign::RenderedFrame> frames;
  for (int i = 0; i < kNumImages; ++i) {
    frames.push_back(
        raylign::render_frame(room, raylign::RadtanCamera(camera), true_pose(i), kWidth, kHeight));
    sensor.gain = 0.1 * (i % 3);  // exposure changes from image to image
    const raylign::Image image = raylign::expose(frames.back().irradiance, sensor, 1, i);
    problem.images.push_back(std::make_shared<raylign::ImagePyramid>(image.view()));
  }
  return frames;
}

// A point per cell of a grid, its patch read from the images by turns; depths off by 2 %.
void add_points(const std::vector<raylign::RenderedFrame>& frames,
                std::mt19937& random,
                raylign::PhotometricProblem& problem) {
  std::normal_distribution<double> depth_error(1.0, 0.02);
  const int columns = (kWidth - 32) / kSpacing;
  const int rows = (kHeight - 32) / kSpacing;
  problem.points.resize(columns * rows, 3);
  problem.hosts.resize(columns * rows);
  problem.host_uv.resize(columns * rows, 2);
  for (int p = 0; p < columns * rows; ++p) {
    const int host = p % kNumImages;
    const int u = 16 + kSpacing * (p % columns);
    const int v = 16 + kSpacing * (p / columns);
    const double z = frames[host].depth(v, u) * depth_error(random);
    const Eigen::Vector4d q(z * (u - kCu) / kFocal, z * (v - kCv) / kFocal, z, 1.0);
    problem.points.row(p) = (raylign::se3_inverse(problem.pose(host)) * q).head<3>().transpose();
    problem.hosts[p] = host;
    problem.host_uv.row(p) << u, v;
  }
}

// Root mean square distance of the camera centres from the truth.
double centre_error(raylign::PhotometricProblem problem, const raylign::Rows<double, 16>& T_cw) {
  problem.T_cw = T_cw;
  double sum = 0.0;
  for (int i = 0; i < kNumImages; ++i) {
    const raylign::Matrix4 error =
        raylign::se3_inverse(problem.pose(i)) - raylign::se3_inverse(true_pose(i));
    sum += error.topRightCorner<3, 1>().squaredNorm();
  }
  return std::sqrt(sum / kNumImages);
}

int run() {
  std::mt19937 random(1);
  std::normal_distribution<double> noise(0.0, 1.0);
  raylign::PhotometricProblem problem;
  problem.intrinsics.resize(1, 4);
  problem.intrinsics << kFocal, kFocal, kCu, kCv;
  const auto frames = render(problem);
  problem.T_cw.resize(kNumImages, 16);
  for (int i = 0; i < kNumImages; ++i) {
    raylign::Vector6 xi = raylign::Vector6::Zero();
    const bool is_held = i == 0 || i == kNumImages - 1;
    for (int k = 0; k < 6 && !is_held; ++k) xi[k] = (k < 3 ? 0.01 : 0.005) * noise(random);
    set_pose(problem, i, raylign::se3_exp(xi) * true_pose(i));
  }
  add_points(frames, random, problem);

  raylign::BundleConfig config;
  config.constant_cameras = {0, kNumImages - 1};
  const raylign::PhotometricResult result =
      raylign::adjust(problem, config, raylign::PhotometricOptions());

  const double before = centre_error(problem, problem.T_cw);
  const double after = centre_error(problem, result.T_cw);
  std::printf("%s\naccepted            %s: %s\n", result.summary.full_report().c_str(),
              result.accepted ? "yes" : "no", result.reason.c_str());
  std::printf("noise               %.2f grey levels, nu %.1f\n", result.sigma, result.nu);
  std::printf("camera centres      %.2f mm off before, %.2f mm after\n", 1e3 * before, 1e3 * after);
  return result.accepted && after < 0.2 * before ? 0 : 1;
}

}  // namespace

int main() {
  try {
    return run();
  } catch (const std::exception& error) {  // raylign::Error for everything raised on purpose
    std::fprintf(stderr, "photometric_demo: %s\n", error.what());
    return 2;
  }
}
