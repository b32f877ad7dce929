// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/native/patch_problem.h"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <functional>
#include <string>

#include "raylign/photometric/native/solve.h"
#include "support/patch_scenes.h"

namespace raylign::native {
namespace {

using test::PatchSceneOptions;

struct Case {
  std::string name;
  PatchSceneOptions scene;
  Loss loss = {LossType::STUDENT_T, 3.0, 5.0};
  LossScope scope = LossScope::PIXEL;
  bool intrinsics = false;
  bool identity_warps = false;
};

PatchSceneOptions scene_with(const std::function<void(PatchSceneOptions&)>& change) {
  PatchSceneOptions options;
  options.brightness = true;
  options.sigma = 1.0;
  change(options);
  return options;
}

std::vector<Case> cases() {
  const auto plain = scene_with([](auto&) {});
  const auto inverse = scene_with([](auto& o) { o.inverse_depth = true; });
  const auto stored = scene_with([](auto& o) { o.hosted = false; });
  const auto bilinear =
      scene_with([](auto& o) { o.interpolation = SampleInterpolation::BILINEAR; });
  const auto spread = scene_with([](auto& o) { o.pattern = PatchPattern::spread8(); });
  const auto large = scene_with([](auto& o) { o.pattern = PatchPattern::square(5); });
  const auto small = scene_with([](auto& o) {
    o.pattern = PatchPattern::square(3);
    o.interpolation = SampleInterpolation::BILINEAR;
  });
  const auto coarse = scene_with([](auto& o) {
    o.level = 1;
    o.width = 320;
    o.height = 240;
  });
  const auto exercise = scene_with([](auto& o) {
    o.hosted = false;
    o.border = PatchBorder::WRAP;
    o.interpolation = SampleInterpolation::CENTRAL_DIFFERENCE;
  });
  const auto each = scene_with([](auto& o) { o.intrinsics_per_image = true; });
  const auto both = scene_with([](auto& o) {
    o.noise_ratio = 0.76;
    o.sigma = 2.0;
  });
  const auto both_inverse = scene_with([](auto& o) {
    o.noise_ratio = 0.76;
    o.inverse_depth = true;
  });
  const auto both_stored = scene_with([](auto& o) {
    o.noise_ratio = 1.5;
    o.hosted = false;
  });
  return {
      {"StudentT", plain},
      {"Square", plain, {LossType::STUDENT_T, 3.0, 5.0}, LossScope::PIXEL, false, true},
      {"SquareBilinear", bilinear, {LossType::HUBER, 2.0, 5.0}, LossScope::PIXEL, false, true},
      {"SquareInverseDepth", inverse, {LossType::HUBER, 2.0, 5.0}, LossScope::PIXEL, false, true},
      {"InverseDepth", inverse},
      {"InverseDepthIntrinsics", inverse, {LossType::STUDENT_T, 3.0, 5.0}, LossScope::PIXEL, true},
      {"Exercise", exercise, {LossType::HUBER, 1.0, 5.0}, LossScope::PATCH, false, true},
      {"Stored", stored, {LossType::CAUCHY, 4.0, 5.0}},
      {"Huber", plain, {LossType::HUBER, 2.0, 5.0}},
      {"LeastSquares", bilinear, {LossType::TRIVIAL, 1.0, 5.0}},
      {"PatchHuber", stored, {LossType::HUBER, 5.0, 5.0}, LossScope::PATCH},
      {"PatchT", plain, {LossType::STUDENT_T, 5.0, 4.0}, LossScope::PATCH},
      {"Spread8", spread},
      {"Square5", large},
      {"Square3", small},
      {"Level1", coarse},
      {"NoiseOfBoth", both},
      {"NoiseOfBothInverseDepth", both_inverse, {LossType::HUBER, 2.0, 5.0}},
      {"NoiseOfBothStored", both_stored, {LossType::HUBER, 5.0, 5.0}, LossScope::PATCH},
      {"SharedIntrinsics", plain, {LossType::STUDENT_T, 3.0, 5.0}, LossScope::PIXEL, true},
      {"IntrinsicsPerImage", each, {LossType::STUDENT_T, 3.0, 5.0}, LossScope::PIXEL, true}};
}

// The normal equations with 16-row Jacobians, pixel by pixel: columns (M × 8), intrinsics, points.
class DenseReference {
 public:
  DenseReference(const PatchScene& scene, const Case& c) : scene_(scene) {
    first_point_ = 8 * scene.num_images() + 4 * scene.intrinsics.rows();
    const auto n = first_point_ + 3 * scene.num_points();
    H.setZero(n, n);
    g.setZero(n);
    for (std::int64_t p = 0; p < scene.num_points(); ++p) {
      for (auto e = scene.starts[p]; e < scene.starts[p + 1]; ++e) add(p, scene.edges[e], c);
    }
  }

