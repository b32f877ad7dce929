// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <atomic>
#include <condition_variable>
#include <mutex>
#include <thread>
#include <vector>

namespace raylign {

/// Threads that share numbered tasks. A result is the same for any number of threads as long as
/// task i writes only what belongs to i: which thread runs it, and when, is left open. Tasks must
/// not throw. One thread may call `run` at a time.
class ThreadPool {
 public:
  /// @param num_threads >= 1, the calling thread included: 1 starts none.
  explicit ThreadPool(int num_threads);
  ~ThreadPool();
  ThreadPool(const ThreadPool&) = delete;
  ThreadPool& operator=(const ThreadPool&) = delete;

  int num_threads() const { return static_cast<int>(workers_.size()) + 1; }

  /// Calls task(i) for each i in [0, num_tasks) and returns when all are done. Allocates nothing.
  template <typename Task>
  void run(int num_tasks, const Task& task) {
    run_erased(num_tasks, [](const void* f, int i) { (*static_cast<const Task*>(f))(i); }, &task);
  }

 private:
  using Call = void (*)(const void* task, int index);

  void run_erased(int num_tasks, Call call, const void* task);
  void work();
  void take_tasks();

  std::vector<std::thread> workers_;
  std::mutex mutex_;
  std::condition_variable start_, done_;
  Call call_ = nullptr;
  const void* task_ = nullptr;
  int num_tasks_ = 0;
  int num_busy_ = 0;
  unsigned generation_ = 0;
  bool stop_ = false;
  std::atomic<int> next_{0};
};

}  // namespace raylign
