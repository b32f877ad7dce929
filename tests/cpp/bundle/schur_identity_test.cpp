// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// The reduced system and the whole step of tiny problems against two oracles in long double:
// elimination in the normal equations, and QR without them.
#include <gtest/gtest.h>

#include <Eigen/Dense>

#include "bundle/reference.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/bundle/native/schur_product.h"
#include "raylign/parametrization/constants.h"
#include "support/eigen_matchers.h"
#include "support/small_problem.h"

namespace raylign::native {
namespace {

using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

struct Setting {
  const char* name;
  PoseParametrization pose;
  PointParametrization point;
  bool twice = false;  // some observations stand in the problem twice
};

BalProblem tiny_problem(bool twice) {
  BalProblem problem = test::small_problem(3, 8);
  if (!twice) return problem;
  const Eigen::Index n = problem.camera_index.size();
  problem.camera_index.conservativeResize(n + 3);
  problem.point_index.conservativeResize(n + 3);
  problem.observations.conservativeResize(n + 3, 2);
  for (int k = 0; k < 3; ++k) {  // the third with another pixel
    problem.camera_index[n + k] = problem.camera_index[5 * k + 1];
    problem.point_index[n + k] = problem.point_index[5 * k + 1];
    problem.observations.row(n + k) = problem.observations.row(5 * k + 1);
  }
  problem.observations(n + 2, 0) += 3.0;
  return problem;
}

class SchurIdentity : public testing::TestWithParam<Setting> {
 protected:
  const BundleOptions options_ = options_of(GetParam());
  const BalProblem problem_ = tiny_problem(GetParam().twice);
  const test::DenseSystem dense_{problem_, {}, options_};
  ReprojectionProblem native_{problem_, resolve_constants(problem_, {}), options_};
  const Eigen::Index n_ = native_.cameras().num_columns();
  const Eigen::Index m_ = dense_.J.cols() - n_;

  static BundleOptions options_of(const Setting& setting) {
    BundleOptions options;
    options.pose_parametrization = setting.pose;
    options.point_parametrization = setting.point;
    options.linear_solver.type = LinearSolverType::DENSE_SCHUR;
    options.parity = true;
    return options;
  }

  // [S | b] by elimination in H = JᵀJ + λD.
  LongMatrix eliminated(double lambda) const {
    const LongMatrix J = dense_.J.cast<long double>();
    const LongVector g = J.transpose() * dense_.r.cast<long double>();
    LongMatrix H = J.transpose() * J;
    H.diagonal() += dense_.damping(lambda, options_.lm).cast<long double>();
    const Eigen::LLT<LongMatrix> H_ll(H.bottomRightCorner(m_, m_));
    LongMatrix out(n_, n_ + 1);
    out << H.topLeftCorner(n_, n_) -
               H.topRightCorner(n_, m_) * H_ll.solve(LongMatrix(H.bottomLeftCorner(m_, n_))),
        H.topRightCorner(n_, m_) * H_ll.solve(LongVector(g.tail(m_))) - g.head(n_);
    return out;
  }

  // The same without normal equations: rows [F r; 0 0] of all observations and of the points'
  // damping, turned by the Qᵀ that makes [E; √(λD)] upper triangular; what lies below its rows.
  LongMatrix projected(double lambda) const {
    const LongVector D = dense_.damping(lambda, options_.lm).cast<long double>();
    const Eigen::Index rows = dense_.J.rows();
    LongMatrix E = LongMatrix::Zero(rows + m_, m_);
    E.topRows(rows) = dense_.J.rightCols(m_).cast<long double>();
    E.bottomRows(m_).diagonal() = D.tail(m_).cwiseSqrt();
    LongMatrix F = LongMatrix::Zero(rows + m_, n_ + 1);
    F.topRows(rows) << dense_.J.leftCols(n_).cast<long double>(), -dense_.r.cast<long double>();
    const Eigen::HouseholderQR<LongMatrix> qr(E);
    const LongMatrix turned = qr.householderQ().transpose() * F;
    const LongMatrix rest = turned.bottomRows(rows);
    LongMatrix out = rest.leftCols(n_).transpose() * rest;
    out.leftCols(n_).diagonal() += D.head(n_);
    return out;
  }

  // Every entry in the units of its row and column: correlations.
  static double distance(const LongMatrix& a, const LongMatrix& b) {
    const LongVector scale = b.diagonal().cwiseSqrt().cwiseInverse();
    LongMatrix e = scale.asDiagonal() * (a - b);
    LongMatrix b_scaled = scale.asDiagonal() * b;
    e.leftCols(b.rows()) = (e.leftCols(b.rows()) * scale.asDiagonal()).eval();
    const long double rhs = b_scaled.rightCols(1).norm();
    return static_cast<double>(
        std::max(e.leftCols(b.rows()).cwiseAbs().maxCoeff(), e.rightCols(1).norm() / rhs));
  }

  // [S | b] of the engine, S by its blocks.
  LongMatrix formed(SchurSystem& system, double lambda) {
    system.form(native_.damped(lambda));
    Eigen::VectorXd b(n_);
    pack(native_.cameras(), system.rhs().data(), b.data());
    LongMatrix out(n_, n_ + 1);
    out << test::dense_schur(system).cast<long double>(), b.cast<long double>();
    return out;
  }

