// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/renderer.h"

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/base/portable_math.h"
#include "raylign/base/thread_pool.h"
#include "raylign/geometry/se3.h"
#include "raylign/synthetic/render/check_pose.h"
#include "raylign/synthetic/render/row_caster.h"

namespace raylign {
namespace {

using render::RowCaster;

constexpr int kBlockRows = 16;
constexpr int kMaxSide = 32766;

// Weights of the fine samples that make one pixel: the pixel's box blurred with the PSF. Taps run
// from `pad` samples before the pixel to `pad` behind it.
struct PixelFilter {
  int supersampling;
  int pad;
  std::vector<double> weights;
};

PixelFilter make_filter(int supersampling, double sigma) {
  constexpr double kReach = 4.0;  // σ
  constexpr int kBoxPoints = 32;  // midpoint rule for the blur of the box
  PixelFilter filter{
      supersampling, static_cast<int>(std::ceil(kReach * sigma * supersampling)), {}};
  double sum = 0.0;
  for (int k = -filter.pad; k < supersampling + filter.pad; ++k) {
    const double offset = (k + 0.5) / supersampling - 0.5;
    double weight = sigma > 0.0 ? 0.0 : 1.0;
    for (int j = 0; sigma > 0.0 && j < kBoxPoints; ++j) {
      const double x = (offset - ((j + 0.5) / kBoxPoints - 0.5)) / sigma;
      weight += x * x > 1400.0 ? 0.0 : portable::exp(-0.5 * x * x);
    }
    filter.weights.push_back(weight);
    sum += weight;
  }
  for (double& weight : filter.weights) weight /= sum;
  return filter;
}

// One frame in the making. Tasks are blocks of rows.
class Render {
 public:
  Render(const RenderScene& scene,
         const RadtanCamera& camera,
         const Matrix4& T_cw,
         int width,
         int height,
         const RenderOptions& options,
         const Vector6& motion)
      : scene_(scene),
        camera_(camera),
        T_cw_(T_cw),
        width_(width),
        height_(height),
        options_(options),
        motion_(motion),
        is_still_(motion.isZero(0.0)) {
    frame_.irradiance.resize(height, width);
    frame_.depth.resize(height, width);
    frame_.normal.resize(static_cast<Eigen::Index>(height) * width, 3);
    frame_.face.resize(height, width);
    if (options.antialiasing == Antialiasing::SUPERSAMPLE) {
      filter_ = make_filter(options.supersampling, options.psf_sigma);
    }
  }

  int num_blocks() const { return (height_ + kBlockRows - 1) / kBlockRows; }

  void run_block(int block) {
    const int begin = block * kBlockRows;
    const int end = std::min(height_, begin + kBlockRows);
    const bool supersampled = options_.antialiasing == Antialiasing::SUPERSAMPLE;
    const double footprint = options_.antialiasing == Antialiasing::NONE ? 0.0
                             : supersampled ? 1.0 / options_.supersampling
                                            : 1.0;
    RowCaster caster(scene_, camera_, footprint);
    for (int v = begin; v < end; ++v) {
      measure_row(v, caster);
      double* row = frame_.irradiance.row(v).data();
      if (!supersampled && !blurs()) {
        caster.shade(options_.background, row);  // the rays of measure_row
      } else if (!supersampled) {
        shade_row(0.0, 1.0, v, width_, caster, row);
      }
    }
    if (supersampled) supersample(begin, end, caster);
  }

  RenderedFrame take() { return std::move(frame_); }

 private:
  bool blurs() const { return !is_still_ && options_.exposure_time > 0.0; }

  Matrix4 pose_at(double v, double time) const {
    if (is_still_) return T_cw_;
    const double readout = options_.readout_time * ((v + 0.5) / height_ - 0.5);
    return se3_exp((readout + time) * motion_) * T_cw_;
  }

  void measure_row(int v, RowCaster& caster) {
    caster.cast(pose_at(v, 0.0), 0.0, 1.0, v, width_);
    caster.measure(frame_.depth.row(v).data(),
                   frame_.normal.row(static_cast<Eigen::Index>(v) * width_).data(),
                   frame_.face.row(v).data());
  }