  Eigen::MatrixXd H;
  Eigen::VectorXd g;
  double cost = 0.0;

  std::int64_t point_column(std::int64_t p) const { return first_point_ + 3 * p; }

 private:
  void add(std::int64_t p, const PatchEdge& edge, const Case& c) {
    const EdgeSample sample = evaluate_edge(scene_, p, edge);
    ASSERT_TRUE(sample.is_seen);
    const EdgeMotion motion = edge_motion(scene_, p, edge, sample);
    double squared = 0.0;
    for (int n = 0; n < scene_.pattern.size(); ++n) squared += std::pow(sample.residual[n], 2);
    const LossValue whole = c.loss.evaluate(squared);
    if (c.scope == LossScope::PATCH) cost += 0.5 * whole.rho;
    for (int n = 0; n < scene_.pattern.size(); ++n) {
      if (!sample.counts(edge, n)) continue;
      const double r = sample.residual[n];
      const LossValue own = c.loss.evaluate(r * r);
      if (c.scope == LossScope::PIXEL) cost += 0.5 * own.rho;
      const Eigen::VectorXd J = row(p, edge, sample, motion, n);
      const double w = c.scope == LossScope::PIXEL ? own.d_rho : whole.d_rho;
      H += w * J * J.transpose();
      g += w * r * J;
    }
  }

  Eigen::VectorXd row(std::int64_t p,
                      const PatchEdge& edge,
                      const EdgeSample& sample,
                      const EdgeMotion& motion,
                      int n) const {
    Eigen::VectorXd J = Eigen::VectorXd::Zero(H.rows());
    const Eigen::RowVector2d gradient(sample.gradient[n][0], sample.gradient[n][1]);
    const auto by_brightness = sample.by_brightness(n);
    const std::int64_t image = 8 * edge.image;
    J.segment<6>(image) -= (gradient * motion.pose).transpose();
    J[image + 6] += by_brightness[0];
    J[image + 7] += by_brightness[1];
    J.segment<4>(8 * scene_.num_images() + 4 * scene_.intrinsics_row(edge.image)) -=
        (gradient * motion.intrinsics).transpose();
    J.segment<3>(point_column(p)) -= (gradient * motion.point).transpose();
    if (scene_.hosts[p] < 0) return J;
    const std::int64_t host = 8 * scene_.hosts[p];
    J.segment<6>(host) -= (gradient * motion.host_pose).transpose();
    J.segment<4>(8 * scene_.num_images() + 4 * scene_.intrinsics_row(scene_.hosts[p])) -=
        (gradient * motion.host_intrinsics).transpose();
    const auto by_host = sample.by_host_brightness(n);
    J[host + 6] += by_host[0];
    J[host + 7] += by_host[1];
    return J;
  }

