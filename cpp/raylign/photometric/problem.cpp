// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/problem.h"

#include <Eigen/Cholesky>
#include <cmath>
#include <string>

#include "raylign/base/error.h"
#include "raylign/scene/problem_checks.h"

namespace raylign {
namespace {

std::string name(const char* field) { return std::string("PhotometricProblem.") + field; }

std::string row(const char* field, std::int64_t i) {
  return name(field) + "[" + std::to_string(i) + "]";
}

// Optional tables have no rows or one per `other`.
template <typename Table>
void check_optional(const char* field,
                    const Table& table,
                    const char* other,
                    std::int64_t expected) {
  if (table.rows() != 0) check_rows(name(field), table.rows(), other, expected);
}

template <typename Table>
void check_finite(const char* field, const Table& table) {
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    if (!table.row(i).allFinite()) throw ShapeError(row(field, i) + " is not finite");
  }
}

// NaN throughout means that there is none; some NaN, or infinity, is a mistake.
template <typename Table>
void check_finite_or_none(const char* field, const Table& table) {
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    if (table.row(i).allFinite() || table.row(i).array().isNaN().all()) continue;
    throw ShapeError(row(field, i) + " must be finite, or NaN throughout");
  }
}

void check_images(const PhotometricProblem& problem) {
  const std::int64_t M = problem.num_images();
  check_rows(name("images"), static_cast<std::int64_t>(problem.images.size()), "T_cw", M);
  if (!problem.masks.empty()) {
    check_rows(name("masks"), static_cast<std::int64_t>(problem.masks.size()), "images", M);
  }
  for (std::int64_t i = 0; i < M; ++i) {
    if (!problem.images[i] || problem.images[i]->num_levels() == 0) {
      throw ShapeError(row("images", i) + " is empty");
    }
    const Plane<float>& image = problem.images[i]->level(0);
    if (problem.masks.empty() || !problem.masks[i]) continue;
    const Plane<std::uint8_t>& mask = *problem.masks[i];
    if (mask.width() == image.width() && mask.height() == image.height()) continue;
    throw ShapeError(row("masks", i) + " is " + std::to_string(mask.width()) + " x " +
                     std::to_string(mask.height()) + ", but the image is " +
                     std::to_string(image.width()) + " x " + std::to_string(image.height()));
  }
}

void check_cameras(const PhotometricProblem& problem) {
  if (problem.intrinsics.rows() != 1) {
    check_rows(name("intrinsics"), problem.intrinsics.rows(), "T_cw", problem.num_images());
  }
  check_finite("intrinsics", problem.intrinsics);
  for (Eigen::Index i = 0; i < problem.intrinsics.rows(); ++i) {
    if (problem.intrinsics(i, 0) > 0.0 && problem.intrinsics(i, 1) > 0.0) continue;
    throw ShapeError(row("intrinsics", i) + " has a focal length <= 0");
  }
  for (std::int64_t i = 0; i < problem.num_images(); ++i) {
    check_rigid(row("T_cw", i), problem.pose(i));
  }
  check_optional("brightness", problem.brightness, "T_cw", problem.num_images());
  check_finite("brightness", problem.brightness);
}

void check_sources(const PhotometricProblem& problem, int pattern_size) {
  const std::int64_t N = problem.num_points();
  check_optional("patches", problem.patches, "points", N);
  if (problem.has_patches() && problem.patches.cols() != pattern_size) {
    throw ShapeError(name("patches") + " has " + std::to_string(problem.patches.cols()) +
                     " columns, but the pattern has " + std::to_string(pattern_size) + " pixels");
  }
  check_finite("patches", problem.patches);
  check_optional("hosts", problem.hosts, "points", N);
  for (Eigen::Index p = 0; p < problem.hosts.rows(); ++p) {
    const std::int32_t host = problem.hosts[p];
    if (host >= 0 ? host < problem.num_images() : host == -1 && problem.has_patches()) continue;
    throw ShapeError(row("hosts", p) + " is " + std::to_string(host) + ", not in [" +
                     (problem.has_patches() ? "-1, " : "0, ") +
                     std::to_string(problem.num_images()) + ")");
  }
  check_optional("host_uv", problem.host_uv, "points", N);
  check_finite_or_none("host_uv", problem.host_uv);
  check_optional("normals", problem.normals, "points", N);
  check_finite_or_none("normals", problem.normals);
}

void check_tracks(const PhotometricProblem& problem) {
  check_rows(name("track_point"), problem.track_point.rows(), "track_image",
             problem.track_image.rows());
  check_index(name("track_image"), problem.track_image, problem.num_images());
  check_index(name("track_point"), problem.track_point, problem.num_points());
}

// Symmetric and positive definite, by its Cholesky factor.
template <int N>
void check_covariances(const char* field, const Rows<double, N * N>& table) {
  check_finite_or_none(field, table);
  for (Eigen::Index i = 0; i < table.rows(); ++i) {
    if (std::isnan(table(i, 0))) continue;
    const RowMajor<N, N> C = Eigen::Map<const RowMajor<N, N>>(table.row(i).data());
    const bool symmetric = (C - C.transpose()).cwiseAbs().maxCoeff() <= 1e-9 * C.norm();
    if (symmetric && Eigen::LLT<RowMajor<N, N>>(C).info() == Eigen::Success) continue;
    throw ShapeError(row(field, i) + " is not symmetric and positive definite");
  }
}

void check_priors(const PhotometricProblem& problem) {
  check_optional("pose_covariances", problem.pose_covariances, "T_cw", problem.num_images());
  check_optional("point_covariances", problem.point_covariances, "points", problem.num_points());
  check_optional("depth_sigmas", problem.depth_sigmas, "points", problem.num_points());
  check_covariances<6>("pose_covariances", problem.pose_covariances);
  check_covariances<3>("point_covariances", problem.point_covariances);
  check_finite_or_none("depth_sigmas", problem.depth_sigmas);
  for (Eigen::Index p = 0; p < problem.depth_sigmas.rows(); ++p) {
    if (std::isnan(problem.depth_sigmas[p]) || problem.depth_sigmas[p] > 0.0) continue;
    throw ShapeError(row("depth_sigmas", p) + " must be > 0");
  }
}

template <typename Table>
bool has_row(const Table& table) {
  return table.rows() > 0 && !table.col(0).array().isNaN().all();
}

}  // namespace

Matrix4 PhotometricProblem::pose(std::int64_t i) const {
  return Eigen::Map<const RowMajor<4, 4>>(T_cw.row(i).data());
}

void PhotometricProblem::validate(int pattern_size) const {
  check_count(name("T_cw"), num_images());
  check_count(name("points"), num_points());
  check_images(*this);
  check_cameras(*this);
  check_finite("points", points);
  check_sources(*this, pattern_size);
  check_tracks(*this);
  check_priors(*this);
}

Gauge default_gauge(const PhotometricProblem& problem) {
  if (has_row(problem.pose_covariances) || has_row(problem.point_covariances)) return Gauge::FREE;
  return has_row(problem.depth_sigmas) ? Gauge::FIRST_CAMERA : Gauge::TWO_CAMERAS;
}

}  // namespace raylign
