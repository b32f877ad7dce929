// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Throws ShapeError when no point is in view of two images (of one besides its host), with what
/// the numbers suggest. Returns sentences about what looks odd but can be solved.
std::vector<std::string> check_start(const Setting& setting, const PhotometricState& start);

}  // namespace raylign::photometric
