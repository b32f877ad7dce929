// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>

#include "raylign/robust/loss.h"
#include "raylign/scene/bundle_scene.h"

namespace raylign {

/// Empty when the cost is finite; else a sentence for people: which observation is to blame, its
/// camera, point and depth.
std::string describe_invalid_start(const BundleScene& scene, const Loss& loss);

}  // namespace raylign
