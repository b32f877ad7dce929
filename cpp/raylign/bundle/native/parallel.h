// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <algorithm>
#include <atomic>
#include <cstdint>
#include <exception>

#include "raylign/base/thread_pool.h"

namespace raylign::native {

/// ThreadPool::run for tasks that take memory: what one of them throws comes out here.
template <typename Task>
void run_tasks(ThreadPool& pool, int num_tasks, const Task& task) {
  std::exception_ptr error;
  std::atomic<bool> failed{false};
  pool.run(num_tasks, [&](int i) {
    try {
      task(i);
    } catch (...) {
      if (!failed.exchange(true)) error = std::current_exception();
    }
  });
  if (error) std::rethrow_exception(error);
}

/// Cuts [0, count) into a range per thread, fewer when there is little to do. For work whose result
/// does not depend on the cut.
class Ranges {
 public:
  Ranges(const ThreadPool& pool, std::int64_t count)
      : count_(count),
        size_(static_cast<int>(
            std::clamp<std::int64_t>(count / kMinPerThread, 1, pool.num_threads()))) {}
  int size() const { return size_; }
  std::int64_t begin(int range) const { return count_ * range / size_; }
  std::int64_t end(int range) const { return begin(range + 1); }

 private:
  static constexpr std::int64_t kMinPerThread = 4096;
  std::int64_t count_;
  int size_;
};

}  // namespace raylign::native
