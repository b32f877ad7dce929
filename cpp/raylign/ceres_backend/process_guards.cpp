// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/process_guards.h"

#include <glog/logging.h>

namespace raylign::ceres_backend {

ScopedGlogSilence::ScopedGlogSilence() : previous_level_(FLAGS_minloglevel) {
  FLAGS_minloglevel = google::GLOG_FATAL;
}

ScopedGlogSilence::~ScopedGlogSilence() { FLAGS_minloglevel = previous_level_; }

}  // namespace raylign::ceres_backend