  // S by products with unit vectors.
  Eigen::MatrixXd multiplied(SchurProduct& product) const {
    const CameraBlocks& cameras = native_.cameras();
    std::vector<double> x(cameras.num_cameras() * kRow);
    std::vector<double> y(x.size());
    Eigen::MatrixXd S(n_, n_);
    for (Eigen::Index k = 0; k < n_; ++k) {
      unpack(cameras, Eigen::VectorXd(Eigen::VectorXd::Unit(n_, k)).data(), x.data());
      product.multiply(x.data(), y.data());
      pack(cameras, y.data(), S.col(k).data());
    }
    return S;
  }
};

TEST_P(SchurIdentity, BlocksProductsEliminationAndQrAgree) {
  native_.linearize();
  const SolverContext context{native_.layout(), native_.cameras(), native_.pool()};
  SchurSystem system(context, SchurPattern(context.layout, moving_cameras(context.cameras)));
  ExplicitProduct by_blocks(context, system.pattern());
  MatrixFreeProduct by_landmarks(context);
  for (const double lambda : {1e-8, 1e-4, 1.0}) {
    const LongMatrix expected = eliminated(lambda);
    EXPECT_LT(distance(projected(lambda), expected), 1e-13) << "the oracles, λ = " << lambda;
    LongMatrix ours = formed(system, lambda);
    EXPECT_LT(distance(ours, expected), 1e-11) << "blocks, λ = " << lambda;
    for (SchurProduct* product :
         {static_cast<SchurProduct*>(&by_blocks), static_cast<SchurProduct*>(&by_landmarks)}) {
      product->prepare(system, native_.damped(lambda));
      ours.leftCols(n_) = multiplied(*product).cast<long double>();
      EXPECT_LT(distance(ours, expected), 1e-11) << "products, λ = " << lambda;
    }
  }
}

// The step of every camera and every point.
TEST_P(SchurIdentity, TheWholeStepIsThatOfQr) {
  const bool homogeneous = GetParam().point == PointParametrization::HOMOGENEOUS;
  const HomogeneousFrame frame = homogeneous_frame(BundleScene(problem_));
  for (const double lambda : {1e-4, 1e-2, 1.0}) {
    ReprojectionProblem native(problem_, resolve_constants(problem_, {}), options_);
    native.linearize();
    ASSERT_TRUE(native.solve(lambda).solved);
    native.try_step();
    native.accept();
    BundleScene scene(problem_);
    native.write_back(scene);
    const Eigen::VectorXd step = dense_.step(lambda, options_.lm);
    const Eigen::VectorXd units = dense_.J.colwise().norm().transpose();
    const Eigen::Map<const Eigen::VectorXd> cameras(native.camera_step().data(), n_);
    EXPECT_TRUE(test::is_relatively_near(cameras.cwiseProduct(units.head(n_)),
                                         step.head(n_).cwiseProduct(units.head(n_)), 1e-9));
    for (std::int64_t p = 0; p < problem_.num_points(); ++p) {
      const Vector3 X = problem_.points.row(p).transpose();
      const Vector3 delta = step.segment<3>(n_ + 3 * p);
      const Vector3 expected =
          homogeneous ? Vector3(frame.to_world(SphereTangent(frame.from_world(X)).plus(delta)) - X)
                      : delta;
      EXPECT_TRUE(test::is_relatively_near(scene.points.row(p).transpose() - X, expected, 1e-9))
          << "point " << p << ", λ = " << lambda;
    }
  }
}

INSTANTIATE_TEST_SUITE_P(
    Settings,
    SchurIdentity,
    testing::Values(
        Setting{"se3", PoseParametrization::SE3, PointParametrization::XYZ},
        Setting{"angle_axis", PoseParametrization::ANGLE_AXIS, PointParametrization::XYZ},
        Setting{"homogeneous", PoseParametrization::QUATERNION, PointParametrization::HOMOGENEOUS},
        Setting{"twice", PoseParametrization::SE3, PointParametrization::XYZ, true},
        Setting{"homogeneous_twice", PoseParametrization::SE3, PointParametrization::HOMOGENEOUS,
                true}),
    [](const auto& instance) { return instance.param.name; });

// The model is judged by the step that was taken, not by the one that solves the system.
TEST(ModelDecrease, IsThatOfTheStepThatConjugateGradientsLeft) {
  const BalProblem problem = test::small_problem(8, 60);
  BundleOptions options;
  options.parity = true;
  options.linear_solver.type = LinearSolverType::ITERATIVE_SCHUR;
  options.linear_solver.forcing_tolerance = 0.5;
  const test::DenseSystem dense(problem, {}, options);
  for (const JacobianStorage storage : {JacobianStorage::AUTO, JacobianStorage::DOUBLE}) {
    options.jacobian_storage = storage;
    ReprojectionProblem native(problem, resolve_constants(problem, {}), options);
    native.linearize();
    const double lambda = 1e-4;
    ASSERT_TRUE(native.solve(lambda).solved);
    const LmTrial trial = native.try_step();
    native.accept();
    BundleScene scene(problem);
    native.write_back(scene);
    Eigen::VectorXd step(dense.J.cols());
    const auto& cameras = native.camera_step();
    step << Eigen::Map<const Eigen::VectorXd>(cameras.data(), cameras.size()),
        Eigen::VectorXd(problem.points.size());
    Eigen::Map<Rows<double, 3>>(step.data() + cameras.size(), problem.num_points(), 3) =
        scene.points - problem.points;
    const Eigen::VectorXd J_step = dense.J * step;
    const double decrease = -J_step.dot(dense.r + 0.5 * J_step);
    EXPECT_NEAR(trial.model_decrease, decrease, 1e-9 * decrease);
    EXPECT_NEAR(trial.step_norm, step.norm(), 1e-9 * step.norm());
    const Eigen::VectorXd exact = dense.step(lambda, options.lm);
    EXPECT_GT((J_step - dense.J * exact).norm(), 1e-3 * J_step.norm());
  }
}

}  // namespace
}  // namespace raylign::native
