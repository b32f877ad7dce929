// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "bundle/reference.h"
#include "raylign/bundle/native/camera_ordering.h"
#include "raylign/bundle/native/conjugate_gradients.h"
#include "raylign/bundle/native/dense_cholesky.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/bundle/native/stale_factor.h"
#include "raylign/bundle/native/supernodal_cholesky.h"
#include "raylign/bundle/native/two_level.h"
#include "raylign/parametrization/constants.h"
#include "raylign/synthetic/bal.h"
#include "support/named_rng.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

BalProblem street(int num_cameras, SyntheticBalKind kind = SyntheticBalKind::STREET) {
  SyntheticBalOptions options;
  options.kind = kind;
  options.num_cameras = num_cameras;
  options.num_points = 40 * num_cameras;
  options.seed = 3;
  return synthetic_bal(options).problem;
}

BundleConfig held_config() {
  BundleConfig config;
  config.gauge = Gauge::TWO_CAMERAS;
  config.constant_cameras = {4, 5};
  config.constant_intrinsics = {5, 7};  // camera 5 does not move at all
  config.constant_points = {3};
  return config;
}

// A linearised problem, its S for one damping, and the same S as a dense matrix.
struct Damped {
  Damped(const BalProblem& problem, const BundleConfig& config, double lambda)
      : native(problem, resolve_constants(problem, config), BundleOptions{}) {
    native.linearize();
    damped = native.damped(lambda);
    system.form(damped);
    S = test::dense_schur(system);
  }
  SchurPattern whole_pattern() const {
    return SchurPattern(native.layout(), moving_cameras(native.cameras()));
  }
  SolverContext context() { return {native.layout(), native.cameras(), native.pool()}; }
  const CameraBlocks& cameras() const { return native.cameras(); }
  std::size_t num_rows() const { return system.rhs().size(); }
  std::vector<double> random_rows() const {
    auto rng = test::make_rng("rows");
    std::vector<double> columns(cameras().num_columns());
    for (double& x : columns) x = rng.normal();
    std::vector<double> rows(num_rows());
    unpack(cameras(), columns.data(), rows.data());
    return rows;
  }
  Eigen::VectorXd packed(const std::vector<double>& rows) const {
    Eigen::VectorXd columns(cameras().num_columns());
    pack(cameras(), rows.data(), columns.data());
    return columns;
  }

  ReprojectionProblem native;
  SchurSystem system{context(), whole_pattern()};
  DampedProblem damped{};
  Eigen::MatrixXd S;
};

// Columns have very different units: errors in the norm of S.
double relative_error(const Eigen::MatrixXd& S,
                      const Eigen::VectorXd& x,
                      const Eigen::VectorXd& expected) {
  const Eigen::VectorXd e = x - expected;
  return std::sqrt(e.dot(S * e) / expected.dot(S * expected));
}

struct Scene {
  const char* name;
  SyntheticBalKind kind;
  bool held;
};

class LinearSolvers : public testing::TestWithParam<Scene> {
 protected:
  Damped problem_{street(40, GetParam().kind), GetParam().held ? held_config() : BundleConfig{},
                  1e-4};
};

TEST_P(LinearSolvers, SIsSymmetricPositiveDefinite) {
  const Eigen::VectorXd scale = problem_.S.diagonal().cwiseSqrt().cwiseInverse();
  const Eigen::MatrixXd S = scale.asDiagonal() * problem_.S * scale.asDiagonal();
  EXPECT_LT((S - S.transpose()).cwiseAbs().maxCoeff(), 1e-13);
  EXPECT_TRUE(Eigen::LLT<Eigen::MatrixXd>(S).info() == Eigen::Success);
}

TEST_P(LinearSolvers, BothProductsAreSTimesX) {
  const std::vector<double> x = problem_.random_rows();
  const Eigen::VectorXd expected = problem_.S * problem_.packed(x);
  ExplicitProduct by_blocks(problem_.context(), problem_.system.pattern());
  MatrixFreeProduct by_landmarks(problem_.context());
  const Eigen::VectorXd scale = problem_.S.diagonal().cwiseSqrt().cwiseInverse();
  for (SchurProduct* product :
       {static_cast<SchurProduct*>(&by_blocks), static_cast<SchurProduct*>(&by_landmarks)}) {
    product->prepare(problem_.system, problem_.damped);
    std::vector<double> y(problem_.num_rows(), 7.0);
    product->multiply(x.data(), y.data());
    const Eigen::VectorXd error = problem_.packed(y) - expected;
    EXPECT_LT(error.cwiseProduct(scale).norm(), 1e-11 * expected.cwiseProduct(scale).norm());
    std::vector<double> padded(y.size());
    unpack(problem_.cameras(), problem_.packed(y).data(), padded.data());
    EXPECT_EQ(y, padded);  // zeros where there is no column
  }
}

