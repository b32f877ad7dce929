// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause

// image_benchmark: median time in ms of what a tracker does to a 640x480 frame, one thread.
#include <algorithm>
#include <cstdint>
#include <cstdio>
#include <vector>

#include "raylign/base/stopwatch.h"
#include "raylign/image/bspline.h"
#include "raylign/image/depth_pyramid.h"
#include "raylign/image/gradient.h"
#include "raylign/image/pyramid.h"

namespace raylign {
namespace {

constexpr int kWidth = 640;
constexpr int kHeight = 480;
constexpr int kRepetitions = 301;

template <typename F>
void report(const char* what, const F& f) {
  std::vector<double> times_ms;
  for (int i = 0; i < kRepetitions; ++i) {
    const Stopwatch stopwatch;
    f();
    times_ms.push_back(1e3 * stopwatch.seconds());
  }
  std::nth_element(times_ms.begin(), times_ms.begin() + kRepetitions / 2, times_ms.end());
  std::printf("%-32s %7.3f\n", what, times_ms[kRepetitions / 2]);
}

template <typename Pixel>
std::vector<Pixel> noise(int channels) {
  std::vector<Pixel> pixels(static_cast<std::size_t>(kWidth) * kHeight * channels);
  std::uint32_t state = 1;
  for (Pixel& pixel : pixels) {
    state = state * 1664525U + 1013904223U;
    pixel = static_cast<Pixel>(state >> (32U - 8U * sizeof(Pixel)));
  }
  return pixels;
}

void run() {
  const auto grey = noise<std::uint8_t>(1);
  const auto color = noise<std::uint8_t>(3);
  const auto deep = noise<std::uint16_t>(1);
  const ImageView view{grey.data(), PixelType::UINT8, kWidth, kHeight, 1, kWidth};
  ImagePyramid pyramid;
  report("pyramid, uint8 colour",
         [&] { pyramid.assign({color.data(), PixelType::UINT8, kWidth, kHeight, 3, 3 * kWidth}); });
  report("pyramid, uint16",
         [&] { pyramid.assign({deep.data(), PixelType::UINT16, kWidth, kHeight, 1, 2 * kWidth}); });
  report("pyramid, uint8", [&] { pyramid.assign(view); });
  std::vector<GradientImage> cells(static_cast<std::size_t>(pyramid.num_levels()));
  for (const int first : {0, 1}) {
    report(first == 0 ? "gradient images, all levels" : "gradient images, level 1 and up", [&] {
      for (int l = first; l < pyramid.num_levels(); ++l) {
        make_gradient_image(pyramid.level(l).view(), cells[l]);
      }
    });
  }
  Plane<float> maximum;
  report("max-gradient map, level 0", [&] { make_max_gradient(cells[0].view(), maximum); });
  BSplineImage spline;
  report("B-spline prefilter, level 0", [&] { spline.assign(pyramid.level(0).view()); });
  Plane<float> D(kWidth, kHeight);
  Plane<float> V(kWidth, kHeight);
  for (std::size_t i = 0; i < D.size(); ++i) {
    D.data()[i] = 0.5F;
    V.data()[i] = i % 7 == 0 ? 0.0F : 1e-4F;
  }
  DepthPyramid depth;
  report("depth pyramid", [&] { depth.assign(D.view(), V.view()); });
}

}  // namespace
}  // namespace raylign

int main() {
  raylign::run();
  return 0;
}
