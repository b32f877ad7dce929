// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <string>
#include <vector>

namespace raylign {

/// The pixels of a patch, as offsets (du, dv) from its centre, in px.
struct PatchPattern {
  /// Bits of PatchEdge::mask.
  static constexpr int kMaxPixels = 32;

  std::string name;  ///< "4x4", … or "custom"
  std::vector<std::array<double, 2>> offsets;

  /// side² pixels, offsets −⌊side / 2⌋ … in each direction, by columns (u outermost), as the
  /// numbers of a patch lie in a points.txt.
  static PatchPattern square(int side);
  /// The eight pixels of Engel, Koltun, Cremers, Direct Sparse Odometry, PAMI 2018, fig. 4.
  static PatchPattern spread8();
  /// "4x4", "3x3", "5x5" or "spread8"; throws OptionsError.
  static PatchPattern parse(const std::string& text);

  int size() const { return static_cast<int>(offsets.size()); }
  /// All offsets are those of square(4): what the fastest kernel is for.
  bool is_square4() const;
  /// Throws OptionsError: no pixel, more than kMaxPixels, or an offset that is not finite.
  void validate() const;
};

bool operator==(const PatchPattern& a, const PatchPattern& b);

}  // namespace raylign
