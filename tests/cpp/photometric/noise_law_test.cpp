// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/noise_law.h"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

#include "raylign/base/error.h"
#include "support/named_rng.h"

namespace raylign::test {
namespace {

constexpr int kSamples = 200000;

std::vector<float> student_t(double nu, double scale, int count = kSamples) {
  NamedRng rng = make_rng("student_t", static_cast<std::uint64_t>(100 * nu));
  std::student_t_distribution<double> law(nu);
  std::vector<float> values(static_cast<std::size_t>(count));
  for (float& value : values) value = static_cast<float>(scale * law(rng.engine()));
  return values;
}

std::vector<float> normal(double sigma) {
  NamedRng rng = make_rng("normal");
  std::vector<float> values(kSamples);
  for (float& value : values) value = static_cast<float>(rng.normal(sigma));
  return values;
}

TEST(NoiseLaw, FindsTheParametersOfStudentsT) {
  for (const double nu : {1.0, 2.0, 5.0, 10.0}) {
    const NoiseLaw law = fit_noise_law(student_t(nu, 4.75));
    EXPECT_NEAR(law.nu / nu, 1.0, 0.12) << nu;  // a step of the grid
    EXPECT_NEAR(law.t_scale / 4.75, 1.0, 0.02) << nu;
    EXPECT_EQ(law.num_residuals, kSamples);
  }
}

TEST(NoiseLaw, NormalNoiseIsTheLimitOfLargeNu) {
  const NoiseLaw law = fit_noise_law(normal(2.0));
  EXPECT_NEAR(law.sigma, 2.0, 0.02);
  EXPECT_GT(law.nu, 25.0);
  EXPECT_NEAR(law.variance(), 4.0, 0.1);
  // −½ log(2π e σ²), the entropy of a normal law.
  EXPECT_NEAR(law.log_likelihood, -0.5 * std::log(2.0 * M_PI * M_E * 4.0), 0.01);
}

TEST(NoiseLaw, SigmaIsTheNormalOneWhateverTheTails) {
  std::vector<float> values = normal(3.0);
  for (std::size_t i = 0; i < values.size(); i += 10) values[i] = 200.0f;  // 10 % outliers
  const NoiseLaw law = fit_noise_law(values);
  EXPECT_NEAR(law.sigma, 3.0, 0.5);
  EXPECT_LT(law.nu, 4.0);
}

TEST(NoiseLaw, LikelihoodIsThatOfTheSamples) {
  const std::vector<float> values = student_t(5.0, 2.0, 20000);
  const NoiseLaw law = fit_noise_law(values);
  double sum = 0.0;
  for (const double r : values) {
    sum += std::lgamma(0.5 * (law.nu + 1.0)) - std::lgamma(0.5 * law.nu) -
           0.5 * std::log(law.nu * M_PI) - std::log(law.t_scale) -
           0.5 * (law.nu + 1.0) * std::log1p(r * r / (law.nu * law.t_scale * law.t_scale));
  }
  EXPECT_NEAR(law.log_likelihood, sum / double(values.size()), 1e-4);
}

TEST(NoiseLaw, NoOtherParametersAreMoreLikely) {
  const std::vector<float> values = student_t(3.0, 2.0, 20000);
  const NoiseLaw law = fit_noise_law(values);
  for (const double nu : {0.8 * law.nu, 1.25 * law.nu}) {
    EXPECT_LT(fit_noise_law(values, {0.0, nu}).log_likelihood, law.log_likelihood) << nu;
  }
}

TEST(NoiseLaw, HeldNuIsKeptAndItsScaleFitted) {
  const NoiseLaw law = fit_noise_law(student_t(2.0, 3.0), {0.0, 2.0});
  EXPECT_EQ(law.nu, 2.0);
  EXPECT_NEAR(law.t_scale, 3.0, 0.05);
}

TEST(NoiseLaw, VarianceIsThatOfTheMostLikelyLocation) {
  // The location of samples of t by its score, one step from the true one: mean ψ / mean ψ′.
  const double nu = 3.0;
  const double scale = 2.0;
  constexpr int kPerEstimate = 100;
  const std::vector<float> values = student_t(nu, scale);
  double squares = 0.0;
  const int estimates = kSamples / kPerEstimate;
  for (int i = 0; i < estimates; ++i) {
    double location = 0.0;
    for (int pass = 0; pass < 20; ++pass) {
      double sum = 0.0;
      double weights = 0.0;
      for (int k = 0; k < kPerEstimate; ++k) {
        const double r = values[static_cast<std::size_t>(i * kPerEstimate + k)] - location;
        const double weight = 1.0 / (nu * scale * scale + r * r);
        sum += weight * r;
        weights += weight;
      }
      location += sum / weights;
    }
    squares += location * location;
  }
  const NoiseLaw law = {scale, scale, nu, 0.0, kSamples};
  EXPECT_NEAR(squares / estimates * kPerEstimate / law.variance(), 1.0, 0.1);
}

TEST(NoiseLaw, HasAFloor) {
  const std::vector<float> exact(1000, 0.0f);
  EXPECT_EQ(fit_noise_law(exact).sigma, 0.5);
  EXPECT_EQ(fit_noise_law(exact).t_scale, 0.5);
  EXPECT_EQ(fit_noise_law(exact, {1.5}).sigma, 1.5);
  const NoiseLaw nothing = fit_noise_law({});
  EXPECT_EQ(nothing.sigma, 0.5);
  EXPECT_EQ(nothing.num_residuals, 0);
}

TEST(NoiseLaw, OrderAndWhatIsNotFiniteDoNotMatter) {
  std::vector<float> values = student_t(2.0, 3.0, 5001);
  const NoiseLaw law = fit_noise_law(values);
  values.push_back(std::numeric_limits<float>::quiet_NaN());
  values.push_back(std::numeric_limits<float>::infinity());
  const NoiseLaw same = fit_noise_law(values);
  EXPECT_EQ(law.t_scale, same.t_scale);
  EXPECT_EQ(law.nu, same.nu);
  EXPECT_EQ(same.num_residuals, 5001);
  std::sort(values.begin(), values.begin() + 5001);
  EXPECT_NEAR(fit_noise_law(values).t_scale, law.t_scale, 1e-9);
}

TEST(NoiseLaw, ThresholdsAreMultiplesOfSigma) {
  const NoiseLaw law = {7.0, 4.75, 1.0, 0.0, 100};
  const auto scale = [&](LossType type, LossScope scope, int n) {
    return noise_loss(law, type, scope, n).scale;
  };
  EXPECT_DOUBLE_EQ(scale(LossType::HUBER, LossScope::PIXEL, 16), 1.345 * 7.0);
  EXPECT_DOUBLE_EQ(scale(LossType::CAUCHY, LossScope::PIXEL, 16), 2.385 * 7.0);
  // χ²(0.95): 26.296 of 16 degrees of freedom, 15.507 of 8, 3.841 of 1.
  EXPECT_NEAR(scale(LossType::HUBER, LossScope::PATCH, 16), std::sqrt(26.296) * 7.0, 0.007);
  EXPECT_NEAR(scale(LossType::HUBER, LossScope::PATCH, 8), std::sqrt(15.507) * 7.0, 0.02);
  EXPECT_NEAR(scale(LossType::HUBER, LossScope::PATCH, 1), std::sqrt(3.841) * 7.0, 0.2);
  const Loss t = noise_loss(law, LossType::STUDENT_T, LossScope::PIXEL, 16);
  EXPECT_EQ(t.scale, 4.75);
  EXPECT_EQ(t.degrees_of_freedom, 1.0);
  EXPECT_EQ(noise_loss(law, LossType::TRIVIAL, LossScope::PIXEL, 16).type, LossType::TRIVIAL);
  EXPECT_THROW(noise_loss(law, LossType::TUKEY, LossScope::PIXEL, 16), OptionsError);
}

TEST(NoiseLaw, RefusesBadOptions) {
  EXPECT_THROW(fit_noise_law({}, {-1.0, 0.0}), OptionsError);
  EXPECT_THROW(fit_noise_law({}, {0.0, -1.0}), OptionsError);
}

}  // namespace
}  // namespace raylign::test
