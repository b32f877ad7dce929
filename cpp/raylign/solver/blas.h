// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// The routines of BLAS that our Cholesky factors call (Dongarra et al. 1988, 1990).
extern "C" {
void dtrsm_(const char* side,
            const char* uplo,
            const char* transposed,
            const char* diagonal,
            const int* m,
            const int* n,
            const double* alpha,
            const double* a,
            const int* lda,
            double* b,
            const int* ldb);
void dgemm_(const char* transposed_a,
            const char* transposed_b,
            const int* m,
            const int* n,
            const int* k,
            const double* alpha,
            const double* a,
            const int* lda,
            const double* b,
            const int* ldb,
            const double* beta,
            double* c,
            const int* ldc);
void dtrsv_(const char* uplo,
            const char* transposed,
            const char* diagonal,
            const int* n,
            const double* a,
            const int* lda,
            double* x,
            const int* incx);
void dgemv_(const char* transposed,
            const int* m,
            const int* n,
            const double* alpha,
            const double* a,
            const int* lda,
            const double* x,
            const int* incx,
            const double* beta,
            double* y,
            const int* incy);
}
