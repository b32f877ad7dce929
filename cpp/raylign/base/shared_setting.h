// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <mutex>

namespace raylign {

/// A setting of the whole process that solves change for their time. Solves may overlap in several
/// threads: the first one in saves and sets, the last one out restores. The one use of mutable
/// static state: it mirrors settings that are static themselves.
class SharedSetting {
 public:
  template <typename Get, typename Set>
  void enter(const Get& get, const Set& set, int value) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (num_users_++ > 0) return;
    previous_ = get();
    set(value);
  }

  template <typename Set>
  void leave(const Set& set) {
    const std::lock_guard<std::mutex> lock(mutex_);
    if (--num_users_ == 0) set(previous_);
  }

 private:
  std::mutex mutex_;
  int num_users_ = 0;
  int previous_ = 0;
};

}  // namespace raylign
