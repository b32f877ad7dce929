// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/solver_costs.h"

#include <algorithm>
#include <cstdio>
#include <limits>

namespace raylign::native {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

// Measured on one Zen 4 core, large problems: native_stages of benchmarks/micro.
constexpr double kRest_s = 60e-9;                // linearise, damp, try: an observation
constexpr double kElimination_s = 20e-9;         // Z of an observation
constexpr double kPair_s = 11e-9;                // Z Zᵀ into a block of S
constexpr double kBlock_s = 900e-9;              // visits to a block of S, and its fold
constexpr double kBlockProduct_s = 40e-9;        // a block of S times a vector, both halves
constexpr double kBlockProjection_s = 150e-9;    // a block into the coarse space
constexpr double kObservationProduct_s = 13e-9;  // an observation in a matrix-free product
constexpr double kDenseFlops = 38e9;             // per s, one matrix
constexpr double kSparseFlops = 28e9;            // per s, fronts
constexpr double kSolveBytes = 8e9;              // per s, triangular solves
constexpr double kCamerasPerCluster = 12.0;
constexpr double kMotions = 7.0;  // columns of a cluster in the coarse system
// An inexact step gains less: more steps follow. S that is formed is solved nearly exactly.
constexpr double kInexact = 1.6;
constexpr double kNearlyExact = 1.1;

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
  const double rest = c.observations * (kRest_s + kElimination_s);
  const double form = rest + c.pairs * kPair_s + c.blocks * kBlock_s;
  const double n = c.columns;
  SolveCosts costs;
  costs[static_cast<int>(SolveMethod::DENSE)] =
      within(8.0 * n * n, form + n * n * n / 3.0 / kDenseFlops + 16.0 * n * n / kSolveBytes);
  const double matrix_bytes = c.blocks * 81.0 * 12.0;
  costs[static_cast<int>(SolveMethod::SPARSE)] =
      c.sparse_flops > 0.0 && c.sparse_nonzeros < kMaxSparseNonzeros
          ? within(8.0 * c.sparse_nonzeros + matrix_bytes,
                   form + c.sparse_flops / kSparseFlops + 16.0 * c.sparse_nonzeros / kSolveBytes)
          : kInfinity;
  const double coarse = kMotions * n / 9.0 / kCamerasPerCluster;
  const double precondition =
      c.blocks * kBlockProjection_s + coarse * coarse * coarse / 3.0 / kDenseFlops;
  const double iterate = c.blocks * kBlockProduct_s + 16.0 * coarse * coarse / kSolveBytes;
  costs[static_cast<int>(SolveMethod::EXPLICIT_CG)] = within(
      8.0 * coarse * coarse, kNearlyExact * (form + precondition + c.cg_iterations * iterate));
  costs[static_cast<int>(SolveMethod::MATRIX_FREE_CG)] =
      kInexact * (rest + c.observations * (kPair_s + c.cg_iterations * kObservationProduct_s));
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
