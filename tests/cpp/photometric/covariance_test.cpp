// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/covariance.h"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/geometry/se3.h"
#include "raylign/parametrization/pose_update.h"
#include "raylign/photometric/cramer_rao.h"
#include "raylign/photometric/sampled_noise.h"
#include "support/patch_scenes.h"

namespace raylign::test {
namespace {

/// Every residual of a scene and its dense Jacobian by central differences: free poses (6 each),
/// brightness, then points. What the covariances are compared with.
class DenseScene {
 public:
  DenseScene(const PatchScene& scene, const PatchConstraints& held) : scene_(scene), held_(held) {
    for (std::int64_t j = 0; j < scene.num_images(); ++j) {
      if (!held.poses[j].all()) poses_.push_back(j);
      for (int k = 0; k < 2; ++k) {
        if (!held.brightness[j][k]) brightness_.push_back({j, k});
      }
    }
    for (std::size_t k = 0; k < held.intrinsics.size() * 4; ++k) {
      if (!held.intrinsics[k / 4][k % 4]) intrinsics_.push_back(static_cast<int>(k));
    }
    d_ = scene.inverse_depth ? 1 : 3;
    J_ = numeric([&](const PatchScene& at) { return residuals(at); });
    const Eigen::MatrixXd J = numeric([&](const PatchScene& at) { return prior_residuals(at); });
    priors_ = J.transpose() * J;
  }

  Eigen::Index num_camera_parameters() const {
    return static_cast<Eigen::Index>(6 * poses_.size() + brightness_.size() + intrinsics_.size());
  }
  Eigen::Index num_parameters() const { return num_camera_parameters() + d_ * scene_.num_points(); }
  const Eigen::MatrixXd& J() const { return J_; }
  /// What the priors add to the normal equations.
  const Eigen::MatrixXd& priors() const { return priors_; }
  Eigen::VectorXd residuals() const { return residuals(scene_); }
  Eigen::VectorXd residuals(const PatchScene& scene) const {
    std::vector<double> all;
    for (std::int64_t p = 0; p < scene.num_points(); ++p) {
      for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
        const EdgeSample sample = evaluate_edge(scene, p, scene.edges[e]);
        for (int n = 0; n < scene.pattern.size(); ++n) all.push_back(sample.residual[n]);
      }
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  /// Covariance of noise that is the same, share s of the variance, in all images of a patch's
  /// pixel; none in the host itself.
  Eigen::MatrixXd noise(double s) const {
    const int n = scene_.pattern.size();
    Eigen::MatrixXd C = Eigen::MatrixXd::Zero(J_.rows(), J_.rows());
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
        for (std::int64_t f = scene_.starts[p]; f < scene_.starts[p + 1]; ++f) {
          if (scene_.edges[e].image == scene_.hosts[p]) continue;
          if (scene_.edges[f].image == scene_.hosts[p]) continue;
          for (int i = 0; i < n; ++i) C(n * e + i, n * f + i) = e == f ? 1.0 : s;
        }
      }
    }
    return C;
  }

  /// Scatter of the points' gradients, what the point can follow taken out, over what `noise` makes
  /// of it, both measured by the information of the cameras.
  double variance(const Eigen::MatrixXd& noise) const {
    const Eigen::Index c = num_camera_parameters();
    const Eigen::VectorXd r = residuals();
    Eigen::MatrixXd S = priors_.topLeftCorner(c, c);
    Eigen::MatrixXd found = Eigen::MatrixXd::Zero(c, c);
    Eigen::MatrixXd expected = found;
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      const Eigen::Index row = scene_.pattern.size() * scene_.starts[p];
      const Eigen::Index rows = scene_.pattern.size() * scene_.starts[p + 1] - row;
      const Eigen::MatrixXd J_c = J_.block(row, 0, rows, c);
      const Eigen::MatrixXd J_p = J_.block(row, c + d_ * p, rows, d_);
      const Eigen::MatrixXd V =
          J_p.transpose() * J_p + priors_.block(c + d_ * p, c + d_ * p, d_, d_);
      const Eigen::MatrixXd follow = V.ldlt().solve(J_p.transpose() * J_c);
      const Eigen::MatrixXd Z = J_c - J_p * follow;
      const Eigen::VectorXd g = Z.transpose() * r.segment(row, rows);
      S += Z.transpose() * J_c;
      found += g * g.transpose();
      expected += Z.transpose() * noise.block(row, row, rows, rows) * Z;
    }
    return S.ldlt().solve(found).trace() / S.ldlt().solve(expected).trace();
  }

