// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstddef>
#include <memory>
#include <new>
#include <utility>
#include <vector>

#include "raylign/base/table_memory.h"

namespace raylign::native {

/// Memory for tables that a pass fills before anybody reads them: left as it comes instead of
/// cleared, so that the pass is the first to touch it.
template <typename T>
struct TableAllocator {
  using value_type = T;

  TableAllocator() = default;
  template <typename U>
  TableAllocator(const TableAllocator<U>& /*other*/) {}  // NOLINT: allocators convert

  T* allocate(std::size_t count) {
    if (count > static_cast<std::size_t>(-1) / sizeof(T)) throw std::bad_alloc();
    return static_cast<T*>(allocate_table(count * sizeof(T)));
  }
  void deallocate(T* memory, std::size_t count) { free_table(memory, count * sizeof(T)); }

  template <typename U>
  void construct(U* place) {
    ::new (static_cast<void*>(place)) U;  // not U(): no zeros
  }
  template <typename U, typename... Arguments>
  void construct(U* place, Arguments&&... arguments) {
    ::new (static_cast<void*>(place)) U(std::forward<Arguments>(arguments)...);
  }

  bool operator==(const TableAllocator& /*other*/) const { return true; }
  bool operator!=(const TableAllocator& /*other*/) const { return false; }
};

/// A vector whose `resize` leaves new elements unset.
template <typename T>
using Table = std::vector<T, TableAllocator<T>>;

}  // namespace raylign::native
