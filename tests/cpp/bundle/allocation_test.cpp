// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Counts the allocations of the whole process: a program of its own.
#include <gtest/gtest.h>

#include <atomic>
#include <cstdlib>
#include <new>

#include "raylign/bundle/bundle_adjuster.h"
#include "support/small_problem.h"

namespace {
std::atomic<long> num_allocations{0};

void* counted(std::size_t size, std::size_t alignment) {
  ++num_allocations;
  void* memory = nullptr;
  if (posix_memalign(&memory, alignment, size) != 0) throw std::bad_alloc();
  return memory;
}
}  // namespace

void* operator new(std::size_t size) { return counted(size, alignof(std::max_align_t)); }
void* operator new(std::size_t size, std::align_val_t alignment) {
  return counted(size, static_cast<std::size_t>(alignment));
}
void operator delete(void* memory) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::align_val_t) noexcept { std::free(memory); }
void operator delete(void* memory, std::size_t, std::align_val_t) noexcept { std::free(memory); }

namespace raylign {
namespace {

TEST(Native, AllocatesNothingBetweenIterations) {
  BalProblem problem = test::small_problem(8, 2000);
  BundleOptions options;
  options.backend = Backend::NATIVE;
  options.lm.num_threads = 2;
  options.lm.max_num_iterations = 3;
  options.lm.function_tolerance = 0.0;
  std::vector<long> counts;
  counts.reserve(10);
  const Summary summary = adjust(problem, {}, options, [&](const IterationSummary&) {
    counts.push_back(num_allocations);
    return CallbackAction::CONTINUE;
  });
  ASSERT_EQ(counts.size(), 4u);
  for (std::size_t i = 1; i < counts.size(); ++i) EXPECT_EQ(counts[i], counts[0]) << "row " << i;
}

}  // namespace
}  // namespace raylign
