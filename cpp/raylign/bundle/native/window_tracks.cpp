// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/window_tracks.h"

#include <algorithm>

namespace raylign::native {

WindowTracks::WindowTracks(const Layout& layout,
                           const std::vector<unsigned char>& active,
                           bool diagonal_only)
    : layout_(layout),
      active_(active),
      diagonal_only_(diagonal_only),
      local_(active.size()),
      sights_(Layout::kWindow) {}

void WindowTracks::load(int window) {
  window_ = window;
  const std::int64_t first_visit = layout_.window_visits[window];
  num_cameras_ = static_cast<int>(layout_.window_visits[window + 1] - first_visit);
  num_words_ = (num_cameras_ + 63) / 64;
  for (int c = 0; c < num_cameras_; ++c) {
    local_[layout_.visits[first_visit + c].camera] = static_cast<std::uint16_t>(c);
  }
  find_sights();
  set_rows();
}

void WindowTracks::find_sights() {
  const std::int64_t begin = layout_.windows[window_];
  const std::int64_t end = layout_.windows[window_ + 1];
  const std::int64_t first = layout_.starts[begin];
  const std::int32_t* cameras = layout_.camera.data();
  ends_.clear();
  std::uint32_t count = 0;
  for (auto j = begin; j < end; ++j) {
    for (auto q = layout_.starts[j]; q < layout_.starts[j + 1]; ++q) {
      sights_[count] = {local_[cameras[q]], static_cast<std::uint16_t>(q - first)};
      count += active_[cameras[q]] != 0 ? 1 : 0;
    }
    ends_.push_back(count);
  }
}

void WindowTracks::set_rows() {
  rows_.assign(static_cast<std::size_t>(num_cameras_) * num_words_, 0);
  num_products_ = 0;
  has_pairs_of_one_camera_ = false;
  std::size_t first = 0;
  for (const std::uint32_t end : ends_) {
    add_pairs(first, end);
    first = end;
  }
}

// The sights [begin, end) of one landmark, by camera: from the last to the first each pairs with
// all that have been met.
void WindowTracks::add_pairs(std::size_t begin, std::size_t end) {
  constexpr int kMaxWords = Layout::kWindow / 64;
  std::uint64_t met[kMaxWords] = {};
  std::int64_t num_of_camera = 0;  // sights of the camera so far
  for (auto a = end; a-- > begin;) {
    const int c = sights_[a].camera;
    const bool is_again = a + 1 < end && sights_[a + 1].camera == c;
    if (!is_again) num_of_camera = 0;
    has_pairs_of_one_camera_ |= is_again;
    // with those met, both ways with those of the same camera
    num_products_ +=
        (diagonal_only_ ? num_of_camera + 1 : static_cast<std::int64_t>(end - a)) + num_of_camera;
    ++num_of_camera;
    if (diagonal_only_ && !is_again) std::fill_n(met, num_words_, 0);
    met[c / 64] |= std::uint64_t{1} << (c % 64);
    std::uint64_t* row = rows_.data() + static_cast<std::int64_t>(c) * num_words_;
    for (int word = c / 64; word < num_words_; ++word) row[word] |= met[word];
  }
}

}  // namespace raylign::native
