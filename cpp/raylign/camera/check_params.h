// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

namespace raylign {

/// Throw OptionsError "name must be …, got value": the checks behind every camera's validate().
void require_finite(const char* name, double value);
void require_positive(const char* name, double value);

}  // namespace raylign
