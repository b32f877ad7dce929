// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/geometry/umeyama.h"

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <limits>

#include "raylign/base/error.h"
#include "raylign/geometry/se3.h"
#include "raylign/geometry/sim3.h"
#include "support/eigen_matchers.h"
#include "support/named_rng.h"

namespace raylign::test {
namespace {

using Points = Rows<double, 3>;

Points random_points(NamedRng& rng, int n) {
  Points points(n, 3);
  for (int i = 0; i < n; ++i) points.row(i) = rng.normal_vector<3>(2.0).transpose();
  points.rowwise() += Vector3(10.0, -5.0, 3.0).transpose();
  return points;
}

Points transform(const Matrix4& S, const Points& points) {
  return (points * S.topLeftCorner<3, 3>().transpose()).rowwise() +
         S.topRightCorner<3, 1>().transpose();
}

double cost(const Matrix4& S, const Points& from, const Points& to) {
  return (transform(S, from) - to).squaredNorm();
}

TEST(Umeyama, RecoversTheSimilarity) {
  for (int i = 0; i < 20; ++i) {
    NamedRng rng = make_rng("umeyama_exact", i);
    const Matrix4 S = sim3_exp(rng.normal_vector<7>());
    const Points from = random_points(rng, 3 + i);
    EXPECT_TRUE(is_near(umeyama(from, transform(S, from)), S, 1e-12));
    const Matrix4 T = se3_exp(rng.normal_vector<6>());
    EXPECT_TRUE(is_near(umeyama(from, transform(T, from), false), T, 1e-12));
  }
}

TEST(Umeyama, PlanarPointsGiveARotationNotAReflection) {
  NamedRng rng = make_rng("umeyama_planar");
  Points from = random_points(rng, 10);
  from.col(2).setZero();
  const Matrix4 S = sim3_exp(rng.normal_vector<7>());
  const Matrix4 found = umeyama(from, transform(S, from));
  EXPECT_TRUE(is_near(found, S, 1e-12));
}

TEST(Umeyama, MirroredPointsStillGiveARotation) {
  NamedRng rng = make_rng("umeyama_mirror");
  const Points from = random_points(rng, 10);
  Points to = from;
  to.col(0) *= -1.0;
  EXPECT_GT((umeyama(from, to).topLeftCorner<3, 3>().determinant()), 0.0);
}

TEST(Umeyama, IsAMinimumUnderNoise) {
  for (const bool with_scale : {true, false}) {
    NamedRng rng = make_rng("umeyama_noise", with_scale);
    const Points from = random_points(rng, 30);
    Points to = transform(sim3_exp(rng.normal_vector<7>()), from);
    for (Eigen::Index i = 0; i < to.size(); ++i) to.data()[i] += rng.normal(0.5);
    const Matrix4 S = umeyama(from, to, with_scale);
    const double best = cost(S, from, to);
    for (int i = 0; i < 50; ++i) {
      Vector7 xi = rng.normal_vector<7>(1e-3);
      if (!with_scale) xi[6] = 0.0;
      EXPECT_GT(cost(sim3_exp(xi) * S, from, to), best);
    }
    if (!with_scale) {
      EXPECT_NEAR((S.topLeftCorner<3, 3>().determinant()), 1.0, 1e-14);
    }
  }
}

TEST(Umeyama, RefusesWhatDoesNotDetermineATransform) {
  NamedRng rng = make_rng("umeyama_refuse");
  const Points from = random_points(rng, 5);
  EXPECT_THROW(umeyama(from, from.topRows(4)), ShapeError);
  EXPECT_THROW(umeyama(from.topRows(2), from.topRows(2)), ShapeError);
  Points line(5, 3);
  for (int i = 0; i < 5; ++i) line.row(i) << 1.0 * i + 3.0, 2.0 * i, -0.7 * i;
  EXPECT_THROW(umeyama(line, from), Error);
  EXPECT_THROW(umeyama(from, Points::Ones(5, 3)), Error);
  Points bad = from;
  bad(2, 1) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(umeyama(bad, from), Error);
}

}  // namespace
}  // namespace raylign::test
