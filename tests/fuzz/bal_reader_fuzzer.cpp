// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause

// Any bytes are either one FormatError or a problem that is consistent, finite, and survives
// writing and reading bit by bit. Everything else (another exception, a sanitizer report) ends the
// process.
#include "bal_reader_case.h"

#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstdlib>
#include <string_view>

#include "raylign/base/error.h"
#include "raylign/io/bal.h"
#include "raylign/scene/bal_statistics.h"
#include "raylign/scene/bal_transform.h"

namespace {

using raylign::BalProblem;
using raylign::DuplicatePolicy;

void require(bool condition, const char* what) {
  if (condition) return;
  std::fprintf(stderr, "violated: %s\n", what);
  std::abort();
}

DuplicatePolicy policy_for(std::string_view bytes) {
  constexpr DuplicatePolicy kPolicies[] = {DuplicatePolicy::ERROR, DuplicatePolicy::FIRST,
                                           DuplicatePolicy::MEAN, DuplicatePolicy::KEEP};
  return kPolicies[(bytes.empty() ? 0 : static_cast<unsigned char>(bytes.back())) % 4];
}

}  // namespace

void check_accepted(const BalProblem& problem) {
  problem.validate();
  require(problem.num_cameras() > 0 && problem.num_points() > 0 && problem.num_observations() > 0,
          "an accepted problem has cameras, points and observations");
  require(
      problem.cameras.allFinite() && problem.points.allFinite() && problem.observations.allFinite(),
      "an accepted problem is finite");
  const BalProblem again =
      raylign::parse_bal(raylign::format_bal(problem), "<again>", DuplicatePolicy::KEEP);
  require(again == problem, "what is written is read back bit by bit");
  const raylign::ProblemStatistics statistics = raylign::statistics(problem);
  require(statistics.num_observations == problem.num_observations(), "statistics count right");
  raylign::normalize(problem);
}

std::optional<BalProblem> read_case(std::string_view bytes) {
  try {
    return raylign::parse_bal(bytes, "<fuzz>", policy_for(bytes));
  } catch (const raylign::FormatError& error) {
    require(error.file() == "<fuzz>", "an error names its file");
    require(error.line() >= 0 && !error.reason().empty(), "an error gives line and reason");
    return std::nullopt;
  }
}

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  const auto problem = read_case({reinterpret_cast<const char*>(data), size});
  if (problem) check_accepted(*problem);
  return 0;
}
