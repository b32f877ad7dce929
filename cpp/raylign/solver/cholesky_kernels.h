// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign {

/// Replaces the lower triangle of the symmetric A (n, n), column-major, by its Cholesky factor L;
/// what stands above the diagonal may be overwritten. False when A is not positive definite or not
/// finite; A is spoilt then. For matrices that the caches hold: no copies, no memory of its own,
/// where LAPACK on OpenBLAS packs panels into megabytes.
bool factor_in_registers(double* A, int n);

/// x ← A⁻¹ x by the factor.
void solve_in_registers(const double* L, int n, double* x);

}  // namespace raylign
