// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/layout.h"

namespace raylign::native {

/// The moving cameras' observations of one window, by the window's own numbers of cameras: those of
/// its visits, so few that a table of all their pairs is small. For windows that are planned, no
/// long tracks. Scratch: `load` takes the place of what was there.
class WindowTracks {
 public:
  struct Sight {
    std::uint16_t camera;  ///< counted from the window's first visit
    std::uint16_t place;   ///< counted from the window's first observation
  };

  /// @param active         (C,) 0: the camera does not move
  /// @param diagonal_only  only pairs of a camera with itself count
  WindowTracks(const Layout& layout,
               const std::vector<unsigned char>& active,
               bool diagonal_only = false);

  void load(int window);

  int num_cameras() const { return num_cameras_; }
  std::int64_t num_products() const { return num_products_; }

  /// Calls visit(i, k), two sights, for each product Z_i Z_kᵀ of the window: landmark after
  /// landmark, i before k or the same; for two sights of one camera both ways.
  template <typename Visit>
  void for_each_product(const Visit& visit) const;

  /// One bit for each camera k >= c that a landmark pairs with camera c, in `num_words` words.
  const std::uint64_t* row(int c) const { return rows_.data() + std::int64_t{c} * num_words_; }
  int num_words() const { return num_words_; }
  const std::vector<std::uint64_t>& rows() const { return rows_; }

  /// Calls visit(k) for the cameras of a row, ascending.
  template <typename Visit>
  static void for_each_bit(const std::uint64_t* row, int num_words, const Visit& visit);

 private:
  void find_sights();
  void set_rows();
  void add_pairs(std::size_t begin, std::size_t end);

  const Layout& layout_;
  const std::vector<unsigned char>& active_;
  bool diagonal_only_;
  int window_ = 0;
  int num_cameras_ = 0;
  int num_words_ = 0;
  std::int64_t num_products_ = 0;
  bool has_pairs_of_one_camera_ = false;
  std::vector<std::uint16_t> local_;  // (C,) of the window's cameras
  std::vector<Sight> sights_;
  std::vector<std::uint32_t> ends_;  // of each landmark's sights
  std::vector<std::uint64_t> rows_;  // (num_cameras, num_words)
};

template <typename Visit>
void WindowTracks::for_each_product(const Visit& visit) const {
  const bool is_plain = !diagonal_only_ && !has_pairs_of_one_camera_;
  const Sight* first = sights_.data();
  for (const std::uint32_t last : ends_) {
    const Sight* const end = sights_.data() + last;
    for (const Sight* a = first; a < end; ++a) {
      const Sight i = *a;
      if (is_plain) {
        for (const Sight* k = a; k < end; ++k) visit(i, *k);
        continue;
      }
      for (const Sight* k = a; k < end && !(diagonal_only_ && k->camera != i.camera); ++k) {
        visit(i, *k);
        if (k != a && k->camera == i.camera) visit(*k, i);
      }
    }
    first = end;
  }
}

template <typename Visit>
void WindowTracks::for_each_bit(const std::uint64_t* row, int num_words, const Visit& visit) {
  for (int word = 0; word < num_words; ++word) {
    for (std::uint64_t bits = row[word]; bits != 0; bits &= bits - 1) {
      visit(64 * word + __builtin_ctzll(bits));
    }
  }
}

}  // namespace raylign::native
