// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <cstdint>
#include <vector>

#include "raylign/bundle/native/camera_graph.h"

namespace raylign::native {

/// The nodes in an order of elimination by nested dissection (METIS, through CHOLMOD). Empty where
/// it finds none, and in a build without CHOLMOD (CMake option RAYLIGN_USE_CHOLMOD).
std::vector<std::int32_t> nested_dissection(const CameraGraph& graph);

}  // namespace raylign::native
