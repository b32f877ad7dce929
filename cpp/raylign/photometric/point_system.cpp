// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/point_system.h"

#include <cmath>

#include "raylign/parametrization/pose_update.h"

namespace raylign {
namespace {

Eigen::RowVector2d gradient(const EdgeSample& sample, Eigen::Index n) {
  const auto& g = sample.gradient[static_cast<std::size_t>(n)];
  return {g[0], g[1]};
}

}  // namespace

PatchColumns patch_columns(const PatchScene& scene, const PatchConstraints& constraints) {
  PatchColumns columns;
  int next = 0;
  const auto take = [&](bool held) { return held ? -1 : next++; };
  for (std::int64_t j = 0; j < scene.num_images(); ++j) {
    columns.embeddings.push_back(
        pose_embedding(TranslationUpdate::COUPLED, constraints.poses[j], scene.poses[j].t));
    columns.poses.push_back(next);
    next += static_cast<int>(columns.embeddings.back().cols());
    const auto& held = constraints.brightness[j];
    const int a = take(held[0]);
    columns.brightness.push_back({a, take(held[1])});
  }
  for (const auto& held : constraints.intrinsics) {
    columns.intrinsics.emplace_back();
    for (int k = 0; k < 4; ++k) columns.intrinsics.back()[k] = take(held[k]);
  }
  columns.size = next;
  return columns;
}

std::array<double, PatchPattern::kMaxPixels> pixel_weights(const PatchEdge& edge,
                                                           const EdgeSample& sample,
                                                           int num_pixels,
                                                           const Loss& loss,
                                                           LossScope scope) {
  double of_patch = 1.0;
  if (scope == LossScope::PATCH) {
    double squared_norm = 0.0;
    for (int n = 0; n < num_pixels; ++n) squared_norm += sample.residual[n] * sample.residual[n];
    of_patch = loss.evaluate(squared_norm).d_rho;
  }
  std::array<double, PatchPattern::kMaxPixels> weights{};
  for (int n = 0; n < num_pixels; ++n) {
    if (!sample.counts(edge, n)) continue;
    const double r = sample.residual[n];
    weights[n] = scope == LossScope::PATCH ? of_patch : loss.evaluate(r * r).d_rho;
  }
  return weights;
}

PointSystemBuilder::PointSystemBuilder(const PatchScene& scene,
                                       const PatchColumns& columns,
                                       const PatchConstraints& constraints,
                                       const Loss& loss,
                                       LossScope scope,
                                       NoiseSite site)
    : scene_(scene),
      columns_(columns),
      constraints_(constraints),
      loss_(loss),
      scope_(scope),
      site_(site),
      local_(static_cast<std::size_t>(columns.size), -1) {
  if (constraints.point_priors.empty()) return;
  priors_.assign(static_cast<std::size_t>(scene.num_points()), Matrix3::Zero());
  for (const PatchPointPrior& prior : constraints.point_priors) {
    priors_[prior.point] += prior.information;
  }
}

const PointSystem& PointSystemBuilder::build(std::int64_t point) {
  const bool is_held = !constraints_.points.empty() && constraints_.points[point];
  const int num_free = is_held ? 0 : scene_.inverse_depth ? 1 : 3;
  system_.columns.clear();
  std::size_t num_seen = 0;
  for (std::int64_t e = scene_.starts[point]; e < scene_.starts[point + 1]; ++e) {
    if (edges_.size() <= num_seen) edges_.emplace_back();
    EdgeRows& rows = edges_[num_seen];
    if (!fill(point, scene_.edges[e], num_free, rows)) continue;
    for (int k = 0; k < rows.num_columns; ++k) {
      int& local = local_[rows.columns[k]];
      if (local < 0) {
        local = static_cast<int>(system_.columns.size());
        system_.columns.push_back(rows.columns[k]);
      }
      rows.columns[k] = local;
    }
    ++num_seen;
  }
  const auto L = static_cast<Eigen::Index>(system_.columns.size());
  const Eigen::Index n = scene_.pattern.size();
  system_.H.setZero(L, L);
  system_.W.setZero(L, num_free);
  system_.V.setZero(num_free, num_free);
  system_.steep_H.setZero(L, L);
  system_.steep_W.setZero(L, num_free);
  system_.steep_V.setZero(num_free, num_free);
  system_.prior.setZero(num_free, num_free);
  system_.gradient.setZero(L);
  system_.point_gradient.setZero(num_free);
  system_.shared.setZero(n, L);
  system_.shared_point.setZero(n, num_free);
  system_.views.fill(0.0);
  system_.host.resize(0, L);
  system_.host_point.resize(0, num_free);
  for (std::size_t e = 0; e < num_seen; ++e) add(edges_[e]);
  add_prior(point, num_free);
  for (const int column : system_.columns) local_[column] = -1;
  return system_;
}

bool PointSystemBuilder::fill(std::int64_t point,
                              const PatchEdge& edge,
                              int num_free,
                              EdgeRows& rows) const {
  const EdgeSample sample = evaluate_edge(scene_, point, edge);
  if (!sample.is_seen) return false;
  const EdgeMotion motion = edge_motion(scene_, point, edge, sample);
  const int n = scene_.pattern.size();
  rows.is_host = edge.image == scene_.hosts[point];
  rows.s = site_ == NoiseSite::IMAGE ? 1.0 / sample.brightness.gain : 1.0;
  rows.num_columns = 0;
  rows.camera.setZero(n, kMaxColumns);
  fill_motion(edge.image, scene_.hosts[point], sample, motion, rows);
  fill_brightness(edge.image, scene_.hosts[point], sample, rows);
  rows.point.setZero(n, num_free);
  rows.point_moves = motion.point;
  rows.steepness = 0.0;
  const EdgeBrightness& brightness = sample.brightness;
  const double step = std::ldexp(rows.s * brightness.scale * brightness.gain, -edge.level);
  rows.residual.setZero(n);
  const auto weights = pixel_weights(edge, sample, n, loss_, scope_);
  for (int i = 0; i < n; ++i) {
    rows.counts[i] = weights[i] > 0.0;
    if (!rows.is_host) rows.steepness += weights[i] * step * step;
    const double root = rows.s * std::sqrt(weights[i]);
    rows.point.row(i) = -root * gradient(sample, i) * motion.point.leftCols(num_free);
    rows.camera.row(i) *= root;
    rows.residual[i] = root * sample.residual[i];
  }
  return true;
}

void PointSystemBuilder::fill_motion(std::int32_t j,
                                     std::int32_t h,
                                     const EdgeSample& sample,
                                     const EdgeMotion& motion,
                                     EdgeRows& rows) const {
  auto& moves = rows.moves;
  moves.setZero();
  int k = 0;
  const auto add_pose = [&](std::int32_t image, const RowMajor<2, 6>& by_pose) {
    const PoseEmbedding& E = columns_.embeddings[image];
    moves.middleCols(k, E.cols()) = by_pose * E;
    for (int i = 0; i < E.cols(); ++i) rows.columns[k++] = columns_.poses[image] + i;
  };
  const auto add_intrinsics = [&](std::int32_t image, const RowMajor<2, 4>& by_intrinsics) {
    const auto& columns = columns_.intrinsics[scene_.intrinsics_row(image)];
    for (int i = 0; i < 4; ++i) {
      if (columns[i] < 0) continue;
      moves.col(k) = by_intrinsics.col(i);
      rows.columns[k++] = columns[i];
    }
  };
  add_pose(j, motion.pose);
  add_intrinsics(j, motion.intrinsics);
  if (scene_.inverse_depth) {
    add_pose(h, motion.host_pose);
    add_intrinsics(h, motion.host_intrinsics);
  }
  for (Eigen::Index i = 0; i < rows.camera.rows(); ++i) {
    rows.camera.row(i).head(k) = -gradient(sample, i) * moves.leftCols(k);
  }
  rows.num_columns = k;
}

void PointSystemBuilder::fill_brightness(std::int32_t j,
                                         std::int32_t h,
                                         const EdgeSample& sample,
                                         EdgeRows& rows) const {
  const auto add = [&](std::int32_t image, auto derivative) {
    for (std::size_t k = 0; k < 2; ++k) {
      if (columns_.brightness[image][k] < 0) continue;
      for (Eigen::Index i = 0; i < rows.camera.rows(); ++i) {
        rows.camera(i, rows.num_columns) = (sample.*derivative)(static_cast<int>(i))[k];
      }
      rows.columns[rows.num_columns++] = columns_.brightness[image][k];
    }
  };
  add(j, &EdgeSample::by_brightness);
  if (h >= 0) add(h, &EdgeSample::by_host_brightness);
}

void PointSystemBuilder::add(const EdgeRows& rows) {
  const auto camera = rows.camera.leftCols(rows.num_columns);
  const Eigen::MatrixXd H = camera.transpose() * camera;
  const PointColumns W = camera.transpose() * rows.point;
  const Eigen::VectorXd gradient = camera.transpose() * rows.residual;
  const auto moves = rows.moves.leftCols(rows.num_columns);
  const auto point_moves = rows.point_moves.leftCols(rows.point.cols());
  const Eigen::MatrixXd steep_H = rows.steepness * moves.transpose() * moves;
  const PointColumns steep_W = rows.steepness * moves.transpose() * point_moves;
  for (int a = 0; a < rows.num_columns; ++a) {
    const int to = rows.columns[a];
    for (int b = 0; b < rows.num_columns; ++b) {
      system_.H(to, rows.columns[b]) += H(a, b);
      system_.steep_H(to, rows.columns[b]) += steep_H(a, b);
    }
    system_.W.row(to) += W.row(a);
    system_.steep_W.row(to) += steep_W.row(a);
    system_.gradient[to] += gradient[a];
  }
  system_.V += rows.point.transpose() * rows.point;
  system_.steep_V += rows.steepness * point_moves.transpose() * point_moves;
  system_.point_gradient += rows.point.transpose() * rows.residual;
  if (rows.is_host) {
    system_.host.setZero(rows.camera.rows(), system_.H.cols());
    for (int a = 0; a < rows.num_columns; ++a) {
      system_.host.col(rows.columns[a]) += rows.camera.col(a);
    }
    system_.host_point = rows.point;
    return;
  }
  for (int a = 0; a < rows.num_columns; ++a) {
    system_.shared.col(rows.columns[a]) += rows.s * rows.camera.col(a);
  }
  system_.shared_point += rows.s * rows.point;
  for (Eigen::Index n = 0; n < rows.camera.rows(); ++n) {
    if (rows.counts[n]) system_.views[n] += rows.s * rows.s;
  }
}

void PointSystemBuilder::add_prior(std::int64_t point, int num_free) {
  if (priors_.empty()) return;
  system_.prior = priors_[point].topLeftCorner(num_free, num_free);
  system_.V += system_.prior;
}

}  // namespace raylign
