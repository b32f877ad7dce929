// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/blas_threads.h"

#include <dlfcn.h>

#include "raylign/base/shared_setting.h"

namespace raylign {
namespace {

SharedSetting g_blas_threads;

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

ScopedSingleThreadedBlas::ScopedSingleThreadedBlas() {
  g_blas_threads.enter(blas_threads, set_blas_threads, 1);
}

ScopedSingleThreadedBlas::~ScopedSingleThreadedBlas() { g_blas_threads.leave(set_blas_threads); }

}  // namespace raylign
