// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>

namespace raylign {

/// Uninitialised memory for a table, aligned to a cache line. Large tables are aligned to huge
/// pages and the system is asked for such, where it knows them: passes that jump about in hundreds
/// of megabytes otherwise wait for page tables. Throws std::bad_alloc.
void* allocate_table(std::size_t bytes);

/// `bytes`: as it was allocated.
void free_table(void* memory, std::size_t bytes) noexcept;

}  // namespace raylign
