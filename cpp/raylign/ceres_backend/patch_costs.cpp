// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/patch_costs.h"

#include <algorithm>

#include "raylign/ceres_backend/pose_blocks.h"

namespace raylign::ceres_backend {
namespace {

// Rows `first` … of ∂r/∂block, where the block moves (u, v) by `motion`.
template <int N>
void write_moved(const PatchEdge& edge,
                 const EdgeSample& sample,
                 const RowMajor<2, N>& motion,
                 int first,
                 int count,
                 double* J) {
  for (int n = first; n < first + count; ++n, J += N) {
    const double counts = sample.counts(edge, n) ? 1.0 : 0.0;
    const double g_u = counts * sample.gradient[n][0];
    const double g_v = counts * sample.gradient[n][1];
    for (int k = 0; k < N; ++k) J[k] = -(g_u * motion(0, k) + g_v * motion(1, k));
  }
}

void write_brightness(const PatchEdge& edge,
                      const EdgeSample& sample,
                      bool of_host,
                      int first,
                      int count,
                      double* J) {
  for (int n = first; n < first + count; ++n, J += 2) {
    const double counts = sample.counts(edge, n) ? 1.0 : 0.0;
    const auto [by_a, by_b] = of_host ? sample.by_host_brightness(n) : sample.by_brightness(n);
    J[0] = counts * by_a;
    J[1] = counts * by_b;
  }
}

// ∂(u, v)/∂[q, t] of a block, from that of the left tangent: where t stays, υ = t × φ.
RowMajor<2, 7> pose_block_motion(const RowMajor<2, 6>& of_tangent, const PatchPose& pose) {
  RowMajor<2, 3> of_rotation;
  for (int row = 0; row < 2; ++row) {
    const Vector3 of_translation = of_tangent.row(row).head<3>().transpose();
    of_rotation.row(row) = of_tangent.row(row).tail<3>() + of_translation.cross(pose.t).transpose();
  }
  RowMajor<2, 7> motion;
  motion.leftCols<4>() = of_rotation * rotation_d_quaternion(pose.q.coeffs().data());
  motion.rightCols<3>() = of_tangent.leftCols<3>();
  return motion;
}

void write_slot(const PatchScene& scene,
                const PatchBlocks& blocks,
                PatchSlot slot,
                const EvaluatedEdge& at,
                int first,
                int count,
                double* J) {
  const PatchEdge& edge = scene.edges[blocks.edge];
  const std::int32_t host = scene.hosts[blocks.point];
  switch (slot) {
    case PatchSlot::POSE: {
      const bool is_host = scene.inverse_depth && host == edge.image;
      const RowMajor<2, 6> tangent =
          is_host ? RowMajor<2, 6>(at.motion.pose + at.motion.host_pose) : at.motion.pose;
      const auto motion = pose_block_motion(tangent, scene.poses[edge.image]);
      return write_moved<7>(edge, at.sample, motion, first, count, J);
    }
    case PatchSlot::HOST_POSE: {
      const auto motion = pose_block_motion(at.motion.host_pose, scene.poses[host]);
      return write_moved<7>(edge, at.sample, motion, first, count, J);
    }
    case PatchSlot::POINT:
      if (!scene.inverse_depth) {
        return write_moved<3>(edge, at.sample, at.motion.point, first, count, J);
      }
      return write_moved<1>(edge, at.sample, at.motion.point.col(0), first, count, J);
    case PatchSlot::INTRINSICS: {
      const bool shared =
          scene.inverse_depth && scene.intrinsics_row(host) == scene.intrinsics_row(edge.image);
      const RowMajor<2, 4> motion =
          shared ? RowMajor<2, 4>(at.motion.intrinsics + at.motion.host_intrinsics)
                 : at.motion.intrinsics;
      return write_moved<4>(edge, at.sample, motion, first, count, J);
    }
    case PatchSlot::HOST_INTRINSICS:
      return write_moved<4>(edge, at.sample, at.motion.host_intrinsics, first, count, J);
    case PatchSlot::BRIGHTNESS:
      return write_brightness(edge, at.sample, false, first, count, J);
    case PatchSlot::HOST_BRIGHTNESS:
      return write_brightness(edge, at.sample, true, first, count, J);
  }
}

// Pixels first … of an edge; false: too many edges are out of view.
void write_edge(const PatchEdges& edges,
                const PatchBlocks& blocks,
                const EvaluatedEdge& at,
                int first,
                int count,
                double* residuals,
                double** J) {
  const PatchScene& scene = edges.scene();
  const bool is_seen = at.sample.is_seen;
  for (int n = 0; n < count; ++n) {
    residuals[n] =
        is_seen ? at.sample.residual[first + n] : edges.left_residual(blocks.edge, first + n);
  }
  if (J == nullptr) return;
  for (int k = 0; k < blocks.count; ++k) {
    if (J[k] == nullptr) continue;
    const PatchSlot slot = blocks.slots[k];
    if (is_seen && edges.pulls(blocks.edge)) {
      write_slot(scene, blocks, slot, at, first, count, J[k]);
    } else {
      std::fill_n(J[k], count * patch_slot_size(scene, slot), 0.0);
    }
  }
}

}  // namespace

int patch_slot_size(const PatchScene& scene, PatchSlot slot) {
  switch (slot) {
    case PatchSlot::POSE:
    case PatchSlot::HOST_POSE:
      return 7;
    case PatchSlot::INTRINSICS:
    case PatchSlot::HOST_INTRINSICS:
      return 4;
    case PatchSlot::BRIGHTNESS:
    case PatchSlot::HOST_BRIGHTNESS:
      return 2;
    case PatchSlot::POINT:
      break;
  }
  return scene.inverse_depth ? 1 : 3;
}

PatchCost::PatchCost(const PatchEdges& edges, const PatchBlocks& blocks)
    : edges_(edges), blocks_(blocks) {
  set_num_residuals(edges.scene().pattern.size());
  for (int k = 0; k < blocks.count; ++k) {
    mutable_parameter_block_sizes()->push_back(patch_slot_size(edges.scene(), blocks.slots[k]));
  }
}

bool PatchCost::Evaluate(double const* const* /*x*/, double* residuals, double** J) const {
  EvaluatedEdge at;
  edges_.evaluate(blocks_.point, blocks_.edge, J != nullptr, at);
  write_edge(edges_, blocks_, at, 0, num_residuals(), residuals, J);
  return at.sample.is_seen || edges_.note_left(blocks_.edge);
}

PatchPixelCost::PatchPixelCost(const PatchEdges& edges, const PatchBlocks& blocks, int n)
    : edges_(edges), blocks_(blocks), n_(n) {
  set_num_residuals(1);
  for (int k = 0; k < blocks.count; ++k) {
    mutable_parameter_block_sizes()->push_back(patch_slot_size(edges.scene(), blocks.slots[k]));
  }
}

bool PatchPixelCost::Evaluate(double const* const* /*x*/, double* residual, double** J) const {
  write_edge(edges_, blocks_, edges_.evaluated(blocks_.edge), n_, 1, residual, J);
  return edges_.is_acceptable();
}

}  // namespace raylign::ceres_backend
