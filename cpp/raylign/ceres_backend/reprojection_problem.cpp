// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/reprojection_problem.h"

#include <ceres/sphere_manifold.h>

#include <cmath>
#include <cstring>
#include <deque>

#include "raylign/base/error.h"
#include "raylign/ceres_backend/constants.h"
#include "raylign/ceres_backend/cost_functions.h"
#include "raylign/ceres_backend/robust_loss.h"

namespace raylign::ceres_backend {
namespace {

ceres::Problem::Options problem_options() {
  ceres::Problem::Options options;
  options.cost_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;  // they sit in deques here
  options.loss_function_ownership = ceres::DO_NOT_TAKE_OWNERSHIP;
  options.manifold_ownership = ceres::TAKE_OWNERSHIP;  // Ceres frees a shared manifold once
  options.disable_all_safety_checks = true;  // the arrays are validated, the blocks are ours
  return options;
}

std::vector<int> held_offsets(const CoordinateMask& mask) {
  std::vector<int> offsets;
  for (int k = 0; k < 3; ++k) {
    if (mask[k]) offsets.push_back(k);
  }
  return offsets;
}

bool all_held(const CoordinateMask& mask) { return mask[0] && mask[1] && mask[2]; }
bool none_held(const CoordinateMask& mask) { return !(mask[0] || mask[1] || mask[2]); }

template <typename Pose>
class Builder final : public ReprojectionProblem {
 public:
  Builder(const BalProblem& problem, const BundleConfig& config, const BundleOptions& options)
      : source_(problem),
        options_(options),
        held_(resolve_constants(problem, config)),
        loss_(options.loss) {
    ceres_ = std::make_unique<ceres::Problem>(problem_options());
    check_point_constants();
    find_hosts();
    load_cameras();
    load_points();
    add_residuals();
    register_blocks();
    apply_camera_constants();
    apply_point_constants();
  }

  void write_back(BalProblem& problem) const override {
    for (std::int64_t c = 0; c < problem.num_cameras(); ++c) {
      write_back_pose(c, problem);
      // Unchanged numbers are copied onto themselves: the block holds the file's own numbers.
      problem.cameras.row(c).tail<3>() = Eigen::Map<const Vector3>(intrinsics_block(c)).transpose();
    }
    for (std::int64_t p = 0; p < problem.num_points(); ++p) {
      const double* first = &initial_points_[p * point_size_];
      const double* now = &points_[p * point_size_];
      if (std::memcmp(first, now, point_size_ * sizeof(double)) == 0 && !host_moved(p)) continue;
      problem.points.row(p) = world_point(p).transpose();
    }
  }

 private:
  enum class PointModel { XYZ, HOMOGENEOUS, INVERSE_DEPTH };

  const double* pose_block(std::int64_t c) const { return &poses_[c * Pose::kSize]; }
  double* pose_block(std::int64_t c) { return &poses_[c * Pose::kSize]; }
  const double* intrinsics_block(std::int64_t c) const { return &intrinsics_[c * 3]; }
  double* intrinsics_block(std::int64_t c) { return &intrinsics_[c * 3]; }
  double* point_block(std::int64_t p) { return &points_[p * point_size_]; }

  bool is_constant_point(std::int64_t p) const {
    return !held_.points.empty() && all_held(held_.points[p]);
  }

  // A held point stays what it is in world coordinates, whatever the parametrisation of the others.
  PointModel point_model(std::int64_t p) const {
    switch (options_.point_parametrization) {
      case PointParametrization::HOMOGENEOUS: return PointModel::HOMOGENEOUS;
      case PointParametrization::INVERSE_DEPTH:
        return is_constant_point(p) ? PointModel::XYZ : PointModel::INVERSE_DEPTH;
      case PointParametrization::XYZ: break;
    }
    return PointModel::XYZ;
  }

  void check_point_constants() const {
    if (options_.point_parametrization == PointParametrization::XYZ) return;
    for (const CoordinateMask& mask : held_.points) {
      if (all_held(mask) || none_held(mask)) continue;
      throw OptionsError("BundleConfig.constant_coordinates holds single coordinates of a point, which "
                         "needs point_parametrization XYZ, got " +
                         to_string(options_.point_parametrization));
    }
  }

  // The host of an inverse-depth point is the first camera (lowest index) that sees it.
  void find_hosts() {
    hosts_.assign(source_.num_points(), -1);
    for (std::int64_t i = 0; i < source_.num_observations(); ++i) {
      std::int32_t& host = hosts_[source_.point_index[i]];
      const std::int32_t camera = source_.camera_index[i];
      if (host < 0 || camera < host) host = camera;
    }
  }

