// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/tracking/maps.h"

#include <algorithm>
#include <cmath>

#include "raylign/tracking/point.h"

namespace raylign::tracking {
namespace {

Plane<float> nan_plane(int width, int height) {
  Plane<float> plane(width, height);
  std::fill(plane.data(), plane.data() + plane.size(), NAN);
  return plane;
}

// The target seen from the keyframe, wherever the keyframe has depth.
Plane<float> warped_image(const Keyframe& keyframe,
                          const Frame& target,
                          int level,
                          const PassSettings& settings) {
  const Plane<float>& D = keyframe.frame().depth().inverse_depth(level);
  const Plane<float>& V = keyframe.frame().depth().variance(level);
  const PinholeCamera camera = keyframe.frame().camera(level);
  const PlaneView<float> image = target.images().level(level).view();
  const PointPose at = point_pose(settings);
  Plane<float> warped = nan_plane(D.width(), D.height());
  for (int v = 0; v < D.height(); ++v) {
    for (int u = 0; u < D.width(); ++u) {
      if (!(V.at(u, v) > 0.0F)) continue;
      const WarpedPoint<double> p =
          warp((u - camera.cx()) / camera.fx(), (v - camera.cy()) / camera.fy(),
               static_cast<double>(D.at(u, v)), at.pose);
      Sample<double> sample;
      if (!is_in_view(p, image.width, image.height)) continue;
      if (!sample_bilinear(image, p.u, p.v, sample)) continue;
      warped.at(u, v) = static_cast<float>(at.gain * sample.value + at.b);
    }
  }
  return warped;
}

}  // namespace

AlignmentMaps make_maps(const Keyframe& keyframe,
                        const Frame& target,
                        int level,
                        const PassSettings& settings) {
  const int width = keyframe.frame().width(level);
  const int height = keyframe.frame().height(level);
  AlignmentMaps maps;
  for (Plane<float>* plane :
       {&maps.residual, &maps.sigma, &maps.normalised_residual, &maps.weight}) {
    *plane = nan_plane(width, height);
  }
  maps.warped = warped_image(keyframe, target, level, settings);
  maps.mask.resize(width, height);
  std::fill(maps.mask.data(), maps.mask.data() + maps.mask.size(), static_cast<unsigned char>(0));
  const PointList& points = keyframe.points(level);
  const PointArrays arrays = points.arrays();
  const PointPose at = point_pose(settings);
  for (std::int64_t i = 0; i < points.padded_size(); ++i) {
    const std::int32_t pixel = points.pixels()[static_cast<std::size_t>(i)];
    PointResidual residual;
    if (pixel < 0 || !photometric_point(host_point(arrays, i), target.gradients(level).view(), at,
                                        settings, residual)) {
      continue;
    }
    const double sigma = std::sqrt(residual.variance);
    const double n = residual.r / sigma;
    maps.residual.data()[pixel] = static_cast<float>(residual.r);
    maps.sigma.data()[pixel] = static_cast<float>(sigma);
    maps.normalised_residual.data()[pixel] = static_cast<float>(n);
    maps.weight.data()[pixel] = static_cast<float>(settings.loss->evaluate(n * n).d_rho);
    maps.mask.data()[pixel] = 1;
  }
  return maps;
}

}  // namespace raylign::tracking
