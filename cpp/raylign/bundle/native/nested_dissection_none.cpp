// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What stands in for nested_dissection.cpp in a build without CHOLMOD.
#include "raylign/bundle/native/nested_dissection.h"

namespace raylign::native {

std::vector<std::int32_t> nested_dissection(const CameraGraph& /*graph*/) { return {}; }

}  // namespace raylign::native
