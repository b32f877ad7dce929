// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

/// Two settings of the whole process that a solve changes for its time. Solves may overlap in
/// several threads: the first guard in saves and sets, the last one out restores.
namespace raylign::ceres_backend {

/// Keeps glog, and with it Ceres, off the user's stderr while it lives.
class ScopedGlogSilence {
 public:
  ScopedGlogSilence();
  ~ScopedGlogSilence();
  ScopedGlogSilence(const ScopedGlogSilence&) = delete;
  ScopedGlogSilence& operator=(const ScopedGlogSilence&) = delete;
};

}  // namespace raylign::ceres_backend