TEST_P(LinearSolvers, DiagonalPatternHasTheDiagonalBlocksAndRightHandSideOfS) {
  SchurSystem diagonal(problem_.context(),
                       SchurPattern::diagonal(moving_cameras(problem_.cameras())));
  diagonal.form(problem_.damped);
  EXPECT_EQ(diagonal.rhs(), problem_.system.rhs());
  for (int i = 0; i < problem_.cameras().num_cameras(); ++i) {
    if (problem_.cameras().size(i) == 0) continue;
    for (int k = 0; k < kBlock; ++k) {
      ASSERT_EQ(diagonal.diagonal(i).values[k], problem_.system.diagonal(i).values[k]);
    }
  }
}

TEST_P(LinearSolvers, FactorsSolve) {
  const std::vector<double> b = problem_.random_rows();
  const Eigen::VectorXd expected = problem_.S.llt().solve(problem_.packed(b));
  DenseCholesky dense(problem_.cameras(), problem_.context().pool);
  const SchurPattern& pattern = problem_.system.pattern();
  SupernodalCholesky sparse(problem_.cameras(), pattern, order_cameras(pattern).cameras,
                            problem_.context().pool);
  for (SchurFactor* factor :
       {static_cast<SchurFactor*>(&dense), static_cast<SchurFactor*>(&sparse)}) {
    ASSERT_TRUE(factor->factor(problem_.system));
    Eigen::VectorXd x = problem_.packed(b);
    factor->solve(x.data());
    EXPECT_LT(relative_error(problem_.S, x, expected), 1e-9);
  }
}

TEST_P(LinearSolvers, EveryPreconditionerIsSymmetricPositiveDefiniteAndLeadsToTheSameSolution) {
  const std::vector<double>& b = problem_.system.rhs();
  const Eigen::VectorXd expected = problem_.S.llt().solve(problem_.packed(b));
  std::vector<std::unique_ptr<SchurPreconditioner>> preconditioners;
  preconditioners.push_back(
      std::make_unique<BlockJacobi>(problem_.cameras(), Preconditioner::JACOBI));
  preconditioners.push_back(
      std::make_unique<BlockJacobi>(problem_.cameras(), Preconditioner::SCHUR_JACOBI));
  preconditioners.push_back(
      std::make_unique<TwoLevel>(problem_.context(), problem_.system.pattern()));
  preconditioners.push_back(std::make_unique<StaleFactor>(
      problem_.cameras(),
      std::make_unique<DenseCholesky>(problem_.cameras(), problem_.context().pool)));
  // the factor is one of another damping
  SchurSystem earlier(problem_.context(), problem_.whole_pattern());
  earlier.form(problem_.native.damped(1e-3));
  preconditioners.back()->prepare(earlier, problem_.damped);
  problem_.native.damped(1e-4);
  ExplicitProduct product(problem_.context(), problem_.system.pattern());
  product.prepare(problem_.system, problem_.damped);
  MatrixFreeProduct by_landmarks(problem_.context());
  by_landmarks.prepare(problem_.system, problem_.damped);
  ConjugateGradients cg(b.size());
  for (const auto& M : preconditioners) {
    M->prepare(problem_.system, problem_.damped);
    const std::vector<double> u = problem_.random_rows();
    std::vector<double> Mu(u.size());
    std::vector<double> Mb(u.size());
    M->apply(u.data(), Mu.data());
    M->apply(b.data(), Mb.data());
    const Eigen::VectorXd pu = problem_.packed(u);
    const Eigen::VectorXd pb = problem_.packed(b);
    const double scale = std::sqrt(pu.dot(problem_.packed(Mu)) * pb.dot(problem_.packed(Mb)));
    EXPECT_GT(pu.dot(problem_.packed(Mu)), 0.0);
    EXPECT_NEAR(pu.dot(problem_.packed(Mb)), pb.dot(problem_.packed(Mu)), 1e-9 * scale);
    std::vector<double> x(u.size());
    for (SchurProduct* S :
         {static_cast<SchurProduct*>(&product), static_cast<SchurProduct*>(&by_landmarks)}) {
      const CgResult result = cg.solve(*S, *M, b, {1e-12, 0.0, 5000}, nullptr, x);
      EXPECT_TRUE(result.solved);
      EXPECT_LT(relative_error(problem_.S, problem_.packed(x), expected), 1e-9);
    }
  }
}

