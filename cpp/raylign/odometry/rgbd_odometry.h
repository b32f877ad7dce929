// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <cstdint>
#include <deque>
#include <memory>
#include <string>
#include <vector>

#include "raylign/camera/pinhole.h"
#include "raylign/depth/inverse_depth.h"
#include "raylign/image/image_view.h"
#include "raylign/odometry/depth_agreement.h"
#include "raylign/odometry/motion_model.h"
#include "raylign/odometry/options.h"
#include "raylign/odometry/readout.h"
#include "raylign/tracking/aligner.h"

namespace raylign {

/// What is known of a frame's pose.
enum class OdometryStatus {
  OK,         ///< tracked
  RECOVERED,  ///< tracked, the first after a loss
  LOST,       ///< not tracked; T_wc is NaN
  NO_DEPTH,   ///< nothing to start from: no frame with enough depth and texture came yet
};

std::string to_string(OdometryStatus status);

/// What `track` says about a frame.
struct OdometryResult {
  std::int64_t frame = -1;  ///< counted from 0
  double timestamp = 0.0;   ///< s, as given
  OdometryStatus status = OdometryStatus::NO_DEPTH;
  std::string reason;                  ///< why it is not OK; empty when it is
  Matrix4 T_wc = Matrix4::Identity();  ///< camera to world; NaN when there is no pose
  std::int64_t keyframe = -1;          ///< frame number of the keyframe it was aligned with
  bool is_keyframe = false;            ///< it is the keyframe for those that follow
  int num_alignments = 0;              ///< alignments tried
  double readout_s = 0.0;              ///< of the rows, as known with this frame
  AlignmentResult alignment;           ///< with that keyframe; of the last try when LOST
};

/// RGB-D odometry: frames are aligned with the last keyframe (LSD-SLAM §3.3 with a sensor's depth),
/// keyframes follow the paper's rule. A frame that cannot be aligned from the predicted pose is
/// tried from others, then with the frame before it, then with the recent keyframes; if nothing
/// leads to an alignment that its own status calls OK, the frame is LOST and says so.
class RgbdOdometry {
 public:
  /// Throws OptionsError. `T_wc`: pose of the first frame.
  RgbdOdometry(const PinholeCamera& camera,
               const OdometryOptions& options,
               const Matrix4& T_wc = Matrix4::Identity());

  /// Timestamps in s must grow (OptionsError). `image`: grey or colour, rectified; `depth` of the
  /// same size: float32 m or uint16 units of 1/depth_scale m. Throws ShapeError.
  OdometryResult track(const ImageView& image, const ImageView& depth, double timestamp);

  const OdometryOptions& options() const { return options_; }

 private:
  /// A frame, and its depth as it came until somebody needs it.
  struct Shot {
    std::shared_ptr<Frame> frame;
    std::vector<std::byte> depth;
    ImageView depth_view;  ///< into `depth`
  };

  /// A keyframe with its place in the world.
  struct Placed {
    std::shared_ptr<Shot> shot;
    std::shared_ptr<Keyframe> keyframe;
    Matrix4 T_kw = Matrix4::Identity();
    std::int64_t frame = -1;
    Vector6 velocity = Vector6::Zero();  ///< per s, left twist of T_kw
    double a = 0.0;                      ///< brightness of the last frame aligned with it
    double b = 0.0;
  };

  /// An alignment, and where the frame's own depth would have the camera.
  struct Found {
    AlignmentResult alignment;
    double depth_step = 0.0;  ///< share of the mean depth and rad; 0: not asked
    Matrix4 T_cw_by_depth = Matrix4::Identity();
  };

  void check_input(const ImageView& image, const ImageView& depth, double timestamp);
  std::shared_ptr<Shot> make_shot(const ImageView& image, const ImageView& depth);
  void set_depth(const ImageView& depth, Frame& frame);
  bool start(const std::shared_ptr<Shot>& shot, OdometryResult& result);
  bool follow(const Frame& frame, OdometryResult& result);
  bool recover(const Frame& frame, OdometryResult& result);
  bool try_start(Placed& reference,
                 const Frame& frame,
                 const Matrix4& T_cw,
                 OdometryResult& result);
  Found align(Aligner& aligner, const Placed& reference, const Frame& frame, const Matrix4& T_cw);
  const PointList& coarsest_points(const Keyframe& keyframe) const;
  void judge_depth_step(double step, AlignmentResult& alignment) const;
  bool try_best_of(Placed& reference,
                   const Frame& frame,
                   const std::vector<Matrix4>& starts,
                   OdometryResult& result);
  Shutter shutter(const Placed& reference) const;
  void refine_readout(Placed& reference, const Frame& frame, OdometryResult& result);
  double sweep_px(const Placed& reference, const OdometryResult& result, double readout_s) const;
  void judge(const Placed& reference, const Matrix4& T_cw, AlignmentResult& alignment) const;
  bool needs_keyframe(const OdometryResult& result) const;
  bool add_keyframe(const std::shared_ptr<Shot>& shot, const Matrix4& T_cw, std::int64_t number);
  void update_velocities(const Matrix4& T_cw, double timestamp);
  void finish(const std::shared_ptr<Shot>& shot, OdometryResult& result);

  PinholeCamera camera_;
  OdometryOptions options_;
  Matrix4 T_cw_first_;
  MotionModel motion_;
  ReadoutEstimator readout_;
  InverseDepthConverter converter_;
  Aligner aligner_;
  Aligner coarse_aligner_;
  Aligner fine_aligner_;
  std::vector<std::shared_ptr<Shot>> pool_;
  Plane<float> D_, V_;
  SensedDepth sensed_;              ///< of the frame at hand
  std::deque<Placed> keyframes_;    ///< oldest first
  std::shared_ptr<Shot> previous_;  ///< the last tracked frame
  std::int64_t previous_number_ = -1;
  Vector6 velocity_ = Vector6::Zero();  ///< of the last tracked frame, per s
  std::int64_t num_frames_ = 0;
  double last_timestamp_ = 0.0;
  int width_ = 0;
  int height_ = 0;
  bool is_lost_ = false;
};

}  // namespace raylign
