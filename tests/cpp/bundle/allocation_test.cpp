// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Counts what the whole process takes from the heap: a program of its own.
#include <gtest/gtest.h>
#include <malloc.h>

#include <algorithm>
#include <atomic>
#include <cstdlib>
#include <string>

#include "raylign/bundle/bundle_adjuster.h"
#include "raylign/synthetic/bal.h"
#include "support/small_problem.h"

// Below operator new, so that Eigen, LAPACK and the threads count too. The sanitizers have a malloc
// of their own.
#if defined(__GLIBC__) && !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define COUNTS_ALLOCATIONS 1
extern "C" {
void* __libc_malloc(std::size_t);
void* __libc_calloc(std::size_t, std::size_t);
void* __libc_realloc(void*, std::size_t);
void* __libc_memalign(std::size_t, std::size_t);
void __libc_free(void*);
}
#else
#define COUNTS_ALLOCATIONS 0
#endif

namespace {

std::atomic<long> num_allocations{0};
std::atomic<long> live_bytes{0};
std::atomic<long> most_bytes{0};

#if COUNTS_ALLOCATIONS
void* counted(void* memory) {
  ++num_allocations;
  const long now = live_bytes += static_cast<long>(malloc_usable_size(memory));
  if (now > most_bytes) most_bytes = now;  // good enough for one thread that allocates
  return memory;
}
#endif

}  // namespace

#if COUNTS_ALLOCATIONS
extern "C" {
void* malloc(std::size_t size) { return counted(__libc_malloc(size)); }
void* calloc(std::size_t count, std::size_t size) { return counted(__libc_calloc(count, size)); }
void* realloc(void* memory, std::size_t size) {
  if (memory != nullptr) live_bytes -= static_cast<long>(malloc_usable_size(memory));
  return counted(__libc_realloc(memory, size));
}
void* memalign(std::size_t alignment, std::size_t size) {
  return counted(__libc_memalign(alignment, size));
}
void* aligned_alloc(std::size_t alignment, std::size_t size) { return memalign(alignment, size); }
int posix_memalign(void** out, std::size_t alignment, std::size_t size) {
  *out = memalign(alignment, size);
  return *out != nullptr ? 0 : ENOMEM;
}
void free(void* memory) {
  if (memory != nullptr) live_bytes -= static_cast<long>(malloc_usable_size(memory));
  __libc_free(memory);
}
}
#endif

namespace raylign {
namespace {

struct Setting {
  const char* name;
  LinearSolverType type;
  Preconditioner preconditioner = Preconditioner::SCHUR_JACOBI;
  bool explicit_schur = false;
  LossType loss = LossType::TRIVIAL;
  JacobianStorage storage = JacobianStorage::AUTO;
  PointParametrization point = PointParametrization::XYZ;
};

class Allocations : public testing::TestWithParam<Setting> {
 protected:
  void SetUp() override {
    if (COUNTS_ALLOCATIONS == 0) GTEST_SKIP() << "another malloc";
  }
};

TEST_P(Allocations, AreNoneBetweenIterations) {
  const Setting& setting = GetParam();
  BalProblem problem = test::small_problem(8, 2000);
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.point_parametrization = setting.point;
  options.loss = {setting.loss, 1.5};
  options.jacobian_storage = setting.storage;
  options.linear_solver.type = setting.type;
  options.linear_solver.preconditioner = setting.preconditioner;
  options.linear_solver.explicit_schur = setting.explicit_schur;
  options.lm.num_threads = 2;
  options.lm.max_num_iterations = 4;
  options.lm.function_tolerance = 0.0;
  std::vector<long> counts;
  counts.reserve(10);
  const Summary summary = adjust(problem, {}, options, [&](const IterationSummary&) {
    counts.push_back(num_allocations);
    return CallbackAction::CONTINUE;
  });
  ASSERT_EQ(counts.size(), 5u) << summary.message;
  EXPECT_GT(counts[0], 0);
  for (std::size_t i = 1; i < counts.size(); ++i) EXPECT_EQ(counts[i], counts[0]) << "row " << i;
}

INSTANTIATE_TEST_SUITE_P(
    Settings,
    Allocations,
    testing::Values(
        Setting{"auto", LinearSolverType::AUTO},
        Setting{"dense", LinearSolverType::DENSE_SCHUR},
        Setting{"sparse", LinearSolverType::SPARSE_SCHUR},
        Setting{"matrix_free", LinearSolverType::ITERATIVE_SCHUR},
        Setting{"explicit", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::SCHUR_JACOBI, true},
        Setting{"two_level", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::TWO_LEVEL, true},
        Setting{"stale_factor", LinearSolverType::ITERATIVE_SCHUR, Preconditioner::STALE_FACTOR,
                true},
        Setting{"huber", LinearSolverType::DENSE_SCHUR, Preconditioner::SCHUR_JACOBI, false,
                LossType::HUBER},
        Setting{"float", LinearSolverType::DENSE_SCHUR, Preconditioner::SCHUR_JACOBI, false,
                LossType::TRIVIAL, JacobianStorage::FLOAT},
        Setting{"homogeneous", LinearSolverType::DENSE_SCHUR, Preconditioner::SCHUR_JACOBI, false,
                LossType::TRIVIAL, JacobianStorage::AUTO, PointParametrization::HOMOGENEOUS}),
    [](const auto& instance) { return instance.param.name; });

// Everything that a solve takes on top of the problem, at its worst moment.
long bytes_per_observation(const BalProblem& start, const BundleOptions& options) {
  BalProblem problem = start;
  const long before = live_bytes;
  most_bytes = before;
  adjust(problem, {}, options);
  return (most_bytes - before) / start.num_observations();
}

TEST(Memory, IsBoundedByTheObservations) {
  if (COUNTS_ALLOCATIONS == 0) GTEST_SKIP() << "another malloc";
  SyntheticBalOptions scene;
  scene.num_cameras = 30;
  scene.num_points = 5000;
  scene.seed = 5;
  for (const auto kind : {SyntheticBalKind::STREET, SyntheticBalKind::ORBIT}) {
    scene.kind = kind;
    const BalProblem problem = synthetic_bal(scene).problem;
    BundleOptions options;
    options.backend = Backend::NATIVE;
    options.lm.max_num_iterations = 2;
    EXPECT_LE(bytes_per_observation(problem, options), 300);
    options.loss = {LossType::HUBER, 1.0};  // keeps J: 12 doubles
    EXPECT_LE(bytes_per_observation(problem, options), 300 + 96);
    options.jacobian_storage = JacobianStorage::FLOAT;
    EXPECT_LE(bytes_per_observation(problem, options), 300 + 48);
  }
}

}  // namespace
}  // namespace raylign
