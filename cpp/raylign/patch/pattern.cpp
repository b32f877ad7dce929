// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/patch/pattern.h"

#include <cmath>

#include "raylign/base/error.h"

namespace raylign {

PatchPattern PatchPattern::square(int side) {
  PatchPattern pattern;
  pattern.name = std::to_string(side) + "x" + std::to_string(side);
  const int first = -(side / 2);
  for (int du = first; du < first + side; ++du) {
    for (int dv = first; dv < first + side; ++dv) {
      pattern.offsets.push_back({static_cast<double>(du), static_cast<double>(dv)});
    }
  }
  return pattern;
}

PatchPattern PatchPattern::spread8() {
  return {"spread8",
          {{0.0, -2.0},
           {-1.0, -1.0},
           {1.0, -1.0},
           {-2.0, 0.0},
           {0.0, 0.0},
           {2.0, 0.0},
           {-1.0, 1.0},
           {0.0, 2.0}}};
}

PatchPattern PatchPattern::parse(const std::string& text) {
  if (text == "4x4") return square(4);
  if (text == "3x3") return square(3);
  if (text == "5x5") return square(5);
  if (text == "spread8") return spread8();
  throw OptionsError("a patch pattern must be one of 3x3, 4x4, 5x5, spread8, got '" + text + "'");
}

bool PatchPattern::is_square4() const { return offsets == square(4).offsets; }

void PatchPattern::validate() const {
  require_option(size() >= 1 && size() <= kMaxPixels, "PatchPattern.offsets",
                 "between 1 and 32 pixels", size());
  for (const auto& offset : offsets) {
    for (const double d : offset) {
      require_option(std::isfinite(d), "PatchPattern.offsets", "finite", d);
    }
  }
}

bool operator==(const PatchPattern& a, const PatchPattern& b) { return a.offsets == b.offsets; }

}  // namespace raylign
