// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/patch_reader.h"
#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// What the grey values say: marks edges as MISMATCH, sets the status of the points, and edges of
/// points that are not used to NOT_USED.
void judge(const Setting& setting, const PatchSources& sources, Views& views);

}  // namespace raylign::photometric
