// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/thread_pool.h"

namespace raylign {

ThreadPool::ThreadPool(int num_threads) {
  for (int i = 1; i < num_threads; ++i) workers_.emplace_back([this] { work(); });
}

ThreadPool::~ThreadPool() {
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    stop_ = true;
  }
  start_.notify_all();
  for (std::thread& worker : workers_) worker.join();
}

void ThreadPool::run_erased(int num_tasks, Call call, const void* task) {
  if (workers_.empty() || num_tasks <= 1) {
    for (int i = 0; i < num_tasks; ++i) call(task, i);
    return;
  }
  {
    const std::lock_guard<std::mutex> lock(mutex_);
    call_ = call;
    task_ = task;
    num_tasks_ = num_tasks;
    num_busy_ = static_cast<int>(workers_.size());
    next_ = 0;
    ++generation_;
  }
  start_.notify_all();
  take_tasks();
  std::unique_lock<std::mutex> lock(mutex_);
  done_.wait(lock, [this] { return num_busy_ == 0; });
}

void ThreadPool::work() {
  unsigned seen = 0;
  std::unique_lock<std::mutex> lock(mutex_);
  while (true) {
    start_.wait(lock, [&] { return stop_ || generation_ != seen; });
    if (stop_) return;
    seen = generation_;
    lock.unlock();
    take_tasks();
    lock.lock();
    if (--num_busy_ == 0) done_.notify_one();
  }
}

void ThreadPool::take_tasks() {
  for (int i = next_.fetch_add(1); i < num_tasks_; i = next_.fetch_add(1)) call_(task_, i);
}

}  // namespace raylign
