// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What stands in for camera_ordering.cpp in a build without CHOLMOD.
#include "raylign/bundle/native/camera_ordering.h"

namespace raylign::native {

bool has_sparse_cholesky() { return false; }

SparseOrdering order_cameras(const SchurPattern&) { return {}; }

}  // namespace raylign::native
