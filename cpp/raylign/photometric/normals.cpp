// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/normals.h"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <vector>

namespace raylign::photometric {
namespace {

constexpr int kNumNeighbors = 12;
constexpr int kMinNeighbors = 8;
constexpr double kMinSpread = 0.15;    // of the neighbours, across over along
constexpr double kMaxResidual = 0.02;  // median distance from the plane, share of the depth

struct Member {
  std::int64_t point;
  double x, y, rho;  // ray and inverse depth in the host
};

// The points of one host in square cells of about one neighbourhood each.
class Cells {
 public:
  explicit Cells(const std::vector<Member>& members) : members_(members) {
    for (const Member& m : members) {
      low_ = low_.cwiseMin(Vector2(m.x, m.y));
      high_ = high_.cwiseMax(Vector2(m.x, m.y));
    }
    const Vector2 size = (high_ - low_).cwiseMax(1e-9);
    side_ = std::sqrt(size.x() * size.y() * kNumNeighbors / static_cast<double>(members.size()));
    side_ = std::max(side_, size.maxCoeff() / kMaxCells);
    width_ = static_cast<int>(size.x() / side_) + 1;
    cells_.resize(static_cast<std::size_t>(width_) * (static_cast<int>(size.y() / side_) + 1));
    for (std::size_t i = 0; i < members.size(); ++i) {
      cells_[column(members[i].x) + width_ * row(members[i].y)].push_back(static_cast<int>(i));
    }
  }

  /// The nearest kNumNeighbors of the cells around a member, itself included, nearest first.
  std::vector<int> around(const Member& center) const {
    std::vector<int> found;
    const int height = static_cast<int>(cells_.size()) / width_;
    for (int r = std::max(row(center.y) - 1, 0); r <= std::min(row(center.y) + 1, height - 1);
         ++r) {
      for (int c = std::max(column(center.x) - 1, 0);
           c <= std::min(column(center.x) + 1, width_ - 1); ++c) {
        const auto& cell = cells_[c + width_ * r];
        found.insert(found.end(), cell.begin(), cell.end());
      }
    }
    const auto distance = [&](int i) {
      return std::hypot(members_[i].x - center.x, members_[i].y - center.y);
    };
    const auto nearer = [&](int a, int b) {
      return std::make_pair(distance(a), a) < std::make_pair(distance(b), b);
    };
    const auto keep = std::min<std::size_t>(found.size(), kNumNeighbors);
    std::partial_sort(found.begin(), found.begin() + keep, found.end(), nearer);
    found.resize(keep);
    return found;
  }

 private:
  static constexpr double kMaxCells = 1000.0;  // along one side

  int column(double x) const { return static_cast<int>((x - low_.x()) / side_); }
  int row(double y) const { return static_cast<int>((y - low_.y()) / side_); }

  const std::vector<Member>& members_;
  Vector2 low_ = Vector2::Constant(1e300);
  Vector2 high_ = Vector2::Constant(-1e300);
  double side_ = 1.0;
  int width_ = 1;
  std::vector<std::vector<int>> cells_;
};

double median(std::vector<double>& values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

// (a, b, c) of rho = a (x − x0) + b (y − y0) + c by least squares, twice: the second time without
// the neighbours that are farther off than most. False when the neighbours lie along a line.
bool fit_plane(const std::vector<Member>& near,
               const Member& center,
               Vector3& abc,
               double& spread) {
  std::vector<double> weights(near.size(), 1.0);
  for (int pass = 0; pass < 2; ++pass) {
    Matrix3 H = Matrix3::Zero();
    Vector3 g = Vector3::Zero();
    for (std::size_t i = 0; i < near.size(); ++i) {
      const Vector3 row(near[i].x - center.x, near[i].y - center.y, 1.0);
      H += weights[i] * row * row.transpose();
      g += weights[i] * near[i].rho * row;
    }
    const Vector2 mean = H.block<2, 1>(0, 2) / H(2, 2);
    const Eigen::Matrix2d S = H.topLeftCorner<2, 2>() / H(2, 2) - mean * mean.transpose();
    const Vector2 axes = Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(S).eigenvalues();
    if (!(axes[0] > kMinSpread * kMinSpread * axes[1])) return false;
    abc = H.ldlt().solve(g);
    std::vector<double> errors;
    for (const Member& m : near) {
      errors.push_back(
          std::abs(abc[0] * (m.x - center.x) + abc[1] * (m.y - center.y) + abc[2] - m.rho));
    }
    std::vector<double> sorted = errors;
    spread = median(sorted);
    for (std::size_t i = 0; i < near.size(); ++i) {
      weights[i] = errors[i] <= 3.0 * spread + 1e-12 ? 1.0 : 0.0;
    }
  }
  return true;
}

Vector3 normal_at(const std::vector<Member>& members, const Cells& cells, const Member& center) {
  const Vector3 none = Vector3::Constant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Member> near;
  for (const int i : cells.around(center)) near.push_back(members[i]);
  if (near.size() < kMinNeighbors) return none;
  Vector3 abc;
  double spread = 0.0;
  if (!fit_plane(near, center, abc, spread)) return none;
  if (!(spread <= kMaxResidual * center.rho) ||
      !(std::abs(abc[2] - center.rho) <= 2.0 * kMaxResidual * center.rho)) {
    return none;
  }
  // rho = n · r / d with the ray r = (x, y, 1): n is proportional to the coefficients.
  return Vector3(abc[0], abc[1], abc[2] - abc[0] * center.x - abc[1] * center.y).normalized();
}

}  // namespace

Rows<double, 3> fit_normals(const PhotometricState& state,
                            const PatchHosts& hosts,
                            const Rows<double, 3>& given) {
  Rows<double, 3> normals = given;
  if (given.rows() == 0) {
    normals.setConstant(state.points.rows(), 3, std::numeric_limits<double>::quiet_NaN());
  }
  std::vector<std::vector<Member>> by_host(state.poses.size());
  for (Eigen::Index p = 0; p < state.points.rows(); ++p) {
    if (hosts.image[p] < 0 || !hosts.uv.row(p).allFinite()) continue;
    const double z = state.in_camera(hosts.image[p], state.points.row(p)).z();
    const Vector3 ray = state.ray(hosts.image[p], hosts.uv.row(p));
    if (z > 0.0) by_host[hosts.image[p]].push_back({p, ray.x(), ray.y(), 1.0 / z});
  }
  for (const std::vector<Member>& members : by_host) {
    if (members.size() < kMinNeighbors) continue;
    const Cells cells(members);
    for (const Member& member : members) {
      if (normals.row(member.point).allFinite()) continue;
      normals.row(member.point) = normal_at(members, cells, member);
    }
  }
  return normals;
}

}  // namespace raylign::photometric
