// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/clones.h"

/// Four doubles at once, for the loops that the compiler, left to itself, transposes. For the files
/// of the kernels alone (base/clones.h).
namespace raylign::native {

using D4 = double __attribute__((vector_size(32)));

RAYLIGN_INLINE void load(const double* p, D4& v) { __builtin_memcpy(&v, p, sizeof(v)); }
RAYLIGN_INLINE void store(const D4& v, double* p) { __builtin_memcpy(p, &v, sizeof(v)); }

}  // namespace raylign::native
