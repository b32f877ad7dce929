// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/camera_graph.h"

namespace raylign::native {

/// The nodes in an order of elimination by approximate minimum degree (Amestoy, Davis & Duff 1996),
/// Eigen's.
std::vector<std::int32_t> minimum_degree(const CameraGraph& graph);

}  // namespace raylign::native