  void load_cameras() {
    const std::int64_t n = source_.num_cameras();
    poses_.resize(n * Pose::kSize);
    intrinsics_.resize(n * 3);
    for (std::int64_t c = 0; c < n; ++c) {
      const auto row = source_.cameras.row(c);
      Pose::from_angle_axis(row.head<3>().transpose(), row.segment<3>(3).transpose(), pose_block(c));
      Eigen::Map<Vector3>{intrinsics_block(c)} = row.tail<3>().transpose();
    }
    initial_poses_ = poses_;
  }

  void load_points() {
    point_size_ = options_.point_parametrization == PointParametrization::HOMOGENEOUS ? 4 : 3;
    points_.resize(source_.num_points() * point_size_);
    for (std::int64_t p = 0; p < source_.num_points(); ++p) {
      const Vector3 x = source_.points.row(p).transpose();
      double* block = point_block(p);
      switch (point_model(p)) {
        case PointModel::XYZ: Eigen::Map<Vector3>{block} = x; break;
        case PointModel::HOMOGENEOUS:
          Eigen::Map<Vector4>{block} = x.homogeneous().stableNormalized();
          break;
        case PointModel::INVERSE_DEPTH: load_inverse_depth(p, x, block); break;
      }
    }
    initial_points_ = points_;
  }

  void load_inverse_depth(std::int64_t p, const Vector3& x, double* block) {
    Eigen::Map<Vector3> parameters(block);
    if (hosts_[p] < 0) {  // never observed: never read
      parameters.setZero();
      return;
    }
    const Pose host(pose_block(hosts_[p]));
    const Vector3 p_h = host.R_cw * x + host.t_cw;
    parameters = Vector3(-p_h.x() / p_h.z(), -p_h.y() / p_h.z(), -1.0 / p_h.z());
  }

  void add_residuals() {
    for (std::int64_t i = 0; i < source_.num_observations(); ++i) add_residual(i);
  }

  void add_residual(std::int64_t i) {
    const std::int32_t c = source_.camera_index[i];
    const std::int32_t p = source_.point_index[i];
    const Vector2 observed = source_.observations.row(i).transpose();
    ceres::LossFunction* loss = options_.loss.type == LossType::TRIVIAL ? nullptr : &loss_;
    double* pose = pose_block(c);
    double* intrinsics = intrinsics_block(c);
    double* point = point_block(p);
    switch (point_model(p)) {
      case PointModel::XYZ:
        ceres_->AddResidualBlock(&xyz_costs_.emplace_back(observed), loss, pose, intrinsics, point);
        break;
      case PointModel::HOMOGENEOUS:
        ceres_->AddResidualBlock(&homogeneous_costs_.emplace_back(observed), loss, pose, intrinsics,
                                 point);
        break;
      case PointModel::INVERSE_DEPTH:
        if (hosts_[p] == c) {
          ceres_->AddResidualBlock(&host_costs_.emplace_back(observed), loss, intrinsics, point);
        } else {
          ceres_->AddResidualBlock(&inverse_depth_costs_.emplace_back(observed), loss, pose,
                                   intrinsics, point, pose_block(hosts_[p]));
        }
        break;
    }
  }

  void register_blocks() {
    for (std::int64_t c = 0; c < source_.num_cameras(); ++c) {
      for (double* block : {pose_block(c), intrinsics_block(c)}) {
        if (ceres_->HasParameterBlock(block)) blocks_.push_back(block);
      }
    }
    for (std::int64_t p = 0; p < source_.num_points(); ++p) {
      if (ceres_->HasParameterBlock(point_block(p))) point_blocks_.push_back(point_block(p));
    }
    blocks_.insert(blocks_.end(), point_blocks_.begin(), point_blocks_.end());
  }

  void apply_camera_constants() {
    ceres::Manifold* shared = pose_manifold(PoseMask{});  // one object serves every free camera
    bool shared_used = false;
    for (std::int64_t c = 0; c < source_.num_cameras(); ++c) {
      if (ceres_->HasParameterBlock(intrinsics_block(c))) {
        hold_coordinates(intrinsics_block(c), held_.intrinsics[c]);
      }
      if (!ceres_->HasParameterBlock(pose_block(c))) continue;
      const PoseMask& mask = held_.poses[c];
      if (mask.rotation && all_held(mask.translation)) {
        ceres_->SetParameterBlockConstant(pose_block(c));
      } else if (mask.any()) {
        ceres_->SetManifold(pose_block(c), pose_manifold(mask));
      } else if (shared != nullptr) {
        ceres_->SetManifold(pose_block(c), shared);
        shared_used = true;
      }
    }
    if (!shared_used) delete shared;
  }