  /// What gradients of variance one in each direction, in all images but the hosts, add to JᵀJ.
  Eigen::MatrixXd gradient_noise() const {
    Eigen::MatrixXd sum = Eigen::MatrixXd::Zero(num_parameters(), num_parameters());
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      for (std::int64_t e = scene_.starts[p]; e < scene_.starts[p + 1]; ++e) {
        if (scene_.edges[e].image == scene_.hosts[p]) continue;
        const Eigen::MatrixXd M = projection_jacobian(p, scene_.edges[e]);
        const EdgeBrightness b = edge_brightness(scene_, p, scene_.edges[e]);
        sum += scene_.pattern.size() * std::pow(b.scale * b.gain, 2) * M.transpose() * M;
      }
    }
    return sum;
  }

  /// (6, 6) of the k-th free pose.
  static Matrix6 pose(const Eigen::MatrixXd& C, Eigen::Index k) {
    return C.block<6, 6>(6 * k, 6 * k);
  }
  std::int64_t free_pose(std::size_t k) const { return poses_[k]; }
  std::size_t num_free_poses() const { return poses_.size(); }

  PatchScene moved(PatchScene scene, Eigen::Index k, double step) const {
    const auto at = static_cast<std::size_t>(k);
    if (at < 6 * poses_.size()) {
      Vector6 xi = Vector6::Zero();
      xi[k % 6] = step;
      PatchPose& pose = scene.poses[poses_[at / 6]];
      pose_plus(TranslationUpdate::COUPLED, {}, xi, pose.q, pose.t);
      return scene;
    }
    std::size_t rest = at - 6 * poses_.size();
    if (rest < brightness_.size()) {
      scene.brightness(brightness_[rest].first, brightness_[rest].second) += step;
      return scene;
    }
    rest -= brightness_.size();
    if (rest < intrinsics_.size()) {
      scene.intrinsics(intrinsics_[rest] / 4, intrinsics_[rest] % 4) += step;
      return scene;
    }
    rest -= intrinsics_.size();
    scene.points(static_cast<Eigen::Index>(rest) / d_, static_cast<Eigen::Index>(rest) % d_) +=
        step;
    return scene;
  }

  /// ∂ world point / ∂ parameters, (3, parameters).
  Eigen::MatrixXd world_point_jacobian(std::int64_t p) const {
    Eigen::MatrixXd G(3, num_parameters());
    const double h = 1e-6;
    for (Eigen::Index k = 0; k < G.cols(); ++k) {
      G.col(k) =
          (world_point(moved(scene_, k, h), p) - world_point(moved(scene_, k, -h), p)) / (2.0 * h);
    }
    return G;
  }

 private:
  Eigen::MatrixXd projection_jacobian(std::int64_t p, const PatchEdge& edge) const {
    const double h = 1e-6;
    Eigen::MatrixXd M(2, num_parameters());
    for (Eigen::Index k = 0; k < M.cols(); ++k) {
      M.col(k) = (evaluate_edge(moved(scene_, k, h), p, edge).uv -
                  evaluate_edge(moved(scene_, k, -h), p, edge).uv) /
                 (2.0 * h);
    }
    return M;
  }
  template <typename F>
  Eigen::MatrixXd numeric(const F& f) const {
    const double h = 1e-6;
    Eigen::MatrixXd J(f(scene_).size(), num_parameters());
    for (Eigen::Index k = 0; k < J.cols(); ++k) {
      J.col(k) = (f(moved(scene_, k, h)) - f(moved(scene_, k, -h))) / (2.0 * h);
    }
    return J;
  }
  // Priors as residuals of unit weight.
  Eigen::VectorXd prior_residuals(const PatchScene& scene) const {
    std::vector<double> all;
    const auto add = [&](const auto& information, const auto& difference) {
      const Eigen::VectorXd r = information.llt().matrixU() * difference;
      all.insert(all.end(), r.data(), r.data() + r.size());
    };
    for (const PosePrior& prior : held_.pose_priors) {
      const Matrix4 T = scene.poses[prior.image].matrix() * se3_inverse(prior.T_cw);
      add(prior.information, se3_log(T));
    }
    for (const PatchPointPrior& prior : held_.point_priors) {
      const Vector3 x = scene.points.row(prior.point).transpose() - prior.value;
      add(prior.information.topLeftCorner(d_, d_).eval(), x.head(d_).eval());
    }
    for (const auto& [image, k] : brightness_) {
      const double weight = k == 0 ? held_.weight_a : held_.weight_b;
      all.push_back(std::sqrt(weight) * scene.brightness(image, k));
    }
    return Eigen::Map<Eigen::VectorXd>(all.data(), static_cast<Eigen::Index>(all.size()));
  }

  const PatchScene& scene_;
  const PatchConstraints held_;
  std::vector<std::int64_t> poses_;
  std::vector<std::pair<std::int64_t, int>> brightness_;
  std::vector<int> intrinsics_;
  Eigen::Index d_ = 3;
  Eigen::MatrixXd J_, priors_;
};