  const PatchScene& scene_;
  std::int64_t first_point_;
};

// How the free numbers move the reference's columns.
struct FreeBasis {
  FreeBasis(const PatchScene& scene, const PatchConstraints& held, const DenseReference& reference)
      : size(scene.inverse_depth ? 1 : 3), columns(scene, held), held_points(held.points) {
    B.setZero(reference.H.rows(), columns.num_columns() + size * (scene.num_points() - 1));
    for (std::int64_t i = 0; i < scene.num_images(); ++i) {
      for (std::size_t k = 0; k < columns.columns(i).size(); ++k) {
        const Eigen::VectorXd full = columns.basis(i).col(static_cast<Eigen::Index>(k));
        auto column = B.col(columns.columns(i)[k]);
        column.segment<8>(8 * i) = full.head<8>();
        if (full.size() == 8) continue;
        column.segment<4>(8 * scene.num_images() + 4 * scene.intrinsics_row(i)) = full.tail<4>();
      }
    }
    for (std::int64_t p = 0; p < scene.num_points(); ++p) {
      if (held.points[p]) continue;
      for (int k = 0; k < size; ++k) {
        B(reference.point_column(p) + k, column_of_point(p) + k) = 1.0;
      }
    }
  }

  Eigen::Index column_of_point(std::int64_t p) const {
    const auto before = std::count(held_points.begin(), held_points.begin() + p, false);
    return columns.num_columns() + size * before;
  }

