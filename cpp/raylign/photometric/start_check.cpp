// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/start_check.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign::photometric {
namespace {

constexpr double kOddCenter = 0.25;  // of the principal point from the middle, share of the size
constexpr double kFewInView = 0.5;

struct Census {
  std::int64_t num_points_in_two = 0;  // in view of two images
  std::int64_t num_behind = 0;         // projections
  std::int64_t num_outside = 0;
  std::int64_t num_inside = 0;
};

Census count_views(const Setting& setting, const PhotometricState& start) {
  Census census;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    int inside = 0;
    for (std::int64_t e = setting.candidates.starts[p]; e < setting.candidates.starts[p + 1]; ++e) {
      const std::int32_t image = setting.candidates.image[e];
      const PatchPlane& plane = setting.prepared.images[image]->plane(0);
      Vector2 uv;
      if (!start.project(image, start.points.row(p), uv)) {
        ++census.num_behind;
      } else if (!plane.contains(uv.x(), uv.y())) {
        ++census.num_outside;
      } else {
        ++inside;
      }
    }
    census.num_inside += inside;
    const bool has_own_image =
        setting.hosts.image[p] >= 0 &&
        setting.options.point_parametrization == PointParametrization::INVERSE_DEPTH;
    if (inside + (has_own_image ? 1 : 0) >= 2) ++census.num_points_in_two;
  }
  return census;
}

// Empty when the principal point is about in the middle of image i.
std::string odd_intrinsics(const Setting& setting, const PhotometricState& start, std::int64_t i) {
  const PatchImage& image = *setting.prepared.images[i];
  const auto K = start.intrinsics.row(start.intrinsics_row(i));
  const double du = K[2] / image.width(0) - 0.5;
  const double dv = K[3] / image.height(0) - 0.5;
  if (std::abs(du) < kOddCenter && std::abs(dv) < kOddCenter) return "";
  return "the principal point (" + format_double(K[2]) + ", " + format_double(K[3]) +
         ") of image " + std::to_string(i) + " is far from the middle of its " +
         std::to_string(image.width(0)) + " x " + std::to_string(image.height(0)) +
         " px: intrinsics of another resolution?";
}

}  // namespace

std::vector<std::string> check_start(const Setting& setting, const PhotometricState& start) {
  const Census census = count_views(setting, start);
  const std::string counts = std::to_string(census.num_inside) + " projections are inside, " +
                             std::to_string(census.num_outside) + " outside of the images, " +
                             std::to_string(census.num_behind) + " behind the cameras";
  std::string odd;
  for (std::int64_t i = 0; i < setting.problem.num_images() && odd.empty(); ++i) {
    odd = odd_intrinsics(setting, start, i);
  }
  const std::string hint =
      !odd.empty() ? odd
                   : (census.num_behind > census.num_outside + census.num_inside
                          ? "most points are behind the cameras: is T_cw camera to world?"
                          : "");
  if (census.num_points_in_two == 0) {
    throw ShapeError("PhotometricProblem: no point is in view of two images (" + counts + ")" +
                     (hint.empty() ? "" : "; " + hint));
  }
  std::vector<std::string> messages;
  if (!odd.empty()) messages.push_back(odd);
  const auto N = static_cast<double>(setting.num_points());
  if (static_cast<double>(census.num_points_in_two) < kFewInView * N) {
    messages.push_back("only " + std::to_string(census.num_points_in_two) + " of " +
                       std::to_string(setting.num_points()) +
                       " points are in view of two images at the start: " + counts);
  }
  return messages;
}

}  // namespace raylign::photometric
