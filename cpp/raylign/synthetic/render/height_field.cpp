// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/height_field.h"

#include <algorithm>
#include <cmath>

#include "raylign/base/error.h"

namespace raylign {

void HeightFieldOptions::validate() const {
  const auto require_positive = [](double value, const char* field) {
    require_option(value > 0.0 && std::isfinite(value), field, "finite and > 0", value);
  };
  require_positive(width, "HeightFieldOptions.width");
  require_positive(height, "HeightFieldOptions.height");
  require_option(amplitude >= 0.0 && std::isfinite(amplitude), "HeightFieldOptions.amplitude",
                 "finite and >= 0", amplitude);
  require_positive(min_wavelength, "HeightFieldOptions.min_wavelength");
  require_option(max_wavelength >= min_wavelength && std::isfinite(max_wavelength),
                 "HeightFieldOptions.max_wavelength", "finite and >= min_wavelength",
                 max_wavelength);
  require_option(num_waves >= 1 && num_waves <= 256, "HeightFieldOptions.num_waves", "in [1, 256]",
                 num_waves);
}

}  // namespace raylign

namespace raylign::render {
namespace {

constexpr double kPi = 3.141592653589793;
constexpr double kTolerance = 1e-14;  // of the depth

// Height and slope at many points: pads to the kernel's block.
class Batch {
 public:
  void resize(int size) {
    size_ = (size + kPointBlock - 1) / kPointBlock * kPointBlock;
    for (auto* array : {&x_, &y_, &z_, &value_, &by_x_, &by_y_, &by_z_}) array->assign(size_, 0.0);
  }
  void set(int i, double x, double y) {
    x_[i] = x;
    y_[i] = y;
  }
  void evaluate(const Waves& waves) {
    WavePoints points;
    points.size = size_;
    points.position[0] = x_.data();
    points.position[1] = y_.data();
    points.position[2] = z_.data();
    double* gradient[3] = {by_x_.data(), by_y_.data(), by_z_.data()};
    sum_wave_gradients(waves, points, value_.data(), gradient);
  }
  double height(int i) const { return value_[i]; }
  double by_x(int i) const { return by_x_[i]; }
  double by_y(int i) const { return by_y_[i]; }

 private:
  int size_ = 0;
  std::vector<double> x_, y_, z_, value_, by_x_, by_y_, by_z_;
};

// A ray on its way to the surface.
struct Walker {
  int ray;
  double t, end;
  double side;   // sign of z − h at the start
  double speed;  // ‖d(x, y)/dt‖
};

class HeightField : public Surface {
 public:
  explicit HeightField(const HeightFieldOptions& options)
      : waves_(random_waves(options.seed,
                            0,
                            TextureSpace::PLANE,
                            options.num_waves,
                            options.min_wavelength,
                            options.max_wavelength,
                            options.amplitude)),
        half_width_(0.5 * options.width),
        half_height_(0.5 * options.height) {
    const Waves waves = waves_.view();
    for (int k = 0; k < waves.count; ++k) {
      const double amplitude = std::abs(waves.amplitude[k]);
      top_ += amplitude;
      const double frequency = kPi * std::hypot(waves.frequency[0][k], waves.frequency[1][k]);
      steepest_ += amplitude * frequency;
      sharpest_ += amplitude * frequency * frequency;
    }
  }

  int num_faces() const override { return 1; }
  Matrix3 texture_map(int) const override { return Vector3(1.0, 1.0, 0.0).asDiagonal(); }
  void normals(int, int size, const Vector3* p, Vector3* out) const override {
    Batch batch;
    batch.resize(size);
    for (int i = 0; i < size; ++i) batch.set(i, p[i].x(), p[i].y());
    batch.evaluate(waves_.view());
    for (int i = 0; i < size; ++i) out[i] = Vector3(-batch.by_x(i), -batch.by_y(i), 1.0);
  }