// The factor of one system serves the next until that takes long.
TEST_P(LinearSolvers, AStaleFactorStaysUntilItIsToldOfALongSolve) {
  StaleFactor M(problem_.cameras(),
                std::make_unique<DenseCholesky>(problem_.cameras(), problem_.context().pool));
  SchurSystem system(problem_.context(), problem_.whole_pattern());
  ExplicitProduct product(problem_.context(), system.pattern());
  ConjugateGradients cg(system.rhs().size());
  std::vector<double> x(system.rhs().size());
  const auto iterations = [&](double lambda) {
    const DampedProblem damped = problem_.native.damped(lambda);
    system.form(damped);
    M.prepare(system, damped);
    product.prepare(system, damped);
    const CgResult result = cg.solve(product, M, system.rhs(), {1e-6, 0.0, 500}, nullptr, x);
    EXPECT_TRUE(result.solved);
    return result.iterations;
  };
  EXPECT_LE(iterations(1e-3), 2);  // its own system
  M.report(StaleFactor::kMaxIterations);
  EXPECT_GT(iterations(1e-6), 2);
  EXPECT_EQ(M.num_factorizations(), 1);
  M.report(StaleFactor::kMaxIterations + 1);
  EXPECT_LE(iterations(1e-6), 2);
  EXPECT_EQ(M.num_factorizations(), 2);
}

// M⁻¹ times each column of the block that M inverts is a column of the identity.
TEST_P(LinearSolvers, BlockJacobiInvertsTheDiagonalBlocks) {
  const CameraBlocks& cameras = problem_.cameras();
  SchurSystem undone(problem_.context(), problem_.whole_pattern());  // S + Z Zᵀ = U + λD
  DampedProblem without_points = problem_.damped;
  const std::vector<LandmarkFactor> no_factors(problem_.native.layout().num_landmarks(),
                                               LandmarkFactor{});
  without_points.factors = no_factors.data();
  undone.form(without_points);
  for (const auto& [kind, system] : {std::pair(Preconditioner::SCHUR_JACOBI, &problem_.system),
                                     std::pair(Preconditioner::JACOBI, &undone)}) {
    BlockJacobi M(cameras, kind);
    M.prepare(problem_.system, problem_.damped);
    const Eigen::MatrixXd blocks = test::dense_schur(*system);
    std::vector<double> column(problem_.num_rows());
    std::vector<double> out(column.size());
    for (int i = 0; i < cameras.num_cameras(); ++i) {
      const int size = cameras.size(i);
      const auto block = blocks.block(cameras.offset(i), cameras.offset(i), size, size);
      Eigen::MatrixXd product(size, size);
      for (int k = 0; k < size; ++k) {
        std::fill(column.begin(), column.end(), 0.0);
        std::copy_n(block.col(k).eval().data(), size, column.begin() + std::ptrdiff_t{i} * kRow);
        M.apply(column.data(), out.data());
        product.col(k) = Eigen::Map<Eigen::VectorXd>(out.data() + std::ptrdiff_t{i} * kRow, size);
      }
      const Eigen::VectorXd units = block.diagonal().cwiseSqrt();
      product = units.asDiagonal() * product * units.cwiseInverse().asDiagonal();
      EXPECT_LT((product - Eigen::MatrixXd::Identity(size, size)).norm(), 1e-9) << "camera " << i;
    }
  }
}

TEST_P(LinearSolvers, ConjugateGradientsStopWhenTold) {
  const std::vector<double>& b = problem_.system.rhs();
  BlockJacobi M(problem_.cameras(), Preconditioner::SCHUR_JACOBI);
  M.prepare(problem_.system, problem_.damped);
  ExplicitProduct product(problem_.context(), problem_.system.pattern());
  product.prepare(problem_.system, problem_.damped);
  ConjugateGradients cg(b.size());
  std::vector<double> x(b.size());
  int asked = 0;
  const auto interrupted = [&] { return ++asked > 3; };
  const CgResult result = cg.solve(product, M, b, {1e-12, 0.0, 5000}, interrupted, x);
  EXPECT_TRUE(result.interrupted);
  EXPECT_EQ(result.iterations, 3);
  EXPECT_EQ(cg.solve(product, M, b, {1e-12, 0.0, 7}, nullptr, x).iterations, 7);
}

INSTANTIATE_TEST_SUITE_P(Scenes,
                         LinearSolvers,
                         testing::Values(Scene{"street", SyntheticBalKind::STREET, false},
                                         Scene{"orbit", SyntheticBalKind::ORBIT, false},
                                         Scene{"held", SyntheticBalKind::STREET, true}),
                         [](const auto& instance) { return instance.param.name; });

