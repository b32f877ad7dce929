// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <optional>
#include <string_view>

#include "raylign/scene/bal_problem.h"

/// Reads the bytes as a BAL file; empty when they are refused, with a proper FormatError.
std::optional<raylign::BalProblem> read_case(std::string_view bytes);

/// Aborts unless an accepted problem is consistent, finite, and survives writing and reading.
void check_accepted(const raylign::BalProblem& problem);
