// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/solver/options.h"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <string>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/summary.h"

namespace raylign {
namespace {

std::string message_of(const std::function<void()>& action) {
  try {
    action();
  } catch (const OptionsError& error) {
    return error.what();
  }
  return "";
}

TEST(LmOptions, DefaultsAreValid) {
  EXPECT_NO_THROW(LmOptions{}.validate());
  EXPECT_NO_THROW(LinearSolverOptions{}.validate());
  EXPECT_NO_THROW(BundleOptions{}.validate());
}

TEST(LmOptions, EveryFieldIsCheckedAndNamed) {
  const std::vector<std::pair<std::string, std::function<void(LmOptions&)>>> cases = {
      {"max_num_iterations", [](LmOptions& o) { o.max_num_iterations = -1; }},
      {"max_solver_time_s", [](LmOptions& o) { o.max_solver_time_s = 0.0; }},
      {"function_tolerance", [](LmOptions& o) { o.function_tolerance = NAN; }},
      {"gradient_tolerance", [](LmOptions& o) { o.gradient_tolerance = -1e-9; }},
      {"parameter_tolerance", [](LmOptions& o) { o.parameter_tolerance = NAN; }},
      {"initial_lambda", [](LmOptions& o) { o.initial_lambda = 0.0; }},
      {"initial_lambda", [](LmOptions& o) { o.max_lambda = o.initial_lambda; }},
      {"min_lambda", [](LmOptions& o) { o.min_lambda = -1.0; }},
      {"max_lambda", [](LmOptions& o) { o.max_lambda = 1e-20; }},
      {"min_relative_decrease", [](LmOptions& o) { o.min_relative_decrease = 1.0; }},
      {"min_diagonal", [](LmOptions& o) { o.min_diagonal = 0.0; }},
      {"max_diagonal", [](LmOptions& o) { o.max_diagonal = 1e-9; }},
      {"max_num_consecutive_invalid_steps",
       [](LmOptions& o) { o.max_num_consecutive_invalid_steps = 0; }},
      {"num_threads", [](LmOptions& o) { o.num_threads = 0; }},
  };
  for (const auto& [field, spoil] : cases) {
    LmOptions options;
    spoil(options);
    const std::string message = message_of([&] { options.validate(); });
    EXPECT_NE(message.find("LmOptions." + field + " must be"), std::string::npos)
        << field << ": '" << message << "'";
  }
}

TEST(LinearSolverOptions, RefusesWhatCeresWouldAbortOn) {
  LinearSolverOptions options;
  options.type = LinearSolverType::SPARSE_SCHUR;
  options.explicit_schur = true;
  EXPECT_NE(message_of([&] { options.validate(); }).find("explicit_schur"), std::string::npos);
  options = {};
  options.forcing_tolerance = 1.0;
  EXPECT_NE(message_of([&] { options.validate(); }).find("forcing_tolerance"), std::string::npos);
  options = {};
  options.max_num_iterations = 0;
  EXPECT_NE(message_of([&] { options.validate(); }).find("max_num_iterations"), std::string::npos);
}

TEST(BundleConfig, NamesTheFieldAndTheIndex) {
  BundleConfig config;
  config.constant_cameras = {0, 3};
  EXPECT_NO_THROW(config.validate(4, 10));
  EXPECT_EQ(message_of([&] { config.validate(3, 10); }),
            "BundleConfig.constant_cameras must hold indices in [0, 3), got 3");
  config = {};
  config.constant_coordinates = {{ParameterKind::POSE, 0, "k1"}};
  EXPECT_EQ(
      message_of([&] { config.validate(3, 10); }),
      "ConstantCoordinate.coordinate of kind pose must be one of tx, ty, tz, rotation, got 'k1'");
  config.constant_coordinates = {{ParameterKind::POINT, 10, "z"}};
  EXPECT_THROW(config.validate(3, 10), OptionsError);
  EXPECT_NO_THROW(config.validate(3, 11));
}

TEST(Summary, StartsWithImpossibleValues) {
  const Summary summary;
  EXPECT_EQ(summary.termination, Termination::NOT_RUN);
  EXPECT_EQ(summary.final_cost, -1.0);
  EXPECT_FALSE(summary.is_usable());
  EXPECT_NE(summary.brief_report().find("not_run"), std::string::npos);
}

TEST(Summary, IsUsableUnlessItFailed) {
  Summary summary;
  for (const auto good : {Termination::CONVERGENCE, Termination::MAX_ITERATIONS,
                          Termination::TIME_LIMIT, Termination::USER_STOPPED}) {
    summary.termination = good;
    EXPECT_TRUE(summary.is_usable());
  }
  summary.termination = Termination::FAILURE;
  summary.message = "the start is invalid";
  EXPECT_FALSE(summary.is_usable());
  EXPECT_EQ(summary.brief_report(), "failure: the start is invalid");  // no costs of −1
  EXPECT_EQ(summary.full_report(), "failure: the start is invalid\n");
}

}  // namespace
}  // namespace raylign
