// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/kernels.h"

#include <gtest/gtest.h>

#include "bundle/reference.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/bundle/native/product_plan.h"
#include "raylign/bundle/native/schur_kernels.h"
#include "support/eigen_matchers.h"
#include "support/numeric_jacobian.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

using test::is_near;
using test::is_relatively_near;
using test::reference_observation;
using Vector9 = Eigen::Matrix<double, 9, 1>;
using Block9 = Eigen::Map<const Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;

// A small problem, its packets, and the linearisation by the kernels.
struct Fixture {
  Loss loss;
  BalProblem problem;
  Layout layout{problem};
  CameraBlocks cameras{problem, PoseParametrization::SE3, resolve_constants(problem, {}),
                       layout.observed};
  std::vector<double> X;
  std::vector<ObservationJacobian> J{static_cast<std::size_t>(layout.num_observations())};
  std::vector<LandmarkBlock> blocks{static_cast<std::size_t>(layout.num_landmarks())};
  std::vector<CameraSums> sums{static_cast<std::size_t>(layout.num_cameras), CameraSums{}};
  double cost = 0.0;

  explicit Fixture(Loss law, BalProblem scene = test::small_problem(), Linearize* body = linearize)
      : loss(law), problem(std::move(scene)) {
    for (const std::int32_t p : layout.points) {
      for (int k = 0; k < 3; ++k) X.push_back(problem.points(p, k));
    }
    std::vector<CameraRows> scratch(layout.max_window());
    const State state{layout.observations(), cameras.packets(), X.data(), &loss};
    cost = body(state, 0, layout.num_windows(),
                {{J.data(), nullptr}, blocks.data(), sums.data(), 0, scratch.data()});
  }
  Vector3 point(std::int64_t j) const { return Eigen::Map<const Vector3>(X.data() + 3 * j); }
  Jacobians jacobians() const { return {const_cast<ObservationJacobian*>(J.data()), nullptr}; }
  Vector2 uv(std::int64_t q) const { return Eigen::Map<const Vector2>(layout.uv.data() + 2 * q); }
};

class Kernels : public testing::TestWithParam<LossType> {};

void expect_scalar_twin(const Fixture& s) {
  double cost = 0.0;
  std::vector<Eigen::Matrix<double, 9, 9>> U(s.layout.num_cameras,
                                             Eigen::Matrix<double, 9, 9>::Zero());
  std::vector<Vector9> g(s.layout.num_cameras, Vector9::Zero());
  for (std::int64_t j = 0; j < s.layout.num_landmarks(); ++j) {
    Matrix3 H = Matrix3::Zero();
    Vector3 g_j = Vector3::Zero();
    for (auto q = s.layout.starts[j]; q < s.layout.starts[j + 1]; ++q) {
      const std::int32_t i = s.layout.camera[q];
      const auto twin = reference_observation(s.cameras.packets()[i], s.point(j), s.uv(q), s.loss);
      cost += twin.cost;
      U[i] += twin.F.transpose() * twin.F;
      g[i] += twin.F.transpose() * twin.r;
      H += twin.A.transpose() * twin.A;
      g_j += twin.A.transpose() * twin.r;
      EXPECT_TRUE(is_relatively_near(Eigen::Map<const RowMajor<2, 3>>(s.J[q].A), twin.A, 1e-12));
      EXPECT_TRUE(is_relatively_near(Eigen::Map<const RowMajor<2, 3>>(s.J[q].I),
                                     twin.F.rightCols<3>(), 1e-12));
    }
    Vector6 packed;
    packed << H(0, 0), H(0, 1), H(0, 2), H(1, 1), H(1, 2), H(2, 2);
    EXPECT_TRUE(is_relatively_near(Eigen::Map<const Vector6>(s.blocks[j].H), packed, 1e-12));
    EXPECT_TRUE(is_relatively_near(Eigen::Map<const Vector3>(s.blocks[j].g), g_j, 1e-11));
  }
  EXPECT_NEAR(s.cost, cost, 1e-12 * cost);
  for (std::int32_t i = 0; i < s.layout.num_cameras; ++i) {
    EXPECT_TRUE(is_relatively_near(Block9(s.sums[i].U.values).leftCols<9>(), U[i], 1e-12));
    EXPECT_TRUE(is_relatively_near(Eigen::Map<const Vector9>(s.sums[i].g), g[i], 1e-11));
    EXPECT_TRUE(Block9(s.sums[i].U.values).rightCols<3>().isZero(0.0));  // the padding
  }
}

