// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/state.h"

namespace raylign::photometric {

Vector3 PhotometricState::ray(std::int64_t image, const Vector2& uv) const {
  const auto K = intrinsics.row(intrinsics_row(image));
  return {(uv.x() - K[2]) / K[0], (uv.y() - K[3]) / K[1], 1.0};
}

bool PhotometricState::project(std::int64_t image, const Vector3& X, Vector2& uv) const {
  const Vector3 q = in_camera(image, X);
  if (!(q.z() > 0.0)) return false;
  const auto K = intrinsics.row(intrinsics_row(image));
  uv = {K[0] * q.x() / q.z() + K[2], K[1] * q.y() / q.z() + K[3]};
  return uv.allFinite();
}

PhotometricState start_state(const PhotometricProblem& problem) {
  PhotometricState state;
  for (std::int64_t i = 0; i < problem.num_images(); ++i) {
    const Matrix4 T = problem.pose(i);
    state.poses.push_back(
        {quaternion_from_matrix(T.topLeftCorner<3, 3>()), T.topRightCorner<3, 1>()});
  }
  state.brightness = problem.brightness;
  if (state.brightness.rows() == 0) state.brightness.setZero(problem.num_images(), 2);
  state.intrinsics = problem.intrinsics;
  state.points = problem.points;
  return state;
}

bool same_pose(const PatchPose& a, const PatchPose& b) {
  return a.q.coeffs() == b.q.coeffs() && a.t == b.t;
}

void store(const PhotometricState& state,
           const PhotometricState& start,
           const PhotometricProblem& problem,
           PhotometricResult& result) {
  result.T_cw = problem.T_cw;
  for (std::size_t i = 0; i < state.poses.size(); ++i) {
    if (same_pose(state.poses[i], start.poses[i])) continue;
    RowMajor<4, 4> T = RowMajor<4, 4>::Identity();
    T.topLeftCorner<3, 3>() = quaternion_to_matrix(state.poses[i].q);
    T.topRightCorner<3, 1>() = state.poses[i].t;
    result.T_cw.row(static_cast<Eigen::Index>(i)) =
        Eigen::Map<const Eigen::Matrix<double, 1, 16>>(T.data());
  }
  result.points = state.points;
  result.brightness = state.brightness;
  result.intrinsics = state.intrinsics;
}

}  // namespace raylign::photometric
