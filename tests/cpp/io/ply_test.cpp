// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/io/ply.h"

#include <gtest/gtest.h>

#include <cstring>
#include <limits>
#include <string>

#include "raylign/base/error.h"
#include "raylign/scene/bundle_scene.h"
#include "support/eigen_matchers.h"
#include "support/small_problem.h"

// Geometry and colours of the file are checked by an independent parser in
// tests/python/test_io_ply.py.
namespace raylign::test {
namespace {

constexpr std::size_t kVertexBytes = 15;
constexpr std::size_t kFaceBytes = 13;

struct Written {
  PlySummary summary;
  std::string header;
  std::string body;
};

Written write(const BalProblem& problem, const PlyOptions& options = {}) {
  std::string text;
  const auto sink = make_string_sink(&text);
  Written written{write_ply(problem, *sink, options), {}, {}};
  const std::size_t end = text.find("end_header\n") + 11;
  written.header = text.substr(0, end);
  written.body = text.substr(end);
  return written;
}

Vector3 vertex(const Written& written, std::size_t i) {
  float xyz[3];
  std::memcpy(xyz, written.body.data() + i * kVertexBytes, sizeof(xyz));
  return {xyz[0], xyz[1], xyz[2]};
}

TEST(Ply, SizesAgreeWithTheHeader) {
  const Written written = write(small_problem(5, 40));
  EXPECT_NE(written.header.find("element vertex 70\n"), std::string::npos);
  EXPECT_NE(written.header.find("element face 35\n"), std::string::npos);
  EXPECT_EQ(written.body.size(), 70 * kVertexBytes + 35 * kFaceBytes);
}

TEST(Ply, FrustaStartAtTheCentresAndOpenForwards) {
  const BalProblem problem = small_problem(5, 40);
  PlyOptions options;
  options.camera_scale = 0.5;
  const Written written = write(problem, options);
  const Rows<double, 3> centers = camera_centers(problem);
  for (int c = 0; c < 5; ++c) {
    EXPECT_TRUE(is_near(vertex(written, 40 + 6 * c), centers.row(c).transpose(), 1e-6));
    const Matrix3 R_cw = so3_exp(problem.cameras.row(c).head<3>().transpose());
    for (int k = 1; k < 6; ++k) {
      const Vector3 p_c = R_cw * (vertex(written, 40 + 6 * c + k) - centers.row(c).transpose());
      EXPECT_NEAR(p_c.z(), -0.5, 1e-5);
    }
  }
}

TEST(Ply, SkipsWhatIsNotFinite) {
  BalProblem problem = small_problem(5, 40);
  problem.points(3, 1) = std::numeric_limits<double>::infinity();
  problem.cameras(2, 0) = std::numeric_limits<double>::quiet_NaN();
  const Written written = write(problem);
  EXPECT_EQ(written.summary.num_skipped_points, 1);
  EXPECT_EQ(written.summary.num_skipped_cameras, 1);
  EXPECT_EQ(written.body.size(), (39 + 4 * 6) * kVertexBytes + 4 * 7 * kFaceBytes);
}

TEST(Ply, ImpossibleInputIsRefused) {
  PlyOptions options;
  options.camera_scale = -1.0;
  EXPECT_THROW(write(small_problem(), options), OptionsError);
  BalProblem problem = small_problem();
  problem.camera_index[0] = 99;
  EXPECT_THROW(write(problem), ShapeError);
}

}  // namespace
}  // namespace raylign::test
