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
#define RAYLIGN_AVX512 __attribute__((target("arch=x86-64-v4")))
#else
#define RAYLIGN_CLONES
#define RAYLIGN_AVX512
#endif

#define RAYLIGN_INLINE __attribute__((always_inline)) static inline

namespace raylign {

/// Whether a function marked RAYLIGN_AVX512, whose body is written for 64-byte vectors, is there
/// and runs on this machine; the caller has another for where it is not.
inline bool has_avx512() {
#if defined(__x86_64__) && defined(__GNUC__) && !defined(__clang__) && \
    !defined(__SANITIZE_ADDRESS__) && !defined(__SANITIZE_THREAD__)
  static const bool has = __builtin_cpu_supports("x86-64-v4");
  return has;
#else
  return false;
#endif
}

}  // namespace raylign
