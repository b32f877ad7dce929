// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/reprojection_problem.h"

#include <ceres/sphere_manifold.h>

#include <deque>

#include "raylign/ceres_backend/cost_functions.h"
#include "raylign/ceres_backend/parameter_state.h"
#include "raylign/ceres_backend/pose_manifold.h"
#include "raylign/ceres_backend/robust_loss.h"
#include "raylign/parametrization/constants.h"

namespace raylign::ceres_backend {
namespace {

template <typename Camera, typename Pose>
class ReprojectionProblemOf final : public ReprojectionProblem {
 public:
  ReprojectionProblemOf(const BundleScene& scene,
                        const BundleConfig& config,
                        const BundleOptions& options)
      : scene_(scene),
        options_(options),
        held_(resolve_constants(scene, config)),
        state_(scene, options.point_parametrization, held_),
        loss_(options.loss) {
    check_point_constants(held_, options.point_parametrization);
    ceres_ = std::make_unique<ceres::Problem>(problem_options());
    for (std::int64_t i = 0; i < scene_.num_observations(); ++i) add_residual(i);
    register_blocks();
    apply_camera_constants();
    apply_point_constants();
  }

  void save_state() override { state_.save(); }
  void restore_saved_state() override { state_.restore_saved(); }
  void write_back(BundleScene& scene) const override { state_.write_back(scene); }

 private:
  void add_residual(std::int64_t i) {
    const std::int32_t c = scene_.camera_index[i];
    const std::int32_t p = scene_.point_index[i];
    const Vector2 observed = scene_.observations.row(i).transpose();
    ceres::LossFunction* loss = options_.loss.type == LossType::TRIVIAL ? nullptr : &loss_;
    double* pose = state_.pose(c);
    double* intrinsics = state_.intrinsics(c);
    double* point = state_.point(p);
    switch (state_.point_model(p)) {
      case PointModel::XYZ:
        ceres_->AddResidualBlock(&xyz_costs_.emplace_back(observed), loss, pose, intrinsics, point);
        break;
      case PointModel::HOMOGENEOUS:
        ceres_->AddResidualBlock(
            &homogeneous_costs_.emplace_back(observed, HomogeneousPoint(state_.frame())), loss,
            pose, intrinsics, point);
        break;
      case PointModel::INVERSE_DEPTH:
        if (state_.host(p) == c) {
          ceres_->AddResidualBlock(&host_costs_.emplace_back(observed), loss, intrinsics, point);
        } else {
          ceres_->AddResidualBlock(&inverse_depth_costs_.emplace_back(observed), loss, pose,
                                   intrinsics, point, state_.pose(state_.host(p)));
        }
        break;
    }
  }

  void register_blocks() {
    for (std::int64_t c = 0; c < scene_.num_cameras(); ++c) {
      for (double* block : {state_.pose(c), state_.intrinsics(c)}) {
        if (ceres_->HasParameterBlock(block)) blocks_.push_back(block);
      }
    }
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      if (ceres_->HasParameterBlock(state_.point(p))) point_blocks_.push_back(state_.point(p));
    }
    blocks_.insert(blocks_.end(), point_blocks_.begin(), point_blocks_.end());
  }

  void apply_camera_constants() {
    ceres::Manifold* free_pose = nullptr;  // one object serves every free camera
    for (std::int64_t c = 0; c < scene_.num_cameras(); ++c) {
      if (ceres_->HasParameterBlock(state_.intrinsics(c))) {
        hold_coordinates<Camera::kNumParams>(*ceres_, state_.intrinsics(c), held_.intrinsics[c]);
      }
      double* pose = state_.pose(c);
      if (!ceres_->HasParameterBlock(pose)) continue;
      const PoseMask& mask = held_.poses[c];
      if (mask.all()) {
        ceres_->SetParameterBlockConstant(pose);
      } else if (mask.any()) {
        ceres_->SetManifold(pose, pose_manifold(mask));
      } else if (options_.pose_parametrization != PoseParametrization::ANGLE_AXIS) {
        if (free_pose == nullptr) free_pose = pose_manifold(mask);
        ceres_->SetManifold(pose, free_pose);
      }
    }
  }

  ceres::Manifold* pose_manifold(const PoseMask& mask) const {
    switch (options_.pose_parametrization) {
      case PoseParametrization::SE3:
        return new PoseManifold(TranslationUpdate::COUPLED, mask);
      case PoseParametrization::QUATERNION:
        return new PoseManifold(TranslationUpdate::ADDITIVE, mask);
      case PoseParametrization::ANGLE_AXIS:
        break;
    }
    std::vector<int> held = mask.rotation ? std::vector<int>{0, 1, 2} : std::vector<int>{};
    for (const int k : held_offsets(mask.translation, 3)) held.push_back(3 + k);
    return new ceres::SubsetManifold(6, held);
  }

  void apply_point_constants() {
    ceres::Manifold* sphere = nullptr;
    for (std::int64_t p = 0; p < scene_.num_points(); ++p) {
      double* block = state_.point(p);
      if (!ceres_->HasParameterBlock(block)) continue;
      if (held_.holds_point(p)) {
        ceres_->SetParameterBlockConstant(block);
      } else if (state_.point_model(p) == PointModel::HOMOGENEOUS) {
        if (sphere == nullptr) sphere = new ceres::SphereManifold<4>();
        ceres_->SetManifold(block, sphere);
      } else if (!held_.points.empty()) {
        hold_coordinates<3>(*ceres_, block, held_.points[p]);
      }
    }
  }

  const BundleScene& scene_;
  const BundleOptions options_;
  const Constants held_;
  ParameterState<Camera, Pose> state_;
  RobustLoss loss_;
  // deques: Ceres keeps the addresses, and cost functions cannot move
  std::deque<ReprojectionCost<Camera, Pose, XyzPoint>> xyz_costs_;
  std::deque<ReprojectionCost<Camera, Pose, HomogeneousPoint>> homogeneous_costs_;
  std::deque<InverseDepthCost<Camera, Pose>> inverse_depth_costs_;
  std::deque<InverseDepthHostCost<Camera>> host_costs_;
};

}  // namespace

std::unique_ptr<ReprojectionProblem> ReprojectionProblem::create(const BundleScene& scene,
                                                                 const BundleConfig& config,
                                                                 const BundleOptions& options) {
  using Made = std::unique_ptr<ReprojectionProblem>;
  return visit_camera(scene.camera_model, [&](auto type) -> Made {
    using Camera = typename decltype(type)::Camera;
    if (options.pose_parametrization == PoseParametrization::ANGLE_AXIS) {
      return std::make_unique<ReprojectionProblemOf<Camera, AngleAxisPose>>(scene, config, options);
    }
    return std::make_unique<ReprojectionProblemOf<Camera, QuaternionPose>>(scene, config, options);
  });
}

}  // namespace raylign::ceres_backend