Eigen::MatrixXd inverse_of(const Eigen::MatrixXd& H) {
  return H.ldlt().solve(Eigen::MatrixXd::Identity(H.rows(), H.cols()));
}

Eigen::MatrixXd sandwich(const Eigen::MatrixXd& H, const Eigen::MatrixXd& B) {
  return inverse_of(H) * B * inverse_of(H);
}

template <typename A, typename B>
double relative_difference(const A& a, const B& b) {
  return (a - b).norm() / b.norm();
}

Matrix3 matrix3(const Rows<double, 9>& table, std::int64_t row) {
  return Eigen::Map<const RowMajor<3, 3>>(table.row(row).data());
}

struct Case {
  const char* name;
  bool hosted, inverse_depth, brightness, intrinsics;
  double share;
  double noise_ratio = 0.0;
  bool priors = false;
};

// Priors of about the weight that the images have.
void add_priors(const PatchScene& scene, PatchConstraints& held) {
  Vector6 xi;
  xi << 0.004, -0.002, 0.003, 0.001, -0.002, 0.001;
  Matrix6 information = Matrix6::Identity() * 3e6;
  information(1, 3) = information(3, 1) = 8e5;
  held.pose_priors.push_back({1, se3_exp(xi) * scene.poses[1].matrix(), information});
  Matrix3 of_point = Matrix3::Identity() * 4e5;
  of_point(0, 2) = of_point(2, 0) = 1e5;
  held.point_priors.push_back(
      {5, scene.points.row(5).transpose() + Vector3(2e-3, 0.0, 0.0), of_point});
  held.weight_a = 1e5;
  held.weight_b = 3.0;
}

class CovarianceTest : public testing::TestWithParam<Case> {
 protected:
  PatchSceneOptions scene_options() const {
    PatchSceneOptions options;
    options.num_images = 4;
    options.num_points = 12;
    options.hosted = GetParam().hosted;
    options.inverse_depth = GetParam().inverse_depth;
    options.brightness = GetParam().brightness;
    options.noise_ratio = GetParam().noise_ratio;
    options.sigma = 0.5;  // nowhere is half of what gradients say their noise
    return options;
  }
};
INSTANTIATE_TEST_SUITE_P(All,
                         CovarianceTest,
                         testing::Values(Case{"stored", false, false, false, false, 0.0},
                                         Case{"stored_shared", false, false, true, false, 0.4},
                                         Case{"xyz", true, false, true, true, 0.5},
                                         Case{"noise_of_both", true, false, true, false, 0.5, 0.8},
                                         Case{"priors", true, false, true, false, 0.5, 0.0, true},
                                         Case{"inverse_depth_priors", true, true, true, false, 0.5,
                                              0.0, true},
                                         Case{"inverse_depth", true, true, true, false, 0.5},
                                         Case{"intrinsics", true, true, false, true, 0.3}),
                         [](const auto& test) { return test.param.name; });

