// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/ceres_backend/process_guards.h"

#include <glog/logging.h>

#include "raylign/base/shared_setting.h"

namespace raylign::ceres_backend {
namespace {

SharedSetting g_glog_level;

void set_glog_level(int level) { FLAGS_minloglevel = level; }

}  // namespace

ScopedGlogSilence::ScopedGlogSilence() {
  g_glog_level.enter([] { return FLAGS_minloglevel; }, set_glog_level, google::GLOG_FATAL);
}

ScopedGlogSilence::~ScopedGlogSilence() { g_glog_level.leave(set_glog_level); }

}  // namespace raylign::ceres_backend