TEST_P(Kernels, LinearizationEqualsItsScalarTwin) {
  expect_scalar_twin(Fixture({GetParam(), 20.0}, test::small_problem(), narrow_linearize()));
  if (wide_linearize() == nullptr) GTEST_SKIP() << "no AVX-512";
  expect_scalar_twin(Fixture({GetParam(), 20.0}, test::small_problem(), wide_linearize()));
}

INSTANTIATE_TEST_SUITE_P(
    Losses,
    Kernels,
    testing::Values(LossType::TRIVIAL, LossType::HUBER, LossType::CAUCHY, LossType::TUKEY),
    [](const auto& instance) { return to_string(instance.param); });

// The canonical tangent against numeric differentiation of the residual itself.
TEST(CanonicalTangent, JacobianIsTheDerivativeAlongIt) {
  const Fixture s(Loss{});
  for (std::int64_t q = 0; q < s.layout.num_observations(); q += 7) {
    const std::int64_t j = q / s.layout.num_cameras;  // every camera sees every point
    const CameraPacket& camera = s.cameras.packets()[s.layout.camera[q]];
    const Matrix3 R = Eigen::Map<const RowMajor<3, 3>>(camera.R);
    const Vector3 c = Eigen::Map<const Vector3>(camera.c);
    const auto moved = [&](const Vector9& d) {
      Vector2 r;
      reprojection_residual(R * so3_exp(d.head<3>()) * (s.point(j) - c - d.segment<3>(3)),
                            Eigen::Map<const Vector3>(camera.intrinsics) + d.tail<3>(), s.uv(q), r);
      return r;
    };
    const auto twin = reference_observation(camera, s.point(j), s.uv(q), Loss{});
    const test::Rows9 numeric = test::numeric_jacobian(moved, Vector9(Vector9::Zero()));
    EXPECT_TRUE(is_relatively_near(twin.F, numeric, 1e-8));
  }
}

// S and b of random landmarks by both bodies of the kernel, against the sum that defines them.
class Subtraction : public testing::TestWithParam<bool> {  // long tracks: no plan
 protected:
  const Fixture fixture_{Loss{}, test::small_problem(GetParam() ? 70 : 6, 30)};
  const SchurPattern pattern_{fixture_.layout,
                              std::vector<unsigned char>(fixture_.layout.num_cameras, 1)};
  const ProductPlan plan_{fixture_.layout, pattern_};

  void expect_definition(SubtractLandmarks* subtract) const {
    expect_definition(subtract, fixture_.jacobians());
    expect_definition(subtract, {nullptr, nullptr});  // J computed again
  }

  void expect_definition(SubtractLandmarks* subtract, const Jacobians& J) const {
    const Fixture& s = fixture_;
    std::vector<LandmarkFactor> factors(s.blocks.size());
    auto rng = test::make_rng("factors");
    for (LandmarkFactor& factor : factors) {
      for (double& w : factor.W) w = 0.01 * rng.normal();
    }
    const int count = s.layout.num_cameras;
    std::vector<Block> blocks(pattern_.num_blocks(), Block{});
    std::vector<double> rhs(count * kRow, 0.0);
    std::vector<Elimination> scratch(s.layout.max_window());
    const SchurBlocks S{pattern_.active.data(), pattern_.starts.data(), pattern_.columns.data(),
                        blocks.data(), rhs.data()};
    const ProductWindows windows{static_cast<std::int64_t>(plan_.windows.size()),
                                 plan_.windows.data(), plan_.visits.data(), plan_.products.data()};
    const DampedProblem problem{s.layout.observations(),
                                s.cameras.packets(),
                                s.X.data(),
                                J,
                                s.blocks.data(),
                                factors.data(),
                                nullptr,
                                nullptr,
                                0};
    for (const auto& [begin, end] : {std::pair(0, 2), std::pair(2, count)}) {
      subtract(problem, windows, {begin, end}, S, scratch.data());
    }
    for (int i = 0; i < count; ++i) {
      Vector9 b = Vector9::Zero();
      for (int k = i; k < count; ++k) {
        Eigen::Matrix<double, 9, 9> expected = Eigen::Matrix<double, 9, 9>::Zero();
        for (std::int64_t j = 0; j < s.layout.num_landmarks(); ++j) {
          Matrix3 W = Matrix3::Zero();
          const double* w = factors[j].W;
          W << w[0], w[1], w[2], 0.0, w[3], w[4], 0.0, 0.0, w[5];
          const auto Z = [&](int camera) -> Eigen::Matrix<double, 9, 3> {
            const auto twin = reference_observation(s.cameras.packets()[camera], s.point(j),
                                                    s.uv(s.layout.starts[j] + camera), s.loss);
            return twin.F.transpose() * twin.A * W;
          };
          expected -= Z(i) * Z(k).transpose();
          if (k == i) b += Z(i) * W.transpose() * Eigen::Map<const Vector3>(s.blocks[j].g);
        }
        EXPECT_TRUE(is_relatively_near(Block9(blocks[pattern_.find(i, k)].values).leftCols<9>(),
                                       expected, 1e-11));
      }
      EXPECT_TRUE(is_relatively_near(Eigen::Map<const Vector9>(rhs.data() + i * kRow), b, 1e-11));
    }
  }
};

