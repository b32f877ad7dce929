// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/thread_pool.h"

namespace raylign {

/// Replaces the lower triangle of the symmetric A (n, n), column-major, by its Cholesky factor L;
/// what stands above the diagonal does not matter and may be overwritten. False when A is not
/// positive definite or not finite; A is spoilt then. factor_in_registers below kMinBlocked
/// columns; from there on right-looking by panels, whose updates the threads share. The cut depends
/// on n alone and every number is computed in one call, so the bits do not depend on the number of
/// threads. BLAS must run on one thread (ScopedSingleThreadedBlas).
bool factor_cholesky(double* A, int n, ThreadPool& pool);

inline constexpr int kMinBlocked = 900;

}  // namespace raylign
