// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/photometric/result.h"
#include "raylign/photometric/views.h"

namespace raylign::photometric {

/// Fills statuses, residuals and shifts of the result from the views at the start and at the end,
/// both on level 0.
/// @param held  (N,) points that the config holds
void report_views(const Setting& setting,
                  const Views& start,
                  const Views& end,
                  const std::vector<bool>& held,
                  PhotometricResult& result);

}  // namespace raylign::photometric
