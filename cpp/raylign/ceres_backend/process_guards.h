// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign::ceres_backend {

/// Keeps glog, and with it Ceres, off the user's stderr while it lives. glog's level is a
/// process-wide setting, so it is put back.
class ScopedGlogSilence {
 public:
  ScopedGlogSilence();
  ~ScopedGlogSilence();
  ScopedGlogSilence(const ScopedGlogSilence&) = delete;
  ScopedGlogSilence& operator=(const ScopedGlogSilence&) = delete;

 private:
  int previous_level_;
};

}  // namespace raylign::ceres_backend
