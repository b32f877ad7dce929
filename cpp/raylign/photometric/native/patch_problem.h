// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/patch/patch_scene.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/native/image_columns.h"
#include "raylign/photometric/native/patch_kernels.h"
#include "raylign/photometric/native/patch_layout.h"
#include "raylign/photometric/native/patch_priors.h"
#include "raylign/photometric/native/patch_schur.h"
#include "raylign/solver/lm.h"
#include "raylign/solver/summary.h"

namespace raylign::native {

/// A PatchScene as the Levenberg-Marquardt loop sees it (solver/lm.h), points eliminated, the
/// reduced system of the images dense.
///
/// Sums over points are made in a number of parts that depends on the problem alone and then added
/// in their order, so that the bits do not depend on the number of threads.
class PatchProblem {
 public:
  /// `scene` is read here; its images must live on.
  PatchProblem(const PatchScene& scene,
               const PatchConstraints& constraints,
               const PatchSolveOptions& options,
               InterruptCheck interrupted = nullptr);

  LmState linearize();
  LmSolve solve(double lambda, bool tight = false);
  LmTrial try_step();
  void accept();

  /// Writes the current state into `scene`; what did not move keeps its bits.
  void write_back(PatchScene& scene) const;

  int num_effective_parameters() const;
  std::int64_t num_seen() const { return num_seen_; }
  std::int64_t num_residuals() const { return layout_.num_living_pixels(); }
  double max_diagonal();  ///< of H, free columns and points, linearised

 private:
  struct State {
    std::vector<PatchPose> poses;
    Rows<double, 2> brightness;
    Rows<double, 4> intrinsics;
    std::vector<double> points;        // (N, 3)
    std::vector<ImagePacket> packets;  // made of the above
  };
  // One part's sums.
  struct Part {
    PatchSums sums;
    PointStep step;
    std::vector<double> diagonal, cross, gradient;  // (M, C, C), (blocks, C, C), (M, C)
    std::vector<double> S, rhs;                     // (blocks, C, C), (M, C)
  };

  int num_images() const { return static_cast<int>(state_.poses.size()); }
  int C() const { return layout_.num_columns(); }
  std::int64_t num_blocks() const { return block_starts_.back(); }
  PatchStateArrays arrays_of(const State& state) const {
    return {state.packets.data(), state.points.data()};
  }
  const double* left_costs() const {
    return options_.leaving == LeavingRule::KEEP_COST ? left_costs_.data() : nullptr;
  }

  void load_state(const PatchScene& scene);
  void set_packets(State& state) const;
  void make_parts();
  void find_living_edges();
  void run_linearize(bool first);
  void add_parts();
  PriorState priors_state(const State& state) const {
    return {state.poses, state.brightness, state.points, inverse_depth_};
  }
  double gradient_max_norm() const;
  void set_diagonal();
  void set_scales();
  void set_damping(double lambda);
  void form_system();
  double image_model_decrease() const;

  PatchSolveOptions options_;
  InterruptCheck interrupted_;
  PatchConstraints constraints_;
  ImageColumns columns_;
  PatchLayout layout_;
  ThreadPool pool_;
  std::vector<std::int64_t> block_starts_;  // (M + 1,)
  std::vector<std::int64_t> part_points_;   // (parts + 1,) first point of each
  std::vector<Part> parts_;
  std::vector<unsigned char> held_;
  bool inverse_depth_;

  State state_, trial_;
  std::vector<double> left_costs_;
  std::vector<PointBlock> point_blocks_;
  std::vector<PointFactor> factors_;
  std::vector<double> point_scales_, point_damping_;  // (N, 3)
  std::vector<double> W_;                             // (slots, 3, C)
  std::vector<double> H_;                             // (blocks, C, C), of the images
  std::vector<double> gradient_;                      // (M, C)
  std::vector<double> S_, rhs_;                       // as H_, gradient_
  std::vector<double> column_scales_, damping_;       // (n,) free columns
  Eigen::MatrixXd matrix_;                            // (n, n) lower triangle
  Eigen::VectorXd delta_;                             // (n,)
  std::vector<double> image_steps_;                   // (M, C)
  SchurArrays schur_{};
  std::int64_t num_seen_ = 0;
  bool has_scales_ = false;
  bool is_start_linearized_ = false;  // parts_ hold it
};

}  // namespace raylign::native