  void intersect(const Rays& rays, int first_face, Hits& hits) const override {
    constexpr int kMaxSteps = 4000;  // a ray that grazes the hills all along
    std::vector<Walker> walkers = start(rays, hits), next;
    Batch batch;
    for (int step = 0; step < kMaxSteps && !walkers.empty(); ++step) {
      evaluate(rays, walkers, batch);
      next.clear();
      for (std::size_t k = 0; k < walkers.size(); ++k) {
        Walker w = walkers[k];
        const double advance = safe_step(rays, batch, static_cast<int>(k), w);
        w.t += advance;
        if (advance <= kTolerance * std::max(1.0, w.t)) {
          hits.t[w.ray] = w.t;
          hits.face[w.ray] = first_face;
        } else if (w.t <= w.end) {
          next.push_back(w);
        }
      }
      walkers.swap(next);
    }
  }

 private:
  // Part of the ray inside the slab that holds the hills.
  std::vector<Walker> start(const Rays& rays, const Hits& hits) const {
    const Vector3 half(half_width_, half_height_, top_ + kNearest);
    std::vector<Walker> walkers;
    for (int i = 0; i < rays.size; ++i) {
      const Vector3& d = rays.direction[i];
      double begin = kNearest, end = hits.t[i];
      for (int axis = 0; axis < 3; ++axis) {
        const double a = (-half[axis] - rays.origin[axis]) / d[axis];
        const double b = (half[axis] - rays.origin[axis]) / d[axis];
        begin = std::max(begin, std::min(a, b));
        end = std::min(end, std::max(a, b));
      }
      if (!(begin < end)) continue;
      walkers.push_back({i, begin, end, 0.0, std::hypot(d.x(), d.y())});
    }
    return walkers;
  }

  void evaluate(const Rays& rays, const std::vector<Walker>& walkers, Batch& batch) const {
    batch.resize(static_cast<int>(walkers.size()));
    for (std::size_t k = 0; k < walkers.size(); ++k) {
      const Vector3 p = rays.origin + walkers[k].t * rays.direction[walkers[k].ray];
      batch.set(static_cast<int>(k), p.x(), p.y());
    }
    batch.evaluate(waves_.view());
  }

  // The longest step that cannot jump over the surface. With f = |z − h|, f' its slope along the
  // ray and C >= |f''|, f(t + s) >= f + f' s − C s² / 2, whose first root is the step: bracketing
  // far from the surface, Newton's method (of second order) close to it. Far away |f'| <= L gives
  // the longer step f / L.
  double safe_step(const Rays& rays, const Batch& batch, int k, Walker& w) const {
    const Vector3& d = rays.direction[w.ray];
    const double gap = rays.origin.z() + w.t * d.z() - batch.height(k);
    if (w.side == 0.0) w.side = gap < 0.0 ? -1.0 : 1.0;
    const double f = std::max(0.0, w.side * gap);
    const double slope = w.side * (d.z() - batch.by_x(k) * d.x() - batch.by_y(k) * d.y());
    const double curvature = sharpest_ * w.speed * w.speed;
    const double lipschitz = std::abs(d.z()) + steepest_ * w.speed;
    const double root = std::sqrt(slope * slope + 2.0 * curvature * f);
    // Two forms of the same root: each without cancellation for its sign of the slope.
    const double step = slope > 0.0 ? (slope + root) / curvature : 2.0 * f / (root - slope);
    return std::max(f / lipschitz, step);
  }

  WaveTable waves_;
  double half_width_, half_height_;
  double top_ = 0.0;       // bound of |h|
  double steepest_ = 0.0;  // bound of ‖∇h‖
  double sharpest_ = 0.0;  // bound of the second derivative along any direction
};

}  // namespace

std::shared_ptr<const Surface> make_height_field(const HeightFieldOptions& options) {
  return std::make_shared<HeightField>(options);
}

}  // namespace raylign::render