  // nullptr: the block is its own tangent space.
  ceres::Manifold* pose_manifold(const PoseMask& mask) const {
    switch (options_.pose_parametrization) {
      case PoseParametrization::SE3: return new PoseManifold(TranslationUpdate::COUPLED, mask);
      case PoseParametrization::QUATERNION: return new PoseManifold(TranslationUpdate::ADDITIVE, mask);
      case PoseParametrization::ANGLE_AXIS: break;
    }
    if (!mask.any()) return nullptr;
    std::vector<int> held = mask.rotation ? std::vector<int>{0, 1, 2} : std::vector<int>{};
    for (const int k : held_offsets(mask.translation)) held.push_back(3 + k);
    return new ceres::SubsetManifold(6, held);
  }

  void hold_coordinates(double* block, const CoordinateMask& mask) {
    if (all_held(mask)) {
      ceres_->SetParameterBlockConstant(block);
    } else if (!none_held(mask)) {
      ceres_->SetManifold(block, new ceres::SubsetManifold(3, held_offsets(mask)));
    }
  }

  void apply_point_constants() {
    ceres::Manifold* sphere = nullptr;
    for (std::int64_t p = 0; p < source_.num_points(); ++p) {
      double* block = point_block(p);
      if (!ceres_->HasParameterBlock(block)) continue;
      if (is_constant_point(p)) {
        ceres_->SetParameterBlockConstant(block);
      } else if (point_model(p) == PointModel::HOMOGENEOUS) {
        if (sphere == nullptr) sphere = new ceres::SphereManifold<4>();
        ceres_->SetManifold(block, sphere);
      } else if (!held_.points.empty()) {
        hold_coordinates(block, held_.points[p]);
      }
    }
  }

  void write_back_pose(std::int64_t c, BalProblem& problem) const {
    const double* first = &initial_poses_[c * Pose::kSize];
    const double* now = pose_block(c);
    const std::size_t bytes = Pose::kSize * sizeof(double);
    if (std::memcmp(first, now, bytes) == 0) return;
    const std::size_t rotation_bytes = bytes - 3 * sizeof(double);
    if (std::memcmp(first, now, rotation_bytes) != 0) {  // a held rotation keeps the file's digits
      problem.cameras.row(c).head<3>() = Pose::angle_axis(now).transpose();
    }
    problem.cameras.row(c).segment<3>(3) =
        Eigen::Map<const Vector3>(Pose::translation(now)).transpose();
  }

  // An anchored point moves in the world with its host, even when its own numbers stay.
  bool host_moved(std::int64_t p) const {
    if (point_model(p) != PointModel::INVERSE_DEPTH || hosts_[p] < 0) return false;
    return std::memcmp(&initial_poses_[hosts_[p] * Pose::kSize], pose_block(hosts_[p]),
                       Pose::kSize * sizeof(double)) != 0;
  }

  Vector3 world_point(std::int64_t p) const {
    const double* block = &points_[p * point_size_];
    switch (point_model(p)) {
      case PointModel::XYZ: return Eigen::Map<const Vector3>(block);
      case PointModel::HOMOGENEOUS:
        return Eigen::Map<const Vector3>(block) / bounded_weight(block[3]);
      case PointModel::INVERSE_DEPTH: break;
    }
    const Pose host(pose_block(hosts_[p]));
    const Vector3 m(block[0], block[1], -1.0);
    return host.R_cw.transpose() * (m / bounded_weight(block[2]) - host.t_cw);
  }

  // A BAL file has no points at infinity: they are written at 1e12 scene units, where the pixel is the same
  // to about 1e-9 px.
  static double bounded_weight(double w) {
    constexpr double kSmallest = 1e-12;
    return std::abs(w) < kSmallest ? std::copysign(kSmallest, w) : w;
  }

  const BalProblem& source_;
  const BundleOptions options_;
  const Constants held_;
  RobustLoss loss_;
  std::vector<std::int32_t> hosts_;  // per point; -1 = never observed
  std::vector<double> poses_, initial_poses_;
  std::vector<double> intrinsics_;
  std::vector<double> points_, initial_points_;
  std::int64_t point_size_ = 3;
  // deques: Ceres keeps the addresses, and cost functions cannot move
  std::deque<ReprojectionCost<Pose, XyzPoint>> xyz_costs_;
  std::deque<ReprojectionCost<Pose, HomogeneousPoint>> homogeneous_costs_;
  std::deque<InverseDepthCost<Pose>> inverse_depth_costs_;
  std::deque<InverseDepthHostCost> host_costs_;
};

}  // namespace

std::unique_ptr<ReprojectionProblem> ReprojectionProblem::create(const BalProblem& problem,
                                                                 const BundleConfig& config,
                                                                 const BundleOptions& options) {
  if (options.pose_parametrization == PoseParametrization::ANGLE_AXIS) {
    return std::make_unique<Builder<AngleAxisPose>>(problem, config, options);
  }
  return std::make_unique<Builder<QuaternionPose>>(problem, config, options);
}

}  // namespace raylign::ceres_backend
