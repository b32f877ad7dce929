// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/camera_blocks.h"

#include <algorithm>

#include "raylign/geometry/so3.h"

namespace raylign::native {
namespace {

using MapRows = Eigen::Map<Eigen::Matrix<double, 9, kRow, Eigen::RowMajor>>;

// [ω; δc] of a pose step [υ; φ]: ω = Rᵀφ; c = −Rᵀt moves by −Rᵀυ, and by −Rᵀ[t]×φ more where the
// rotation leaves t alone.
Matrix6 canonical_from_left(TranslationUpdate update, const Matrix3& R, const Vector3& t) {
  Matrix6 M = Matrix6::Zero();
  M.topRightCorner<3, 3>() = R.transpose();
  M.bottomLeftCorner<3, 3>() = -R.transpose();
  if (update == TranslationUpdate::ADDITIVE) {
    M.bottomRightCorner<3, 3>() = -R.transpose() * so3_hat(t);
  }
  return M;
}

}  // namespace

CameraBlocks::CameraBlocks(const BundleScene& scene,
                           PoseParametrization parametrization,
                           const Constants& held,
                           const std::vector<bool>& observed,
                           const HomogeneousFrame& frame)
    : model_(scene.camera_model),
      num_intrinsics_(scene.num_intrinsics()),
      parametrization_(parametrization),
      frame_(frame),
      held_(held),
      offsets_{0} {
  const auto count = static_cast<int>(scene.num_cameras());
  maps_.assign(count, Block{});
  for (int i = 0; i < count; ++i) {
    const Vector3 omega = scene.omega.row(i).transpose();
    IntrinsicsVector intrinsics = IntrinsicsVector::Zero();
    intrinsics.head(num_intrinsics_) = scene.intrinsics.row(i).transpose();
    initial_.push_back({quaternion_exp(omega), omega, scene.t.row(i).transpose(), intrinsics});
    const int columns = num_pose_columns(i) + count_free(held_.intrinsics[i]);
    offsets_.push_back(offsets_.back() + (observed[i] ? columns : 0));
  }
  cameras_ = trial_ = initial_;
  for (int i = 0; i < count; ++i) packets_.push_back(packet(i, cameras_[i]));
  trial_packets_ = packets_;
  for (int i = 0; i < count; ++i) update_map(i);
}

int CameraBlocks::num_pose_columns(int i) const {
  int columns = 0;
  for (int k = 0; k < 6; ++k) columns += held_.poses[i].is_free(k) ? 1 : 0;
  return columns;
}

Matrix3 CameraBlocks::rotation(const Camera& camera) const {
  return is_angle_axis() ? so3_exp(camera.omega) : Matrix3(camera.q.toRotationMatrix());
}

// Which parameter stands in which column of I.
void CameraBlocks::set_columns(int i, std::int32_t* columns) const {
  std::fill_n(columns, 3, -1);
  for (int k = 0, next = 0; k < num_intrinsics_; ++k) {
    if (model_ == CameraModel::BAL || !held_.intrinsics[i][k]) columns[next++] = k;
  }
}

CameraPacket CameraBlocks::packet(int i, const Camera& camera) const {
  CameraPacket packet{};
  Eigen::Map<RowMajor<3, 3>> R(packet.R);
  R = rotation(camera);
  Eigen::Map<Vector3>{packet.t} = (R * frame_.center + camera.t) / frame_.scale;
  Eigen::Map<Vector3>{packet.c} = (-(R.transpose() * camera.t) - frame_.center) / frame_.scale;
  Eigen::Map<IntrinsicsVector>{packet.intrinsics} = camera.intrinsics;
  if (model_ == CameraModel::RADTAN) {
    const auto& k = camera.intrinsics;
    packet.max_radius_squared =
        PolynomialDistortion{k[4], k[5], k[6], k[7], k[8]}.max_radius_squared();
  }
  set_columns(i, packet.columns);
  return packet;
}

void CameraBlocks::update_map(int i) {
  if (size(i) == 0) return;
  const Camera& camera = cameras_[i];
  const PoseMask& mask = held_.poses[i];
  const Matrix6 M = canonical_from_left(update(), rotation(camera), camera.t);
  MapRows B(maps_[i].values);
  B.setZero();
  int column = 0;
  if (is_angle_axis()) {  // tangent [δω; δt], φ = J_l δω
    const Matrix3 J_left = so3_left_jacobian(camera.omega);
    for (int k = 0; k < 3 && !mask.rotation; ++k) {
      B.col(column++).head<6>() = M.rightCols<3>() * J_left.col(k);
    }
    for (int k = 0; k < 3; ++k) {
      if (!mask.translation[k]) B.col(column++).head<6>() = M.col(k);
    }
  } else {
    const PoseEmbedding E = pose_embedding(update(), mask, camera.t);
    column = static_cast<int>(E.cols());
    B.topLeftCorner(6, column) = M * E;
  }
  B.middleRows<3>(3) /= frame_.scale;
  for (int row = 0; row < 3; ++row) {
    const std::int32_t k = packets_[i].columns[row];
    if (k >= 0 && !held_.intrinsics[i][k]) B(6 + row, column++) = 1.0;
  }
}

void CameraBlocks::move_angle_axis(int i, const double* delta, Camera& camera) const {
  const PoseMask& mask = held_.poses[i];
  if (!mask.rotation) {
    camera.omega += Eigen::Map<const Vector3>(delta);
    delta += 3;
  }
  for (int k = 0; k < 3; ++k) {
    if (!mask.translation[k]) camera.t[k] += *delta++;
  }
}

CameraBlocks::Camera CameraBlocks::moved(int i, const double* delta) const {
  Camera camera = cameras_[i];
  const PoseMask& mask = held_.poses[i];
  const int num_pose = num_pose_columns(i);
  if (is_angle_axis()) {
    move_angle_axis(i, delta, camera);
  } else if (num_pose > 0) {
    const Vector6 xi = pose_embedding(update(), mask, camera.t) *
                       Eigen::Map<const Eigen::VectorXd>(delta, num_pose);
    pose_plus(update(), mask, xi, camera.q, camera.t);
  }
  delta += num_pose;
  for (int k = 0; k < num_intrinsics_; ++k) {
    if (!held_.intrinsics[i][k]) camera.intrinsics[k] += *delta++;
  }
  return camera;
}

void CameraBlocks::try_step(const double* delta) {
  for (int i = 0; i < num_cameras(); ++i) {
    if (size(i) == 0) continue;
    trial_[i] = moved(i, delta + offset(i));
    trial_packets_[i] = packet(i, trial_[i]);
  }
}

void CameraBlocks::accept() {
  cameras_.swap(trial_);
  packets_.swap(trial_packets_);
  for (int i = 0; i < num_cameras(); ++i) update_map(i);
}

double CameraBlocks::squared_norm() const {
  double sum = 0.0;
  for (int i = 0; i < num_cameras(); ++i) {
    if (size(i) == 0) continue;
    const Camera& camera = cameras_[i];
    if (!held_.poses[i].all()) {
      sum += camera.t.squaredNorm() + (is_angle_axis() ? camera.omega.squaredNorm() : 1.0);
    }
    if (count_free(held_.intrinsics[i]) > 0) sum += camera.intrinsics.squaredNorm();
  }
  return sum;
}

void CameraBlocks::write_back(BundleScene& scene) const {
  for (int i = 0; i < num_cameras(); ++i) {
    const Camera& camera = cameras_[i];
    if (is_angle_axis()) {
      scene.omega.row(i) = camera.omega.transpose();
    } else if (camera.q.coeffs() != initial_[i].q.coeffs()) {  // a held rotation keeps its digits
      scene.omega.row(i) = quaternion_log(camera.q).transpose();
    }
    scene.t.row(i) = camera.t.transpose();
    scene.intrinsics.row(i) = camera.intrinsics.head(num_intrinsics_).transpose();
  }
}

}  // namespace raylign::native
