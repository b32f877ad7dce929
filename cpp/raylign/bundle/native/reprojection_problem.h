// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <memory>
#include <string>
#include <vector>

#include "raylign/base/thread_pool.h"
#include "raylign/bundle/native/camera_blocks.h"
#include "raylign/bundle/native/jacobian_table.h"
#include "raylign/bundle/native/kernels.h"
#include "raylign/bundle/native/layout.h"
#include "raylign/bundle/native/make_solver.h"
#include "raylign/bundle/native/table.h"
#include "raylign/bundle/native/trial_kernels.h"
#include "raylign/parametrization/constants.h"
#include "raylign/scene/bundle_scene.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/lm.h"

namespace raylign::native {

/// A scene as the Levenberg-Marquardt loop sees it (solver/lm.h): XYZ or homogeneous points,
/// landmarks eliminated. Nothing is allocated after construction, but when J is promoted.
class ReprojectionProblem {
 public:
  /// `scene` must have finite residuals; it is read here and not kept.
  ReprojectionProblem(const BundleScene& scene,
                      const Constants& held,
                      const BundleOptions& options,
                      const InterruptCheck& interrupted = nullptr);

  LmState linearize();
  LmSolve solve(double lambda, bool tight = false);
  LmTrial try_step();
  void accept();

  /// Writes the current state into `scene`; what did not move keeps its bits.
  void write_back(BundleScene& scene) const;

  int num_effective_parameters() const;
  /// Steps of the last `solve` and `try_step`: cameras' free columns, then landmark by landmark.
  const std::vector<double>& camera_step() const { return delta_; }
  const CameraBlocks& cameras() const { return cameras_; }
  ThreadPool& pool() { return pool_; }
  const Layout& layout() const { return layout_; }

  /// The linearised problem damped by λ: what a linear solver sees.
  DampedProblem damped(double lambda);
  LinearSolverType linear_solver() const { return solver_->type(); }
  std::string linear_solver_reason() const { return solver_->reason(); }
  std::string jacobian_storage() const { return J_.description(); }

 private:
  State state() const {
    const Loss* loss = options_.loss.type == LossType::TRIVIAL ? nullptr : &options_.loss;
    return {layout_.observations(), cameras_.packets(), X_.data(), loss};
  }
  const CoordinateMask* held_points() const { return held_.empty() ? nullptr : held_.data(); }

  int point_size() const { return layout_.point_kind == PointKind::HOMOGENEOUS ? 4 : 3; }
  void load_points(const BundleScene& scene);
  void load_point(const Vector3& X, double* out) const;

  LmSolve solve_once(double lambda, bool tight);
  void promote_jacobians();
  LmState linearize_chunks();
  void linearize_chunk(int chunk, CameraRows* scratch);
  template <typename Task>
  void for_each_chunk(const Task& task);
  double sum_cameras();
  void sum_camera(int i);
  void set_scales();
  void set_damping(double lambda);
  void set_canonical_step();
  double camera_gradient_step() const;

  BundleOptions options_;
  HomogeneousFrame frame_;  // of homogeneous points; else the world's
  ThreadPool pool_;         // before what it helps to make
  Layout layout_;
  std::vector<CoordinateMask> held_;  // (L,) in the landmarks' order, or empty
  CameraBlocks cameras_;

  Table<double> X_, X_trial_;  // (L, point_size())
  JacobianTable J_;
  Table<LandmarkBlock> landmark_blocks_;
  Table<LandmarkFactor> landmark_factors_;
  Table<double> landmark_scales_;  // (L, 3)
  // Of each chunk, for the cameras that it touches; the first of them; cost and gradient.
  std::vector<std::vector<CameraSums>> chunk_cameras_;
  std::vector<std::int32_t> chunk_first_camera_;
  std::vector<LmState> chunk_states_;
  std::vector<CameraSums> camera_sums_;
  std::vector<TrialSums> chunk_trials_;
  std::vector<Table<TrialScratch>> trial_scratch_;  // one per thread
  std::vector<Table<CameraRows>> row_scratch_;

  std::vector<double> camera_gradient_, camera_diagonal_, camera_scales_, damping_;  // user columns
  std::vector<double> delta_;                                                        // user columns
  std::vector<double> canonical_delta_;                                              // (C, kRow)
  std::unique_ptr<LinearSolver> solver_;
  double cost_ = 0.0;    // of the current state
  double lambda_ = 0.0;  // of the last solve
  int num_linearizations_ = 0;
  bool has_scales_ = false;
};

}  // namespace raylign::native
