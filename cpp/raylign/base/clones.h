// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// RAYLIGN_CLONES before a function: one body, three instruction sets, chosen by the loader
/// (AVX2 + FMA: x86-64-v3, AVX-512: v4). For files of plain loops over raw arrays only: an inline
/// function of a library (Eigen, std algorithms) compiled for AVX-512 here could be the copy that
/// the linker keeps for everybody. What a clone calls must be RAYLIGN_INLINE or it stays SSE2. The
/// sanitizers' start-up does not survive GCC's ifunc resolvers, so there is one body there.
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
#define RAYLIGN_CLONES __attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4")))
#else
#define RAYLIGN_CLONES
#endif

#define RAYLIGN_INLINE __attribute__((always_inline)) static inline
