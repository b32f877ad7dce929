// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal.h"

#include <algorithm>

#include "raylign/synthetic/bal_stream.h"

namespace raylign {
namespace {

constexpr std::int64_t kChunkPoints = 4096;

void fill_observations(SyntheticBalStream& stream, SyntheticBal& bal) {
  BalProblem& problem = bal.problem;
  const std::int64_t count = stream.num_observations();
  problem.camera_index.resize(count);
  problem.point_index.resize(count);
  problem.observations.resize(count, 2);
  bal.inlier_mask.resize(count);
  SyntheticObservationChunk chunk;
  for (std::int64_t row = 0; stream.next_observations(kChunkPoints, chunk);) {
    for (std::size_t i = 0; i < chunk.observations.size(); ++i, ++row) {
      problem.camera_index[row] = chunk.camera_index[i];
      problem.point_index[row] = chunk.point_index[i];
      problem.observations.row(row) = chunk.observations[i];
      bal.inlier_mask[row] = chunk.inlier[i];
    }
  }
}

void fill_points(SyntheticBalStream& stream, SyntheticBal& bal) {
  const std::int64_t count = stream.options().num_points;
  bal.problem.points.resize(count, 3);
  bal.problem.colors.resize(count, 3);
  bal.truth.points.resize(count, 3);
  SyntheticPointChunk chunk;
  for (std::int64_t row = 0; stream.next_points(kChunkPoints, chunk);) {
    std::copy(chunk.colors.begin(), chunk.colors.end(), bal.problem.colors.data() + 3 * row);
    for (std::size_t i = 0; i < chunk.truth.size(); ++i, ++row) {
      bal.truth.points.row(row) = chunk.truth[i];
      bal.problem.points.row(row) = chunk.start[i];
    }
  }
}

}  // namespace

SyntheticBal synthetic_bal(const SyntheticBalOptions& options) {
  SyntheticBalStream stream(options);
  SyntheticBal bal;
  bal.options = options;
  fill_observations(stream, bal);
  fill_points(stream, bal);
  bal.problem.cameras = stream.start_cameras();
  bal.truth.cameras = stream.true_cameras();
  bal.truth.camera_index = bal.problem.camera_index;
  bal.truth.point_index = bal.problem.point_index;
  bal.truth.observations = bal.problem.observations;
  bal.truth.colors = bal.problem.colors;
  return bal;
}

}  // namespace raylign