TEST(ConjugateGradients, ReportsAMatrixThatIsNotPositiveDefinite) {
  struct Negative : SchurProduct, SchurPreconditioner {
    void prepare(const SchurSystem&, const DampedProblem&) override {}
    void multiply(const double* x, double* y) override {
      for (int k = 0; k < 3; ++k) y[k] = -x[k];
    }
    void apply(const double* r, double* z) override { std::copy_n(r, 3, z); }
  } negative;
  ConjugateGradients cg(3);
  std::vector<double> x(3);
  EXPECT_FALSE(cg.solve(negative, negative, {1.0, 2.0, 3.0}, {}, nullptr, x).solved);
  EXPECT_FALSE(cg.solve(negative, negative, {1.0, NAN, 3.0}, {}, nullptr, x).solved);
  const CgResult zero = cg.solve(negative, negative, {0.0, 0.0, 0.0}, {}, nullptr, x);
  EXPECT_TRUE(zero.solved);
  EXPECT_EQ(x, std::vector<double>(3, 0.0));
}

TEST(TwoLevel, ClustersAreConnectedAndCoverTheMovingCameras) {
  const Layout layout(street(120));
  std::vector<unsigned char> active(120, 1);
  active[7] = 0;
  const SchurPattern pattern(layout, active);
  const auto cluster = cluster_cameras(pattern, 15);
  std::vector<int> sizes(*std::max_element(cluster.begin(), cluster.end()) + 1, 0);
  for (int i = 0; i < 120; ++i) {
    EXPECT_EQ(cluster[i] < 0, active[i] == 0);
    if (cluster[i] >= 0) ++sizes[cluster[i]];
  }
  for (const int size : sizes) {
    EXPECT_GE(size, 1);
    EXPECT_LE(size, 15);
  }
  EXPECT_LE(sizes.size(), 30u);
}

// What project_row adds up over the rows of a cluster, against Zᵀ S Z with dense matrices.
TEST(TwoLevel, ProjectsTheBlocksOfS) {
  Damped problem(street(30), {}, 1e-4);
  const SchurPattern& pattern = problem.system.pattern();
  const int num_clusters = 3;
  std::vector<std::int32_t> cluster;
  for (int i = 0; i < 30; ++i) cluster.push_back((7 * i) % num_clusters);  // not in order
  auto rng = test::make_rng("modes");
  Table<double> modes(30 * kModeSize, 0.0);
  Eigen::MatrixXd Z = Eigen::MatrixXd::Zero(9 * 30, kModes * num_clusters);
  for (int i = 0; i < 30; ++i) {
    for (int row = 0; row < 9; ++row) {
      for (int m = 0; m < kModes; ++m) {
        modes[i * kModeSize + row * kModeRow + m] = Z(9 * i + row, kModes * cluster[i] + m) =
            rng.normal();
      }
    }
  }
  const CoarseProjection projection{pattern.starts.data(), pattern.columns.data(),
                                    problem.system.blocks().data(), modes.data(), cluster.data()};
  Eigen::MatrixXd half = Eigen::MatrixXd::Zero(Z.cols(), Z.cols());
  Table<double> panel(Z.cols() * kModeRow);
  for (int a = 0; a < num_clusters; ++a) {
    std::fill(panel.begin(), panel.end(), 0.0);
    for (int i = 0; i < 30; ++i) {
      if (cluster[i] == a) project_row(projection, i, panel.data());
    }
    for (Eigen::Index row = 0; row < Z.cols(); ++row) {
      for (int m = 0; m < kModes; ++m) half(row, kModes * a + m) = panel[row * kModeRow + m];
    }
  }
  const Eigen::MatrixXd coarse = half + half.transpose();
  const Eigen::MatrixXd expected = Z.transpose() * problem.S * Z;
  EXPECT_LT((coarse - expected).norm(), 1e-13 * expected.norm());
}

// A street is a chain: one-level iterations grow with its length, two-level ones must not.
TEST(TwoLevel, TakesFewerIterationsThanSchurJacobiOnAStreet) {
  Damped problem(street(250), {}, 1e-6);
  const std::vector<double>& b = problem.system.rhs();
  ExplicitProduct product(problem.context(), problem.system.pattern());
  product.prepare(problem.system, problem.damped);
  ConjugateGradients cg(b.size());
  std::vector<double> x(b.size());
  const auto iterations = [&](SchurPreconditioner&& M) {
    M.prepare(problem.system, problem.damped);
    return cg.solve(product, M, b, {1e-6, 0.0, 5000}, nullptr, x).iterations;
  };
  const int one = iterations(BlockJacobi(problem.cameras(), Preconditioner::SCHUR_JACOBI));
  const int two = iterations(TwoLevel(problem.context(), problem.system.pattern()));
  RecordProperty("one_level", one);
  RecordProperty("two_level", two);
  EXPECT_LT(2 * two, one);
}

}  // namespace
}  // namespace raylign::native