TEST_P(CovarianceTest, IsTheInverseOfAllUnknownsAtOnce) {
  const PatchScene scene = patch_case(scene_options()).truth;
  PatchConstraints held = patch_constraints(scene, GetParam().brightness, GetParam().intrinsics);
  if (GetParam().priors) add_priors(scene, held);
  PatchSolveOptions options;  // TRIVIAL
  CovarianceOptions wanted;
  wanted.points = true;
  wanted.shared_noise = GetParam().share;
  wanted.prior_unit = 3.0;
  const PhotometricCovariance covariance = photometric_covariance(scene, held, options, wanted);
  EXPECT_EQ(covariance.free_directions, 0);

  const DenseScene dense(scene, held);
  const Eigen::MatrixXd noise = dense.noise(GetParam().share);
  const double v = dense.variance(noise);
  EXPECT_NEAR(covariance.variance / v, 1.0, 1e-5);
  const double of_gradients =
      (1.0 - GetParam().share) * v * SampledNoise(scene.interpolation).mean_gradient();
  const Eigen::MatrixXd H =
      dense.J().transpose() * dense.J() + dense.priors() - of_gradients * dense.gradient_noise();
  const Eigen::MatrixXd B =
      v * dense.J().transpose() * noise * dense.J() + wanted.prior_unit * dense.priors();
  const Eigen::MatrixXd C = sandwich(H, B);
  for (std::size_t k = 0; k < dense.num_free_poses(); ++k) {
    const auto j = static_cast<Eigen::Index>(dense.free_pose(k));
    EXPECT_LT(relative_difference(covariance.poses.block(6 * j, 6 * j, 6, 6),
                                  DenseScene::pose(C, static_cast<Eigen::Index>(k))),
              1e-5);
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const Eigen::MatrixXd G = dense.world_point_jacobian(p);
    const Matrix3 expected = G * C * G.transpose();
    EXPECT_LT(relative_difference(matrix3(covariance.points, p), expected), 1e-5) << p;
  }
}

// A camera that no edge belongs to is known as its prior says, whatever the residuals are.
TEST(PhotometricCovariance, OfAPriorAloneIsThePrior) {
  PatchSceneOptions scene_options;
  scene_options.num_points = 20;
  scene_options.hosted = false;
  scene_options.sigma = 2.0;
  PatchScene scene = patch_case(scene_options).truth;
  constexpr std::int32_t kBlind = 2;
  PatchScene rest = scene;
  rest.edges.clear();
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      if (scene.edges[e].image != kBlind) rest.edges.push_back(scene.edges[e]);
    }
    rest.starts[p + 1] = rest.num_edges();
  }
  PatchConstraints held = patch_constraints(scene);
  Matrix6 C = Matrix6::Identity() * 1e-4;
  C(0, 5) = C(5, 0) = 4e-5;
  const double unit = 7.0;
  held.pose_priors.push_back({kBlind, scene.poses[kBlind].matrix(), unit * C.inverse()});
  CovarianceOptions options;
  options.prior_unit = unit;
  const PhotometricCovariance covariance = photometric_covariance(rest, held, {}, options);
  EXPECT_EQ(covariance.free_directions, 0);
  EXPECT_LT(relative_difference(Matrix6(covariance.poses.block<6, 6>(6 * kBlind, 6 * kBlind)), C),
            1e-9);
}

TEST(PhotometricCovariance, SmoothedImagesHaveLessGradientNoise) {
  PatchSceneOptions scene_options;
  scene_options.num_points = 20;
  scene_options.sigma = 2.0;
  const PatchScene scene = patch_case(scene_options).truth;
  const PatchConstraints held = patch_constraints(scene);
  CovarianceOptions sharp, smooth;
  smooth.presmooth = 0.7;
  const PhotometricCovariance a = photometric_covariance(scene, held, {}, sharp);
  const PhotometricCovariance b = photometric_covariance(scene, held, {}, smooth);
  EXPECT_LT(b.poses.trace(), 0.99 * a.poses.trace());
  EXPECT_EQ(a.variance, b.variance);
  EXPECT_LT(SampledNoise(scene.interpolation, 0.7).mean_gradient(),
            0.1 * SampledNoise(scene.interpolation).mean_gradient());
  smooth.presmooth = -1.0;
  EXPECT_THROW(photometric_covariance(scene, held, {}, smooth), OptionsError);
}

