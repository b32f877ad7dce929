// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <array>
#include <cstdint>
#include <string>

namespace raylign::native {

/// The ways to solve S δ = b that AUTO weighs.
enum class SolveMethod { DENSE, SPARSE, EXPLICIT_CG, MATRIX_FREE_CG };
inline constexpr int kNumSolveMethods = 4;

/// What the costs follow from: counts, never times, so that the choice is the same on every run.
struct SolveCounts {
  double observations = 0.0;
  double columns = 0.0;          ///< free columns of the cameras
  double pairs = 0.0;            ///< products Z Zᵀ in one formation of S
  double blocks = 0.0;           ///< of the upper triangle of S
  double sparse_flops = 0.0;     ///< of one sparse factor; 0: there is no sparse solver
  double sparse_nonzeros = 0.0;  ///< of that factor
  double cg_iterations = 20.0;   ///< expected, then the running mean
};

/// Seconds of one step on a core like those of docs/benchmarks.md; infinite: not possible, or past
/// the memory that a solve may take.
using SolveCosts = std::array<double, kNumSolveMethods>;
SolveCosts predict_costs(const SolveCounts& counts);

/// The cheapest method.
SolveMethod cheapest(const SolveCosts& costs);

/// "sparse Cholesky of S predicted 0.27 s a step against dense 7 s, …".
std::string explain(SolveMethod chosen, const SolveCosts& costs);

}  // namespace raylign::native
