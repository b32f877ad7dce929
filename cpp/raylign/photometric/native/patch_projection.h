// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>

#include "raylign/photometric/native/patch_reader.h"

/// Where a point lands in an image, and the pixels that are read there. Included by
/// patch_kernels.cpp alone.
namespace raylign::native {

// The projection of a point into an image and how (u, v) moves.
struct Projection {
  double m[3];  // a positive multiple of the point in the camera's frame
  double x, y, inverse_z;
  double u, v;
};

// [x̄; w] so that m = R x̄ + w t, in front of every camera at once.
struct HomogeneousPoint {
  double x[3];
  double w;
  double ray[3];  // inverse depth: in the host's frame
};

RAYLIGN_INLINE HomogeneousPoint load_point(const PatchArrays& arrays,
                                           const PatchStateArrays& state,
                                           std::int64_t p) {
  const double* X = state.points + 3 * p;
  HomogeneousPoint point = {{X[0], X[1], X[2]}, 1.0, {0.0, 0.0, 1.0}};
  if (!arrays.inverse_depth) return point;
  const ImagePacket& host = state.images[arrays.hosts[p]];
  point.w = X[0];
  point.ray[0] = (arrays.host_uv[2 * p] - host.cx) / host.fx;
  point.ray[1] = (arrays.host_uv[2 * p + 1] - host.cy) / host.fy;
  double d[3];
  for (int k = 0; k < 3; ++k) d[k] = point.ray[k] - point.w * host.t[k];
  for (int k = 0; k < 3; ++k) {
    point.x[k] = host.R[k] * d[0] + host.R[3 + k] * d[1] + host.R[6 + k] * d[2];
  }
  return point;
}

RAYLIGN_INLINE bool project(const ImagePacket& image,
                            const HomogeneousPoint& point,
                            double min_depth,
                            Projection& p) {
  for (int k = 0; k < 3; ++k) {
    p.m[k] = image.R[3 * k] * point.x[0] + image.R[3 * k + 1] * point.x[1] +
             image.R[3 * k + 2] * point.x[2] + image.t[k] * point.w;
  }
  // a minimum of −infinity: everything but the camera's own plane
  if (!(p.m[2] > min_depth) || p.m[2] == 0.0) return false;
  p.inverse_z = 1.0 / p.m[2];
  p.x = p.m[0] * p.inverse_z;
  p.y = p.m[1] * p.inverse_z;
  p.u = image.fx * p.x + image.cx;
  p.v = image.fy * p.y + image.cy;
  return true;
}

RAYLIGN_INLINE bool square_fits(const PlaneRef& plane, double u, double v) {
  return u >= 2.0 && v >= 2.0 && u + 1.0 <= plane.max_u && v + 1.0 <= plane.max_v;
}

template <bool kGradient>
RAYLIGN_INLINE bool read_square(
    const PatchArrays& arrays, const PlaneRef& plane, double u, double v, PatchPixels& pixels) {
  if (!square_fits(plane, u, v)) return false;
  const auto first_u = static_cast<std::int32_t>(u);
  const auto first_v = static_cast<std::int32_t>(v);
  const auto x = static_cast<float>(u - first_u);
  const auto y = static_cast<float>(v - first_v);
  const std::ptrdiff_t stride = plane.stride;
  if (arrays.reader == Reader::SQUARE_BSPLINE) {
    const float* c = plane.origin + (first_v - 3) * stride + first_u - 3;
    read_square_bspline<kGradient>(c, stride, x, y, pixels);
  } else {
    const float* c = plane.origin + (first_v - 2) * stride + first_u - 2;
    read_square_bilinear<kGradient>(c, stride, x, y, pixels);
  }
  return true;
}

template <bool kGradient>
RAYLIGN_INLINE bool read_any(const PatchArrays& arrays,
                             const KernelEdge& edge,
                             const PlaneRef& plane,
                             double u,
                             double v,
                             PatchPixels& pixels) {
  const bool is_spline =
      arrays.reader == Reader::SQUARE_BSPLINE || arrays.reader == Reader::BSPLINE;
  const bool is_central = arrays.reader == Reader::CENTRAL_DIFFERENCE;
  for (int n = 0; n < arrays.padded_pixels; n += 4) {
    PixelCells cells = {};
    for (int k = 0; k < 4; ++k) {
      const double ou = arrays.offsets_u[n + k];
      const double ov = arrays.offsets_v[n + k];
      const double at_u = u + edge.A[0] * ou + edge.A[1] * ov;
      const double at_v = v + edge.A[2] * ou + edge.A[3] * ov;
      const bool is_inside =
          at_u >= 0.0 && at_v >= 0.0 && at_u <= plane.max_u && at_v <= plane.max_v;
      if (!is_inside) return false;
      const auto first_u = static_cast<std::int32_t>(at_u);
      const auto first_v = static_cast<std::int32_t>(at_v);
      cells.x[k] = static_cast<float>(at_u - first_u);
      cells.y[k] = static_cast<float>(at_v - first_v);
      const int before = is_spline ? 1 : 0;
      cells.left[k] = first_u == 0 ? 0 : -1;
      cells.up[k] = first_v == 0 ? 0 : -plane.stride;
      cells.first[k] = plane.origin + (first_v - before) * plane.stride + first_u - before;
    }
    F4 &I = pixels.I[n / 4], &I_u = pixels.I_u[n / 4], &I_v = pixels.I_v[n / 4];
    if (is_spline) {
      read_bspline<kGradient>(cells, plane.stride, I, I_u, I_v);
    } else if (is_central) {
      read_central_difference<kGradient>(cells, plane.stride, I, I_u, I_v);
    } else {
      read_bilinear<kGradient>(cells, plane.stride, I, I_u, I_v);
    }
  }
  return true;
}

// u, v: of level 0. False when a pixel of the patch lies outside of the plane.
template <bool kGradient>
RAYLIGN_INLINE bool read_patch(const PatchArrays& arrays,
                               const KernelEdge& edge,
                               double u,
                               double v,
                               double scale,
                               PatchPixels& pixels) {
  const PlaneRef& plane = arrays.planes[edge.plane];
  double at_u = edge.level == 0 ? u : (u + 0.5) * scale - 0.5;
  double at_v = edge.level == 0 ? v : (v + 0.5) * scale - 0.5;
  if (arrays.reader == Reader::CENTRAL_DIFFERENCE) {
    at_u = static_cast<float>(at_u);
    at_v = static_cast<float>(at_v);
  }
  const bool is_square =
      arrays.reader == Reader::SQUARE_BSPLINE || arrays.reader == Reader::SQUARE_BILINEAR;
  if (is_square && !edge.has_warp) return read_square<kGradient>(arrays, plane, at_u, at_v, pixels);
  return read_any<kGradient>(arrays, edge, plane, at_u, at_v, pixels);
}

// Asks for the rows that a patch around (u, v) of level 0 will read: they lie all over the images,
// and a pass would otherwise wait for each.
RAYLIGN_INLINE void prefetch_patch(const PlaneRef& plane, int level, double u, double v) {
  const double scale = 1.0 / static_cast<double>(std::int64_t{1} << level);
  const double at_u = u * scale;
  const double at_v = v * scale;
  if (!(at_u >= 3.0 && at_v >= 3.0 && at_u <= plane.max_u - 3.0 && at_v <= plane.max_v - 3.0))
    return;
  const float* c = plane.origin + (static_cast<std::int32_t>(at_v) - 3) * plane.stride +
                   static_cast<std::int32_t>(at_u) - 3;
  for (int row = 0; row < 7; ++row, c += plane.stride) {
    __builtin_prefetch(c);
    __builtin_prefetch(c + 6);
  }
}

// A point and where its first edges see it, made one point ahead of its turn.
struct PointAhead {
  static constexpr int kMaxEdges = 32;