TEST(CramerRao, IsTheInverseInformation) {
  PatchSceneOptions scene_options;
  scene_options.num_images = 4;
  scene_options.num_points = 12;
  scene_options.hosted = false;
  const PatchScene scene = patch_case(scene_options).truth;
  const PatchConstraints held = patch_constraints(scene);
  CramerRaoOptions options;
  options.sigma = 3.0;
  options.is_rounded = true;
  const CramerRaoBound bound = cramer_rao(scene, held, options);
  const DenseScene dense(scene, held);
  const Eigen::MatrixXd C = (9.0 + 1.0 / 12.0) * inverse_of(dense.J().transpose() * dense.J());
  for (std::size_t k = 0; k < dense.num_free_poses(); ++k) {
    const auto j = static_cast<Eigen::Index>(dense.free_pose(k));
    const Matrix6 expected = DenseScene::pose(C, static_cast<Eigen::Index>(k));
    EXPECT_LT(relative_difference(bound.poses.block(6 * j, 6 * j, 6, 6), expected), 1e-5);
    const Matrix3 R_wc = scene.poses[j].q.toRotationMatrix().transpose();
    const Matrix3 center = R_wc * expected.topLeftCorner<3, 3>() * R_wc.transpose();
    EXPECT_LT(relative_difference(matrix3(bound.centers, j), center), 1e-5);
  }
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    const Eigen::MatrixXd G = dense.world_point_jacobian(p);
    EXPECT_LT(relative_difference(matrix3(bound.points, p), Matrix3(G * C * G.transpose())), 1e-5);
  }
}

TEST(CramerRao, NoisyPatchesAreUnknownGreyValues) {
  PatchSceneOptions options;
  options.num_images = 4;
  options.num_points = 8;
  options.inverse_depth = true;
  options.brightness = true;
  const PatchScene scene = patch_case(options).truth;
  const PatchConstraints held = patch_constraints(scene, true);
  const DenseScene dense(scene, held);
  // One more unknown per pixel of each patch, c: the host says c + noise, image v says
  // (c − r) / gain + noise.
  const int n = scene.pattern.size();
  const Eigen::Index unknown = dense.num_parameters();
  const Eigen::Index num_grey = n * scene.num_points();
  Eigen::MatrixXd J = Eigen::MatrixXd::Zero(dense.J().rows() + num_grey, unknown + num_grey);
  J.bottomRightCorner(num_grey, num_grey).setIdentity();
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      const double gain = edge_brightness(scene, p, scene.edges[e]).gain;
      for (int i = 0; i < n; ++i) {
        J.row(n * e + i).head(unknown) = dense.J().row(n * e + i) / gain;
        J(n * e + i, unknown + n * p + i) = 1.0 / gain;
      }
    }
  }
  const Eigen::MatrixXd C = 4.0 * inverse_of(J.transpose() * J);
  CramerRaoOptions bound_options;
  bound_options.sigma = 2.0;
  bound_options.has_noisy_patches = true;
  const CramerRaoBound bound = cramer_rao(scene, held, bound_options);
  for (std::size_t k = 0; k < dense.num_free_poses(); ++k) {
    const auto j = static_cast<Eigen::Index>(dense.free_pose(k));
    EXPECT_LT(relative_difference(bound.poses.block(6 * j, 6 * j, 6, 6),
                                  DenseScene::pose(C, static_cast<Eigen::Index>(k))),
              1e-5);
  }
  // The same from world points: they stand on their hosts' rays.
  PatchSceneOptions xyz_options = options;
  xyz_options.inverse_depth = false;
  const CramerRaoBound same = cramer_rao(patch_case(xyz_options).truth, held, bound_options);
  EXPECT_LT(relative_difference(same.poses, bound.poses), 1e-6);
  EXPECT_LT(relative_difference(same.points, bound.points), 1e-6);
  // Noise of the patches costs.
  bound_options.has_noisy_patches = false;
  EXPECT_LT(cramer_rao(scene, held, bound_options).poses.trace(), 0.8 * bound.poses.trace());
}

TEST(CramerRao, SaysWhatIsFreeAndRefusesBadOptions) {
  PatchSceneOptions scene_options;
  scene_options.num_points = 20;
  scene_options.hosted = false;
  const PatchScene scene = patch_case(scene_options).truth;
  PatchConstraints held = patch_constraints(scene);
  EXPECT_EQ(cramer_rao(scene, held, {}).free_directions, 0);
  held.poses.assign(held.poses.size(), PoseMask{});
  EXPECT_EQ(cramer_rao(scene, held, {}).free_directions, 7);
  EXPECT_EQ(photometric_covariance(scene, held, {}).free_directions, 7);
  EXPECT_THROW(cramer_rao(scene, held, {-1.0}), OptionsError);
  EXPECT_THROW(cramer_rao(scene, held, {1.0, false, true}), OptionsError);  // no hosts
  EXPECT_THROW(photometric_covariance(scene, held, {}, {false, 1.5}), OptionsError);
}

}  // namespace
}  // namespace raylign::test
