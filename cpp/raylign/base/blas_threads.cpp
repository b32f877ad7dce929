// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/blas_threads.h"

#include <dlfcn.h>

namespace raylign {
namespace {

// Looked up at run time: Debian lets the administrator choose the BLAS behind libblas.so.3.
template <typename Function>
Function* find_symbol(const char* name) {
  return reinterpret_cast<Function*>(dlsym(RTLD_DEFAULT, name));
}

}  // namespace

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

}  // namespace raylign
