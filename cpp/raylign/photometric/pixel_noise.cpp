// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/pixel_noise.h"

#include <algorithm>
#include <cmath>
#include <vector>

namespace raylign {

double estimate_pixel_noise(const Plane<float>& image) {
  constexpr double kNormalMedian = 1.4826;  // σ over median |x| of a normal law
  constexpr double kGain = 6.0;             // √ of the sum of the squared weights
  std::vector<float> answers;
  for (int v = 1; v + 1 < image.height(); ++v) {
    const float* above = image.row(v - 1);
    const float* at = image.row(v);
    const float* below = image.row(v + 1);
    const auto across = [&](int u) { return above[u] - 2.0f * at[u] + below[u]; };
    for (int u = 1; u + 1 < image.width(); ++u) {
      answers.push_back(std::abs(across(u - 1) - 2.0f * across(u) + across(u + 1)));
    }
  }
  if (answers.empty()) return 0.0;
  const auto middle = answers.begin() + static_cast<std::ptrdiff_t>(answers.size() / 2);
  std::nth_element(answers.begin(), middle, answers.end());
  return kNormalMedian * *middle / kGain;
}

}  // namespace raylign
