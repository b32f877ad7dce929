// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/table_memory.h"

#include <gtest/gtest.h>

#include <cstdint>
#include <cstring>
#include <new>

namespace raylign {
namespace {

// Vector kernels load whole cache lines; huge pages begin where a table does.
TEST(TableMemory, IsAlignedByItsSize) {
  constexpr std::size_t kMegabyte = std::size_t{1} << 20;
  for (const std::size_t bytes : {std::size_t{0}, std::size_t{1}, std::size_t{1000},
                                  8 * kMegabyte - 1, 8 * kMegabyte, 33 * kMegabyte + 5}) {
    void* memory = allocate_table(bytes);
    const auto address = reinterpret_cast<std::uintptr_t>(memory);
    EXPECT_EQ(address % (bytes < 8 * kMegabyte ? 64 : 2 * kMegabyte), 0u) << bytes;
    std::memset(memory, 1, bytes);  // all of it is there
    free_table(memory, bytes);
  }
}

TEST(TableMemory, ThrowsWhenThereIsNone) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "the sanitizer ends the process instead";
#endif
  EXPECT_THROW(allocate_table(std::size_t{1} << 60), std::bad_alloc);
}

}  // namespace
}  // namespace raylign
