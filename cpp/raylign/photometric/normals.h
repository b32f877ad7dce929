// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/photometric/hosts.h"
#include "raylign/photometric/state.h"

namespace raylign::photometric {

/// Normals (N, 3) in the host frame from each point's neighbours in its host image: a plane is an
/// inverse depth linear in the pixel, so three numbers are fitted to the inverse depths around a
/// point. NaN where there are too few neighbours, they lie nearly on a line, or they do not lie on
/// a plane. Rows of `given` that are finite are taken as they are.
Rows<double, 3> fit_normals(const PhotometricState& state,
                            const PatchHosts& hosts,
                            const Rows<double, 3>& given);

}  // namespace raylign::photometric
