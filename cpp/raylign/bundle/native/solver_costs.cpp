// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/solver_costs.h"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace raylign::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Measured on one Zen 4 core: benchmarks/, docs/theory/native-engine.md.
constexpr double kPair_s = 15e-9;                // Z Zᵀ into a block of S
constexpr double kElimination_s = 15e-9;         // Z of an observation
constexpr double kBlockProduct_s = 45e-9;        // a block of S times a vector, both halves
constexpr double kObservationProduct_s = 25e-9;  // an observation in a matrix-free product
constexpr double kBlockFold_s = 150e-9;  // to the user's tangent, and into a factor's matrix
constexpr double kDenseFlops = 35e9;     // per s, one matrix
constexpr double kSparseFlops = 12e9;    // per s, supernodes
constexpr double kSolveBytes = 8e9;      // per s, triangular solves
// An inexact step gains less: more steps follow.
constexpr double kInexact = 2.2;

constexpr double kBlockBytes = 864.0;
constexpr double kPairBytes = 6.0;
// What S and its factor may take: 160 bytes per observation, and always 64 MB.
constexpr double kBytesPerObservation = 160.0;
constexpr double kAlwaysBytes = 64e6;
constexpr double kMaxSparseNonzeros = 2.0e9;  // CHOLMOD's int

}  // namespace

SolveCosts predict_costs(const SolveCounts& c) {
  const double budget = std::max(kAlwaysBytes, kBytesPerObservation * c.observations);
  const double S_bytes = c.blocks * kBlockBytes + c.pairs * kPairBytes;
  const auto within = [&](double bytes, double seconds) {
    return S_bytes + bytes <= budget ? seconds : kInfinity;
  };
  const double form = c.observations * kElimination_s + c.pairs * kPair_s + c.blocks * kBlockFold_s;
  const double n = c.columns;
  SolveCosts costs;
  costs[static_cast<int>(SolveMethod::DENSE)] =
      within(8.0 * n * n, form + n * n * n / 3.0 / kDenseFlops + 16.0 * n * n / kSolveBytes);
  const double matrix_bytes = c.blocks * 81.0 * 12.0;
  costs[static_cast<int>(SolveMethod::SPARSE)] =
      c.sparse_flops > 0.0 && c.sparse_nonzeros < kMaxSparseNonzeros
          ? within(8.0 * c.sparse_nonzeros + matrix_bytes,
                   form + c.blocks * kBlockFold_s + c.sparse_flops / kSparseFlops +
                       16.0 * c.sparse_nonzeros / kSolveBytes)
          : kInfinity;
  costs[static_cast<int>(SolveMethod::EXPLICIT_CG)] =
      within(0.0, kInexact * (form + c.cg_iterations * c.blocks * kBlockProduct_s));
  costs[static_cast<int>(SolveMethod::MATRIX_FREE_CG)] =
      kInexact * c.observations *
      (kElimination_s + kPair_s + c.cg_iterations * kObservationProduct_s);
  return costs;
}

SolveMethod cheapest(const SolveCosts& costs) {
  return static_cast<SolveMethod>(std::min_element(costs.begin(), costs.end()) - costs.begin());
}

std::string explain(SolveMethod chosen, const SolveCosts& costs) {
  constexpr const char* kNames[kNumSolveMethods] = {"dense Cholesky", "sparse Cholesky",
                                                    "conjugate gradients on S",
                                                    "matrix-free conjugate gradients"};
  std::string text;
  const auto add = [&](int method, const char* format) {
    char buffer[120];
    std::snprintf(buffer, sizeof(buffer), format, kNames[method], costs[method]);
    text += buffer;
  };
  add(static_cast<int>(chosen), "%s predicted %.3g s a step");
  const char* joint = " against %s %.3g";
  for (int method = 0; method < kNumSolveMethods; ++method) {
    if (method == static_cast<int>(chosen) || !(costs[method] < kInfinity)) continue;
    add(method, joint);
    joint = ", %s %.3g";
  }
  return text;
}

}  // namespace raylign::native
