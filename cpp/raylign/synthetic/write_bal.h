// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <functional>

#include "raylign/base/error.h"
#include "raylign/synthetic/bal_stream.h"

namespace raylign {

/// Receives (observations written, observations in all) now and then; false stops.
using ProgressCallback = std::function<bool(std::int64_t done, std::int64_t total)>;

/// Hands a whole synthetic problem, piece by piece, to a writer with the three adders of BalWriter
/// (raylign/io/bal.h): add_observation(camera, point, u, v), add_camera(const double*),
/// add_point(const double*). A template, because this module may not know of files. `truth` gets
/// the same observations with true cameras and points. The caller makes the writers with the counts
/// of the fresh `stream`, and finishes them. Throws Error when `progress` stops it.
template <typename Writer>
void write_synthetic_bal(SyntheticBalStream& stream,
                         Writer& problem,
                         Writer* truth = nullptr,
                         const ProgressCallback& progress = nullptr) {
  constexpr std::int64_t kChunkPoints = 4096;
  const std::int64_t total = stream.num_observations();
  std::int64_t done = 0;
  SyntheticObservationChunk chunk;
  while (stream.next_observations(kChunkPoints, chunk)) {
    for (std::size_t i = 0; i < chunk.observations.size(); ++i) {
      const Vector2& uv = chunk.observations[i];
      problem.add_observation(chunk.camera_index[i], chunk.point_index[i], uv.x(), uv.y());
      if (truth)
        truth->add_observation(chunk.camera_index[i], chunk.point_index[i], uv.x(), uv.y());
    }
    done += static_cast<std::int64_t>(chunk.observations.size());
    if (progress && !progress(done, total))
      throw Error("synthetic BAL: stopped by the progress callback");
  }
  const Rows<double, 9> start_cameras = stream.start_cameras();
  const Rows<double, 9> true_cameras = stream.true_cameras();
  for (Eigen::Index i = 0; i < start_cameras.rows(); ++i) {
    problem.add_camera(start_cameras.row(i).data());
    if (truth) truth->add_camera(true_cameras.row(i).data());
  }
  SyntheticPointChunk points;
  while (stream.next_points(kChunkPoints, points)) {
    for (std::size_t i = 0; i < points.start.size(); ++i) {
      problem.add_point(points.start[i].data());
      if (truth) truth->add_point(points.truth[i].data());
    }
  }
}

}  // namespace raylign