  // Mean over the instants of the exposure.
  void shade_row(double u, double step, double v, int size, RowCaster& caster, double* out) const {
    const int count = blurs() ? options_.blur_samples : 1;
    std::vector<double> instant(size);
    std::fill_n(out, size, 0.0);
    for (int s = 0; s < count; ++s) {
      const double time = options_.exposure_time * ((s + 0.5) / count - 0.5);
      caster.cast(pose_at(v, count > 1 ? time : 0.0), u, step, v, size);
      caster.shade(options_.background, instant.data());
      for (int i = 0; i < size; ++i) out[i] += instant[i];
    }
    if (count > 1) std::for_each(out, out + size, [count](double& x) { x /= count; });
  }

  // Separable: fine rows are filtered along u as they come, then along v.
  void supersample(int begin, int end, RowCaster& caster) {
    const int ss = filter_.supersampling;
    const int num_taps = static_cast<int>(filter_.weights.size());
    const int fine_width = width_ * ss + 2 * filter_.pad;
    std::vector<double> fine(fine_width), narrow(width_);
    frame_.irradiance.middleRows(begin, end - begin).setZero();
    for (int j = begin * ss - filter_.pad; j < end * ss + filter_.pad; ++j) {
      const double first = (0.5 - filter_.pad) / ss - 0.5;
      shade_row(first, 1.0 / ss, (j + 0.5) / ss - 0.5, fine_width, caster, fine.data());
      for (int u = 0; u < width_; ++u) {
        double sum = 0.0;
        for (int k = 0; k < num_taps; ++k) sum += filter_.weights[k] * fine[u * ss + k];
        narrow[u] = sum;
      }
      for (int v = begin; v < end; ++v) {
        const int tap = j - v * ss + filter_.pad;
        if (tap < 0 || tap >= num_taps) continue;
        double* row = frame_.irradiance.row(v).data();
        for (int u = 0; u < width_; ++u) row[u] += filter_.weights[tap] * narrow[u];
      }
    }
  }

  const RenderScene& scene_;
  const RadtanCamera& camera_;
  const Matrix4 T_cw_;
  const int width_, height_;
  const RenderOptions options_;
  const Vector6 motion_;
  const bool is_still_;
  PixelFilter filter_{};
  RenderedFrame frame_;
};

void require_within(const char* field, double value, double low, double high) {
  const std::string rule = "in [" + format_double(low) + ", " + format_double(high) + "]";
  require_option(value >= low && value <= high, field, rule.c_str(), value);
}

}  // namespace

void RenderOptions::validate() const {
  require_within("RenderOptions.supersampling", supersampling, 1, 16);
  require_within("RenderOptions.psf_sigma", psf_sigma, 0.0, 5.0);
  require_within("RenderOptions.background", background, 0.0, 255.0);
  require_within("RenderOptions.exposure_time", exposure_time, 0.0, 1.0);
  require_within("RenderOptions.blur_samples", blur_samples, 1, 1024);
  require_within("RenderOptions.readout_time", readout_time, 0.0, 1.0);
  require_within("RenderOptions.num_threads", num_threads, 1, 1024);
}

RenderedFrame render_frame(const RenderScene& scene,
                           const RadtanCamera& camera,
                           const Matrix4& T_cw,
                           int width,
                           int height,
                           const RenderOptions& options,
                           const Vector6& motion) {
  options.validate();
  camera.validate();
  require_rigid("T_cw", T_cw);
  if (!motion.allFinite()) throw OptionsError("motion must be finite");
  if (std::min(width, height) < 1 || std::max(width, height) > kMaxSide) {
    throw ShapeError("width and height must be in [1, 32766], got " + std::to_string(width) +
                     " x " + std::to_string(height));
  }
  Render render(scene, camera, T_cw, width, height, options, motion);
  ThreadPool pool(options.num_threads);
  pool.run(render.num_blocks(), [&render](int block) { render.run_block(block); });
  return render.take();
}

}  // namespace raylign
