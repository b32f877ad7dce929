// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <vector>

#include "raylign/bundle/native/coarse_kernels.h"
#include "raylign/bundle/native/preconditioner.h"

namespace raylign::native {

/// M⁻¹ = M_SJ⁻¹ + Z (ZᵀSZ)⁻¹ Zᵀ: Schur-Jacobi plus a coarse space. Z holds the seven similarity
/// motions of each cluster of cameras, which are what one-level methods take hundreds of iterations
/// to move on a long street. Needs the whole S.
class TwoLevel : public SchurPreconditioner {
 public:
  TwoLevel(const SolverContext& context, const SchurPattern& pattern);
  void prepare(const SchurSystem& system, const DampedProblem& problem) override;
  void apply(const double* r, double* z) override;

  int num_clusters() const { return num_clusters_; }

 private:
  void set_modes(int cluster, const DampedProblem& problem);
  void form_coarse(const SchurSystem& system);
  void add_mirror_images(int cluster);
  void scale_coarse();

  const CameraBlocks& cameras_;
  ThreadPool& pool_;
  BlockJacobi fine_;
  std::vector<std::int32_t> cluster_;  // (C,) −1: the camera does not move
  int num_clusters_ = 0;
  std::vector<std::vector<std::int32_t>> members_;  // (clusters,) their cameras, ascending
  Table<double> modes_;                             // (C, 9, kModeRow), the user's tangent
  std::vector<Table<double>> panels_;               // one per thread, (7 clusters, kModeRow)
  std::vector<double> coarse_;  // (7 clusters)², column-major, in the end lower triangle
  std::vector<double> scales_, restricted_;  // (7 clusters,)
  bool has_coarse_ = false;
};

/// Connected clusters of at most `max_size` moving cameras, numbered; −1 for the others.
std::vector<std::int32_t> cluster_cameras(const SchurPattern& pattern, int max_size);

}  // namespace raylign::native
