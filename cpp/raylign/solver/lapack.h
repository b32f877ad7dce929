// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

extern "C" {
void dpotrf_(const char* uplo, const int* n, double* a, const int* lda, int* info);
void dpotrs_(const char* uplo,
             const int* n,
             const int* nrhs,
             const double* a,
             const int* lda,
             double* b,
             const int* ldb,
             int* info);
}

namespace raylign {

/// x ← A⁻¹ x by the Cholesky factor of A (n, n) in the lower triangle, column-major.
inline void solve_dense(const double* factor, int n, double* x) {
  const int one = 1;
  int info = 0;
  if (n > 0) dpotrs_("L", &n, &one, factor, &n, x, &n, &info);
}

}  // namespace raylign
