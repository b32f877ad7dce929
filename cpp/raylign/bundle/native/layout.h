// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <utility>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/table.h"
#include "raylign/bundle/native/tracks.h"
#include "raylign/scene/bundle_scene.h"

namespace raylign::native {

/// The observations of a problem, landmark by landmark: what every pass over the data walks along.
/// A landmark is a point that somebody sees. Landmarks are sorted by their lowest camera, then by
/// their highest, so that neighbours touch the same cameras, and within a window by the number of
/// their observations, the longest first; the observations of one by camera.
struct Layout {
  /// The same for any number of threads.
  Layout(const BundleScene& scene, PointKind kind, ThreadPool& pool);
  /// On the calling thread.
  explicit Layout(const BundleScene& scene, PointKind kind = PointKind::XYZ);

  PointKind point_kind;  ///< how the kernels find a landmark in X
  CameraKind camera_kind;
  std::int32_t num_cameras = 0;
  Table<std::int32_t> points;  ///< (L,) index of each landmark in the problem
  Table<std::int64_t> starts;  ///< (L + 1,) first observation of each landmark
  Table<std::int32_t> camera;  ///< (N,)
  Table<double> uv;            ///< (2 N,) observed pixels
  std::vector<bool> observed;  ///< (C,) cameras with observations

  /// Landmarks are cut into chunks of about equal numbers of observations. Sums are taken chunk by
  /// chunk, and the cut depends on the problem alone: this is why the bits do not depend on the
  /// number of threads. (G + 1,)
  std::vector<std::int64_t> chunks;

  /// Chunks are cut into windows: what the kernels write down per observation for a whole window
  /// stays in the cache. A long track is a window of its own. (W + 1,) landmarks.
  std::vector<std::int64_t> windows;
  std::vector<std::int32_t> chunk_windows;  ///< (G + 1,) first window of each chunk

  /// The observations of each window by camera: their places in the window, (N,), and where those
  /// of one camera end.
  Table<std::int32_t> places;
  std::vector<CameraVisit> visits;
  std::vector<std::int64_t> window_visits;  ///< (W + 1,) first visit of each window

  static constexpr std::int64_t kWindow = 1024;   ///< observations
  static constexpr std::int64_t kLongTrack = 64;  ///< longer tracks are long

  bool is_long(std::int64_t landmark) const {
    return starts[landmark + 1] - starts[landmark] > kLongTrack;
  }
  Observations observations() const {
    return {starts.data(), camera.data(),        uv.data(),  windows.data(), places.data(),
            visits.data(), window_visits.data(), point_kind, camera_kind};
  }
  int num_windows() const { return static_cast<int>(windows.size()) - 1; }
  /// Observations of the largest window.
  std::int64_t max_window() const;

  std::int64_t num_landmarks() const { return static_cast<std::int64_t>(points.size()); }
  std::int64_t num_observations() const { return static_cast<std::int64_t>(camera.size()); }
  /// Cameras [first, second) hold all that the chunk touches.
  std::pair<std::int32_t, std::int32_t> camera_range(int chunk) const;

  int num_chunks() const { return static_cast<int>(chunks.size()) - 1; }
  std::int64_t max_track_length() const;

 private:
  void cut_chunks();
  void fill_chunks(const BundleScene& scene, Tracks& tracks, ThreadPool& pool);
};

}  // namespace raylign::native
