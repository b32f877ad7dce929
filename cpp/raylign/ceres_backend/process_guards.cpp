// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/process_guards.h"

#include <dlfcn.h>
#include <glog/logging.h>

namespace raylign::ceres_backend {
namespace {

// Looked up at run time: Debian lets the administrator choose the BLAS behind libblas.so.3.
template <typename Function>
Function* find_symbol(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

ScopedGlogSilence::ScopedGlogSilence() : previous_level_(FLAGS_minloglevel) {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

ScopedGlogSilence::~ScopedGlogSilence() { FLAGS_minloglevel = previous_level_; }

ScopedSingleThreadedBlas::ScopedSingleThreadedBlas() {
  auto* get = find_symbol<int()>("openblas_get_num_threads");
  auto* set = find_symbol<void(int)>("openblas_set_num_threads");
  if (get == nullptr || set == nullptr) return;
  previous_threads_ = get();
  set(1);
}

ScopedSingleThreadedBlas::~ScopedSingleThreadedBlas() {
  auto* set = find_symbol<void(int)>("openblas_set_num_threads");
  if (set != nullptr && previous_threads_ > 0) set(previous_threads_);
}

}  // namespace raylign::ceres_backend