  HomogeneousPoint point;
  Projection projections[kMaxEdges];
  bool is_in_front[kMaxEdges];
};

RAYLIGN_INLINE void look_ahead(const PatchArrays& arrays,
                               const PatchStateArrays& state,
                               std::int64_t p,
                               PointAhead& out) {
  out.point = load_point(arrays, state, p);
  const KernelEdge* edges = arrays.edges + arrays.starts[p];
  const std::int64_t count = arrays.starts[p + 1] - arrays.starts[p];
  for (int k = 0; k < count && k < PointAhead::kMaxEdges; ++k) {
    Projection& projection = out.projections[k];
    out.is_in_front[k] =
        project(state.images[edges[k].image], out.point, arrays.min_depth, projection);
  }
}

// Asks for the pixels of edge k of point p, one edge at a time: a burst would fill the buffers.
RAYLIGN_INLINE void prefetch_edge(const PatchArrays& arrays,
                                  std::int64_t p,
                                  const PointAhead& ahead,
                                  std::int64_t k) {
  const std::int64_t e = arrays.starts[p] + k;
  if (k >= PointAhead::kMaxEdges || e >= arrays.starts[p + 1] || !ahead.is_in_front[k]) return;
  const KernelEdge& edge = arrays.edges[e];
  prefetch_patch(arrays.planes[edge.plane], edge.level, ahead.projections[k].u,
                 ahead.projections[k].v);
}

// Edge k of the point, by what was found ahead.
RAYLIGN_INLINE bool project_edge(const PatchArrays& arrays,
                                 const PatchStateArrays& state,
                                 const PointAhead& ahead,
                                 const KernelEdge& edge,
                                 std::int64_t k,
                                 Projection& projection) {
  if (k >= PointAhead::kMaxEdges) {
    return project(state.images[edge.image], ahead.point, arrays.min_depth, projection);
  }
  projection = ahead.projections[k];
  return ahead.is_in_front[k];
}

}  // namespace raylign::native
