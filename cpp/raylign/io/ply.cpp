// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/ply.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/scene/bal_transform.h"

namespace raylign {
namespace {

static_assert(__BYTE_ORDER__ == __ORDER_LITTLE_ENDIAN__, "the PLY writer copies native numbers");

constexpr double kAutoScale = 0.05;
// Tangent of half the opening angle of a frustum: what the observations say, within what can be
// drawn.
constexpr double kMinHalfWidth = 0.1;
constexpr double kMaxHalfWidth = 2.0;
constexpr double kUnknownHalfWidth = 0.5;
constexpr double kTipHeight = 1.4;  // of the tip above the centre, in half heights
constexpr std::size_t kFlushSize = std::size_t{1} << 20;

constexpr int kFrustumVertices = 6;  // centre, corners counter-clockwise from lower left, tip
constexpr int kFrustumFaces = 7;
// Counter-clockwise from outside.
constexpr std::int32_t kFaces[kFrustumFaces][3] = {{0, 1, 2}, {0, 2, 3}, {0, 3, 4}, {0, 4, 1},
                                                   {1, 3, 2}, {1, 4, 3}, {3, 4, 5}};

using Frustum = Eigen::Matrix<float, kFrustumVertices, 3, Eigen::RowMajor>;

template <typename T>
void append_bytes(std::string& buffer, const T* values, std::size_t count) {
  buffer.append(reinterpret_cast<const char*>(values), count * sizeof(T));
}

void append_vertex(std::string& buffer, const float* xyz, const std::uint8_t* rgb) {
  append_bytes(buffer, xyz, 3);
  append_bytes(buffer, rgb, 3);
}

void flush(std::string& buffer, ByteSink& sink, std::size_t threshold) {
  if (buffer.size() < threshold) return;
  sink.write(buffer);
  buffer.clear();
}

// Largest |u| and |v| of each camera over its focal length, (C, 2).
Rows<double, 2> half_widths(const BalProblem& problem) {
  Rows<double, 2> widths = Rows<double, 2>::Zero(problem.num_cameras(), 2);
  for (Eigen::Index i = 0; i < problem.num_observations(); ++i) {
    auto width = widths.row(problem.camera_index[i]);
    width = width.cwiseMax(problem.observations.row(i).cwiseAbs());
  }
  for (Eigen::Index c = 0; c < widths.rows(); ++c) {
    for (int axis = 0; axis < 2; ++axis) {
      const double width = widths(c, axis) / std::abs(problem.cameras(c, 6));
      const bool known = std::isfinite(width) && width > 0.0;
      widths(c, axis) = known ? std::clamp(width, kMinHalfWidth, kMaxHalfWidth) : kUnknownHalfWidth;
    }
  }
  return widths;
}

Frustum make_frustum(const RowMajor<4, 4>& T_cw, const Vector2& half_width, double depth) {
  const double x = half_width.x() * depth;
  const double y = half_width.y() * depth;
  Rows<double, 3> p_c(kFrustumVertices, 3);
  p_c << 0, 0, 0, -x, -y, -depth, x, -y, -depth, x, y, -depth, -x, y, -depth,  //
      0, kTipHeight * y, -depth;
  // Rows: p_wᵀ = (p_c − t)ᵀ R, the inverse of p_c = R p_w + t.
  p_c.rowwise() -= T_cw.topRightCorner<3, 1>().transpose();
  return (p_c * T_cw.topLeftCorner<3, 3>()).cast<float>();
}

std::vector<Frustum> finite_frusta(const BalProblem& problem, double depth) {
  const Rows<double, 16> poses = camera_poses(problem);
  const Rows<double, 2> widths = half_widths(problem);
  std::vector<Frustum> frusta;
  for (Eigen::Index c = 0; c < problem.num_cameras(); ++c) {
    const Eigen::Map<const RowMajor<4, 4>> T_cw(poses.row(c).data());
    const Frustum frustum = make_frustum(T_cw, widths.row(c).transpose(), depth);
    if (frustum.allFinite()) frusta.push_back(frustum);
  }
  return frusta;
}

std::string header(std::int64_t num_vertices, std::int64_t num_faces) {
  return "ply\nformat binary_little_endian 1.0\ncomment raylign: points, then camera frusta\n"
         "element vertex " +
         std::to_string(num_vertices) +
         "\nproperty float x\nproperty float y\nproperty float z\n"
         "property uchar red\nproperty uchar green\nproperty uchar blue\n"
         "element face " +
         std::to_string(num_faces) + "\nproperty list uchar int vertex_indices\nend_header\n";
}

using Point = Eigen::Matrix<float, 1, 3>;

Point point_of(const BalProblem& problem, Eigen::Index i) {
  return problem.points.row(i).cast<float>();
}

std::int64_t count_finite_points(const BalProblem& problem) {
  std::int64_t count = 0;
  for (Eigen::Index i = 0; i < problem.num_points(); ++i) {
    count += point_of(problem, i).allFinite() ? 1 : 0;
  }
  return count;
}

void write_points(const BalProblem& problem,
                  const Rgb& color,
                  std::string& buffer,
                  ByteSink& sink) {
  const bool colored = problem.colors.rows() > 0;
  for (Eigen::Index i = 0; i < problem.num_points(); ++i) {
    const Point point = point_of(problem, i);
    if (!point.allFinite()) continue;
    append_vertex(buffer, point.data(), colored ? problem.colors.row(i).data() : color.data());
    flush(buffer, sink, kFlushSize);
  }
}

void write_frusta(const std::vector<Frustum>& frusta,
                  std::int64_t first_vertex,
                  const Rgb& color,
                  std::string& buffer,
                  ByteSink& sink) {
  for (const Frustum& frustum : frusta) {
    for (int k = 0; k < kFrustumVertices; ++k) {
      append_vertex(buffer, frustum.row(k).data(), color.data());
    }
    flush(buffer, sink, kFlushSize);
  }
  for (std::size_t c = 0; c < frusta.size(); ++c) {
    const auto base =
        static_cast<std::int32_t>(first_vertex) + static_cast<std::int32_t>(c) * kFrustumVertices;
    for (const auto& face : kFaces) {
      buffer += char{3};
      const std::int32_t corners[3] = {base + face[0], base + face[1], base + face[2]};
      append_bytes(buffer, corners, 3);
    }
    flush(buffer, sink, kFlushSize);
  }
}

double frustum_depth(const BalProblem& problem, const PlyOptions& options) {
  if (options.camera_scale > 0.0) return options.camera_scale;
  const double deviation = scene_extent(problem).deviation;
  return deviation > 0.0 ? kAutoScale * deviation : 1.0;
}

}  // namespace

void PlyOptions::validate() const {
  if (camera_scale >= 0.0 && std::isfinite(camera_scale)) return;
  throw OptionsError("PlyOptions.camera_scale must be finite and >= 0, got " +
                     format_double(camera_scale));
}

PlySummary write_ply(const BalProblem& problem, ByteSink& sink, const PlyOptions& options) {
  options.validate();
  problem.validate();
  std::vector<Frustum> frusta;
  if (options.cameras) frusta = finite_frusta(problem, frustum_depth(problem, options));
  PlySummary summary;
  summary.num_points = count_finite_points(problem);
  summary.num_cameras = static_cast<std::int64_t>(frusta.size());
  summary.num_skipped_points = problem.num_points() - summary.num_points;
  summary.num_skipped_cameras = options.cameras ? problem.num_cameras() - summary.num_cameras : 0;

  if (summary.num_points >
      std::numeric_limits<std::int32_t>::max() - kFrustumVertices * summary.num_cameras) {
    throw FormatError(sink.name(), 0, "", "cannot be written: PLY faces index 2147483647 vertices");
  }
  std::string buffer = header(summary.num_points + kFrustumVertices * summary.num_cameras,
                              kFrustumFaces * summary.num_cameras);
  write_points(problem, options.point_color, buffer, sink);
  write_frusta(frusta, summary.num_points, options.camera_color, buffer, sink);
  flush(buffer, sink, 0);
  sink.finish();
  return summary;
}

PlySummary write_ply(const BalProblem& problem,
                     const std::string& path,
                     const PlyOptions& options) {
  const std::unique_ptr<ByteSink> sink = open_byte_sink(path);
  return write_ply(problem, *sink, options);
}

}  // namespace raylign
