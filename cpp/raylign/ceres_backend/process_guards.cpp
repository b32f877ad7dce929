// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/process_guards.h"

#include <dlfcn.h>
#include <glog/logging.h>

#include <mutex>

namespace raylign::ceres_backend {
namespace {

/// The one place for mutable static state: it mirrors settings that are static themselves.
class SharedSetting {
 public:
  template <typename Get, typename Set>
  void enter(const Get& get, const Set& set, int value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (num_users_++ > 0) return;
    previous_ = get();
    set(value);
  }

  template <typename Set>
  void leave(const Set& set) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--num_users_ == 0) set(previous_);
  }

 private:
  std::mutex mutex_;
  int num_users_ = 0;
  int previous_ = 0;
};

SharedSetting g_glog_level;
SharedSetting g_blas_threads;

void set_glog_level(int level) { FLAGS_minloglevel = level; }

// Looked up at run time: Debian lets the administrator choose the BLAS behind libblas.so.3.
template <typename Function>
Function* find_symbol(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

int blas_threads() {
  auto* get = find_symbol<int()>("openblas_get_num_threads");
  return get == nullptr ? 1 : get();
}

void set_blas_threads(int count) {
  auto* set = find_symbol<void(int)>("openblas_set_num_threads");
  if (set != nullptr) set(count);
}

}  // namespace

ScopedGlogSilence::ScopedGlogSilence() {
  g_glog_level.enter([] { return FLAGS_minloglevel; }, set_glog_level, google::GLOG_FATAL);
}

ScopedGlogSilence::~ScopedGlogSilence() { g_glog_level.leave(set_glog_level); }

ScopedSingleThreadedBlas::ScopedSingleThreadedBlas() {
  g_blas_threads.enter(blas_threads, set_blas_threads, 1);
}

ScopedSingleThreadedBlas::~ScopedSingleThreadedBlas() { g_blas_threads.leave(set_blas_threads); }

}  // namespace raylign::ceres_backend
