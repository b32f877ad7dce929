// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/camera/check_params.h"

#include <cmath>
#include <string>

#include "raylign/base/error.h"

namespace raylign {

void require_finite(const char* name, double value) {
  if (std::isfinite(value)) return;
  throw OptionsError(std::string(name) + " must be finite, got " + format_double(value));
}

void require_positive(const char* name, double value) {
  if (std::isfinite(value) && value > 0.0) return;
  throw OptionsError(std::string(name) + " must be > 0 and finite, got " + format_double(value));
}

}  // namespace raylign
