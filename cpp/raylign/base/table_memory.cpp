// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/table_memory.h"

#include <new>

#ifdef __linux__
#include <sys/mman.h>
#endif

namespace raylign {
namespace {

constexpr std::size_t kHugePage = std::size_t{1} << 21;
// Below this the ends that fill no huge page are most of a table.
constexpr std::size_t kLarge = 4 * kHugePage;

std::align_val_t alignment(std::size_t bytes) {
  return std::align_val_t{bytes < kLarge ? 64 : kHugePage};
}

}  // namespace

void* allocate_table(std::size_t bytes) {
  void* memory = ::operator new(bytes, alignment(bytes));
#ifdef MADV_HUGEPAGE
  // a wish: what the system answers changes nothing but times
  if (bytes >= kLarge) madvise(memory, bytes, MADV_HUGEPAGE);
#endif
  return memory;
}

void free_table(void* memory, std::size_t bytes) noexcept {
  ::operator delete(memory, alignment(bytes));
}

}  // namespace raylign
