// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/report.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raylign::photometric {
namespace {

constexpr double kNaN = std::numeric_limits<double>::quiet_NaN();

struct SumOfSquares {
  double sum = 0.0;
  std::int64_t count = 0;

  void add(const SumOfSquares& other) {
    sum += other.sum;
    count += other.count;
  }
  double rms() const { return count > 0 ? std::sqrt(sum / static_cast<double>(count)) : kNaN; }
};

SumOfSquares squares_of(const PatchScene& scene, const PatchEdge& edge, const EdgeSample& sample) {
  SumOfSquares squares;
  for (int n = 0; sample.is_seen && n < scene.pattern.size(); ++n) {
    if (!sample.counts(edge, n)) continue;
    squares.sum += sample.residual[n] * sample.residual[n];
    ++squares.count;
  }
  return squares;
}

// Root mean squares of one state by edge, point and image.
struct RmsTables {
  RmsTables(const Views& views, std::int64_t num_images)
      : points(views.scene.num_points()),
        images(num_images),
        edge_rms(Rows<double, 1>::Constant(views.scene.num_edges(), kNaN)) {}

  void add(std::int64_t p, std::int64_t e, std::int32_t image, const SumOfSquares& squares) {
    edge_rms[e] = squares.rms();
    points[p].add(squares);
    images[image].add(squares);
  }
  static Rows<double, 1> rms(const std::vector<SumOfSquares>& all) {
    Rows<double, 1> table(static_cast<Eigen::Index>(all.size()));
    for (std::size_t i = 0; i < all.size(); ++i) table[static_cast<Eigen::Index>(i)] = all[i].rms();
    return table;
  }

  std::vector<SumOfSquares> points, images;
  Rows<double, 1> edge_rms;
};

double median(std::vector<double>& values) {
  if (values.empty()) return 0.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

void list_edges(const Views& views, PhotometricResult& result) {
  const std::int64_t E = views.scene.num_edges();
  result.edge_image.resize(E);
  result.edge_point.resize(E);
  for (std::int64_t p = 0; p < views.scene.num_points(); ++p) {
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      result.edge_image[e] = views.scene.edges[e].image;
      result.edge_point[e] = static_cast<std::int32_t>(p);
    }
  }
}

void report_sources(const Setting& setting, const Views& end, PhotometricResult& result) {
  const std::int64_t N = setting.num_points();
  result.hosts = Eigen::Map<const Rows<std::int32_t, 1>>(setting.hosts.image.data(), N);
  result.host_uv = setting.hosts.uv;
  result.normals = end.normals;
  result.patches = Eigen::Map<const Rows<float, Eigen::Dynamic>>(end.scene.patches.data(), N,
                                                                 setting.options.pattern.size());
}

}  // namespace

void report_views(const Setting& setting,
                  const Views& start,
                  const Views& end,
                  const std::vector<bool>& held,
                  PhotometricResult& result) {
  const std::int64_t M = setting.problem.num_images();
  list_edges(end, result);
  report_sources(setting, end, result);
  result.edge_status = end.edges;
  result.point_status = end.points;
  RmsTables before(end, M);
  RmsTables after(end, M);
  std::vector<std::vector<double>> shifts(M);
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    const bool was_used =
        end.points[p] == PointStatus::OK || end.points[p] == PointStatus::DIVERGED;
    if (held[p] && was_used) result.point_status[p] = PointStatus::FIXED;  // it had no say
    for (std::int64_t e = end.scene.starts[p]; e < end.scene.starts[p + 1]; ++e) {
      const PatchEdge& edge = end.scene.edges[e];
      if (end.edges[e] != EdgeStatus::OK) continue;
      const EdgeSample a = evaluate_edge(start.scene, p, start.scene.edges[e]);
      const EdgeSample b = evaluate_edge(end.scene, p, edge);
      before.add(p, e, edge.image, squares_of(start.scene, start.scene.edges[e], a));
      after.add(p, e, edge.image, squares_of(end.scene, edge, b));
      if (a.is_seen && b.is_seen) shifts[edge.image].push_back((a.uv - b.uv).norm());
    }
  }
  result.edge_rms_before = before.edge_rms;
  result.edge_rms_after = after.edge_rms;
  result.point_rms_before = RmsTables::rms(before.points);
  result.point_rms_after = RmsTables::rms(after.points);
  result.image_rms_before = RmsTables::rms(before.images);
  result.image_rms_after = RmsTables::rms(after.images);
  result.shift_px.resize(M);
  for (std::int64_t i = 0; i < M; ++i) result.shift_px[i] = median(shifts[i]);
}

}  // namespace raylign::photometric