  int size;
  ImageColumns columns;
  std::vector<bool> held_points;
  Eigen::MatrixXd B;
};

class PatchProblemTest : public testing::TestWithParam<Case> {
 protected:
  PatchScene start() const {
    PatchScene scene = test::patch_case(GetParam().scene).start;
    if (GetParam().identity_warps) {
      for (PatchEdge& edge : scene.edges) edge.A = {1.0f, 0.0f, 0.0f, 1.0f};
    }
    scene.edges[3].mask = 0xa5a5a5u;  // some pixels do not count
    return scene;
  }
  PatchConstraints constraints(const PatchScene& scene) const {
    PatchConstraints held = test::patch_constraints(scene, true, GetParam().intrinsics);
    held.poses[1].translation[0] = true;
    held.points.assign(static_cast<std::size_t>(scene.num_points()), false);
    held.points[2] = true;
    return held;
  }
  PatchSolveOptions options() const {
    PatchSolveOptions out;
    out.loss = GetParam().loss;
    out.scope = GetParam().scope;
    return out;
  }
};

TEST_P(PatchProblemTest, CostIsThatOfTheDefinition) {
  const PatchScene scene = start();
  PatchProblem problem(scene, constraints(scene), options());
  const DenseReference reference(scene, GetParam());
  EXPECT_NEAR(problem.linearize().cost, reference.cost, 2e-6 * reference.cost);
}

// The damped step of the whole system in one piece is the step with the points eliminated.
TEST_P(PatchProblemTest, StepIsThatOfTheDenseSystem) {
  constexpr double kLambda = 1e-3;
  const PatchScene scene = start();
  const PatchConstraints held = constraints(scene);
  PatchProblem problem(scene, held, options());
  problem.linearize();
  ASSERT_TRUE(problem.solve(kLambda).solved);
  const LmTrial trial = problem.try_step();
  problem.accept();
  PatchScene after = scene;
  problem.write_back(after);

  const DenseReference reference(scene, GetParam());
  const FreeBasis basis(scene, held, reference);
  const Eigen::MatrixXd& B = basis.B;
  const int size = basis.size;
  Eigen::MatrixXd H = B.transpose() * reference.H * B;
  const Eigen::VectorXd g = B.transpose() * reference.g;
  const Eigen::MatrixXd undamped = H;
  for (Eigen::Index k = 0; k < H.rows(); ++k) {
    const double h = H(k, k);
    H(k, k) += kLambda * lm_damping(h, lm_column_scale(h, options().lm), options().lm);
  }
  const Eigen::VectorXd free = H.ldlt().solve(-g);
  const Eigen::VectorXd step = B * free;
  const double model = -g.dot(free) - 0.5 * free.dot(undamped * free);
  EXPECT_NEAR(trial.model_decrease, model, 1e-4 * model);
  EXPECT_NEAR(trial.step_norm, free.norm(), 1e-4 * free.norm());

  PatchScene expected = scene;
  for (std::int64_t i = 0; i < scene.num_images(); ++i) {
    pose_plus(TranslationUpdate::COUPLED, held.poses[i], step.segment<6>(8 * i),
              expected.poses[i].q, expected.poses[i].t);
    EXPECT_LT((after.poses[i].t - expected.poses[i].t).norm(), 1e-4 * step.norm()) << i;
    EXPECT_LT(after.poses[i].q.angularDistance(expected.poses[i].q), 1e-4 * step.norm()) << i;
    EXPECT_NEAR(after.brightness(i, 0) - scene.brightness(i, 0), step[8 * i + 6], 1e-5);
    EXPECT_NEAR(after.brightness(i, 1) - scene.brightness(i, 1), step[8 * i + 7], 1e-3);
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (int k = 0; k < size; ++k) {
      EXPECT_NEAR(after.points(p, k) - scene.points(p, k), step[reference.point_column(p) + k],
                  1e-4 * step.norm());
    }
  }
  if (!GetParam().intrinsics) return;
  for (Eigen::Index r = 0; r < scene.intrinsics.rows(); ++r) {
    const Eigen::RowVector4d d = after.intrinsics.row(r) - scene.intrinsics.row(r);
    const Eigen::VectorXd of = step.segment<4>(8 * scene.num_images() + 4 * r);
    EXPECT_LT((d.transpose() - of).norm(), 1e-3 * of.norm());
  }
}

TEST_P(PatchProblemTest, ReturnsToTheTruth) {
  PatchSceneOptions clean = GetParam().scene;
  clean.sigma = 0.0;
  test::PatchCase both = test::patch_case(clean);
  PatchSolveOptions solve = options();
  solve.lm.max_num_iterations = 100;
  const PatchConstraints held = test::patch_constraints(both.truth, true, GetParam().intrinsics);
  const Summary summary = solve_patches(both.start, held, solve);
  EXPECT_TRUE(summary.is_usable());
  for (std::int64_t i = 0; i < both.truth.num_images(); ++i) {
    const double before = (test::patch_case(clean).start.poses[i].t - both.truth.poses[i].t).norm();
    EXPECT_LT((both.start.poses[i].t - both.truth.poses[i].t).norm(), 0.15 * before + 1e-12) << i;
  }
}

TEST_P(PatchProblemTest, HeldNumbersKeepTheirBits) {
  const PatchScene before = start();
  PatchScene scene = before;
  const Summary summary = solve_patches(scene, constraints(scene), options());
  EXPECT_GT(summary.num_accepted, 0);
  const auto last = scene.poses.size() - 1;
  for (const std::size_t i : {std::size_t{0}, last}) {
    EXPECT_EQ(scene.poses[i].t, before.poses[i].t);
    EXPECT_EQ(scene.poses[i].q.coeffs(), before.poses[i].q.coeffs());
  }
  EXPECT_EQ(scene.poses[1].t[0], before.poses[1].t[0]);
  EXPECT_EQ(scene.points.row(2), before.points.row(2));
  EXPECT_EQ(scene.brightness.row(0), before.brightness.row(0));
  if (GetParam().intrinsics) return;
  EXPECT_EQ(scene.intrinsics, before.intrinsics);
}

INSTANTIATE_TEST_SUITE_P(Laws, PatchProblemTest, testing::ValuesIn(cases()), [](const auto& test) {
  return test.param.name;
});

TEST(PatchProblem, SameBitsOnAnyNumberOfThreads) {
  PatchSceneOptions scene;
  scene.num_points = 1100;  // several parts
  scene.brightness = true;
  scene.sigma = 2.0;
  const PatchScene start = test::patch_case(scene).start;
  PatchSolveOptions options;
  options.loss = {LossType::STUDENT_T, 2.0, 5.0};
  PatchScene first;
  for (const int threads : {1, 2, 4}) {
    PatchScene moved = start;
    options.lm.num_threads = threads;
    solve_patches(moved, test::patch_constraints(start, true), options);
    if (threads == 1) first = moved;
    EXPECT_EQ(moved.points, first.points);
    EXPECT_EQ(moved.poses[2].t, first.poses[2].t);
    EXPECT_EQ(moved.brightness, first.brightness);
  }
}

}  // namespace
}  // namespace raylign::native