TEST_P(Subtraction, NarrowBodyIsTheDefinition) { expect_definition(narrow_subtract_landmarks()); }

TEST_P(Subtraction, WideBodyIsTheDefinition) {
  if (wide_subtract_landmarks() == nullptr) GTEST_SKIP() << "no AVX-512";
  expect_definition(wide_subtract_landmarks());
}

INSTANTIATE_TEST_SUITE_P(Tracks, Subtraction, testing::Bool(), [](const auto& instance) {
  return instance.param ? "long" : "planned";
});

TEST(FoldBlock, IsTheTripleProduct) {
  auto rng = test::make_rng("fold block");
  Block M{};
  Block B_i{};
  Block B_k{};
  for (Block* block : {&M, &B_i, &B_k}) {
    for (int k = 0; k < kBlock; ++k) block->values[k] = k % kRow < 9 ? rng.normal() : 0.0;
  }
  Eigen::Matrix<double, 4, 7, Eigen::RowMajor> out;
  fold_block(M, B_i, B_k, 4, 7, out.data(), 7);
  const auto square = [](const Block& block) { return Block9(block.values).leftCols<9>().eval(); };
  const auto expected = (square(B_i).transpose() * square(M) * square(B_k)).eval();
  EXPECT_TRUE(is_near(out, expected.topLeftCorner<4, 7>(), 1e-12));
}

TEST(Layout, WalksLandmarksByLowestCameraAndObservationsByCamera) {
  BalProblem problem;
  problem.cameras.setZero(3, 9);
  problem.points.setZero(4, 3);
  problem.camera_index.resize(6);
  problem.point_index.resize(6);
  problem.observations.resize(6, 2);
  problem.camera_index << 2, 1, 2, 0, 1, 2;
  problem.point_index << 0, 0, 3, 3, 3, 3;
  for (int i = 0; i < 6; ++i) problem.observations.row(i) << i, -i;
  const Layout layout(problem);
  EXPECT_EQ(layout.points, (Table<std::int32_t>{3, 0}));
  EXPECT_EQ(layout.starts, (Table<std::int64_t>{0, 4, 6}));
  EXPECT_EQ(layout.camera, (Table<std::int32_t>{0, 1, 2, 2, 1, 2}));
  EXPECT_EQ(layout.uv, (Table<double>{3, -3, 4, -4, 2, -2, 5, -5, 1, -1, 0, 0}));
  EXPECT_EQ(layout.observed, (std::vector<bool>{true, true, true}));
  EXPECT_EQ(layout.max_track_length(), 4);
  EXPECT_EQ(layout.windows, (std::vector<std::int64_t>{0, 2}));
  EXPECT_EQ(layout.places, (Table<std::int32_t>{0, 1, 4, 2, 3, 5}));
  std::vector<std::pair<int, int>> visits;
  for (const CameraVisit& visit : layout.visits) visits.emplace_back(visit.camera, visit.end);
  EXPECT_EQ(visits, (std::vector<std::pair<int, int>>{{0, 1}, {1, 3}, {2, 6}}));
}

TEST(Layout, ChunksCoverAllLandmarksOnce) {
  const Layout layout(test::small_problem(6, 5000));
  EXPECT_GT(layout.num_chunks(), 1);
  EXPECT_EQ(layout.chunks.front(), 0);
  EXPECT_EQ(layout.chunks.back(), layout.num_landmarks());
  EXPECT_TRUE(std::is_sorted(layout.chunks.begin(), layout.chunks.end()));
  for (int g = 0; g <= layout.num_chunks(); ++g) {
    EXPECT_EQ(layout.windows[layout.chunk_windows[g]], layout.chunks[g]);
  }
  for (int w = 0; w < layout.num_windows(); ++w) {
    EXPECT_LT(layout.windows[w], layout.windows[w + 1]);
  }
  EXPECT_LE(layout.max_window(), Layout::kWindow);
}

}  // namespace
}  // namespace raylign::native
