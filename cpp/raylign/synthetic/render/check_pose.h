// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"

namespace raylign {

/// Throws OptionsError unless T = [R t; 0 1] with a rotation R, to 1e-6.
void require_rigid(const char* name, const Matrix4& T);

}  // namespace raylign
