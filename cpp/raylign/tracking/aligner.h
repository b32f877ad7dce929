// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/thread_pool.h"
#include "raylign/tracking/keyframe.h"
#include "raylign/tracking/options.h"
#include "raylign/tracking/point_pass.h"
#include "raylign/tracking/result.h"

namespace raylign {

/// Where alignment starts.
struct AlignmentStart {
  Matrix4 T_th = Matrix4::Identity();
  double a = 0.0;
  double b = 0.0;
  Shutter shutter;
};

/// Aligns frames with keyframes, coarse to fine. Keeps threads and memory between calls; one call
/// at a time. The bits of a result do not depend on the number of threads.
class Aligner {
 public:
  /// Throws OptionsError.
  explicit Aligner(const TrackingOptions& options);

  const TrackingOptions& options() const { return options_; }

  /// Never fails by exception on what the images hold: see AlignmentResult::status. Throws
  /// OptionsError when `start` is no rigid motion (SIM3: no similarity), or SIM3 is asked for and
  /// the target has no depth. The target may have another size and camera than the keyframe.
  AlignmentResult align(const Keyframe& keyframe,
                        const Frame& target,
                        const AlignmentStart& start = {},
                        bool with_maps = false);

 private:
  template <typename Motion>
  AlignmentResult align_motion(const Keyframe& keyframe,
                               const Frame& target,
                               const AlignmentStart& start,
                               bool with_maps);

  // Where a level's alignment begins, and the passes that it took to find that.
  struct LevelStart {
    tracking::PoseState state;
    int num_evaluations = 0;
  };

  LevelStart turned(const Keyframe& keyframe,
                    const Frame& target,
                    int level,
                    const tracking::PoseState& start);
  template <typename Motion>
  LevelStart better_start(const Keyframe& keyframe,
                          const Frame& target,
                          int level,
                          const tracking::PoseState& start);

  TrackingOptions options_;
  TrackingOptions rotation_options_;
  ThreadPool pool_;
  tracking::Workspace workspace_;
};

}  // namespace raylign
