// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/robust/loss.h"

#include <ceres/loss_function.h>
#include <gtest/gtest.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <memory>

#include "raylign/base/error.h"
#include "support/numeric_jacobian.h"

namespace raylign::test {
namespace {

using Scalar = Eigen::Matrix<double, 1, 1>;

const std::vector<double>& scales() {
  static const std::vector<double> values = {0.1, 1.0, 2.5};
  return values;
}

class LossTest : public testing::TestWithParam<LossType> {
 protected:
  Loss loss(double scale) const { return {GetParam(), scale, 4.0}; }
};

std::string name_of(const testing::TestParamInfo<LossType>& info) { return to_string(info.param); }
INSTANTIATE_TEST_SUITE_P(All, LossTest, testing::ValuesIn(all_loss_types()), name_of);

TEST_P(LossTest, StartsAsLeastSquares) {
  for (const double scale : scales()) {
    const LossValue value = loss(scale).evaluate(0.0);
    EXPECT_EQ(value.rho, 0.0);
    EXPECT_EQ(value.d_rho, 1.0);
    // Relative accuracy where ρ(s) = s − O(s²): no cancellation.
    EXPECT_NEAR(loss(scale).evaluate(1e-14).rho / 1e-14, 1.0, 1e-11);
  }
}

TEST_P(LossTest, DerivativesAgreeWithDifferences) {
  for (const double scale : scales()) {
    const Loss law = loss(scale);
    for (const double x : {0.05, 0.5, 0.9, 1.2, 4.0, 50.0}) {
      const double s = x * scale * scale;
      const auto rho = [&](const Scalar& v) { return Scalar(law.evaluate(v[0]).rho); };
      const auto d_rho = [&](const Scalar& v) { return Scalar(law.evaluate(v[0]).d_rho); };
      const LossValue value = law.evaluate(s);
      const double h = 0.04 * s;
      EXPECT_NEAR(value.d_rho, numeric_jacobian(rho, Scalar(s), h)(0, 0), 1e-9) << x;
      const double d2 = numeric_jacobian(d_rho, Scalar(s), h)(0, 0);
      EXPECT_NEAR(value.d2_rho, d2, 1e-8 * std::max(1.0, std::abs(d2))) << x;
    }
  }
}

TEST_P(LossTest, GrowsAndNeverFasterThanLeastSquares) {
  for (const double scale : scales()) {
    LossValue previous = loss(scale).evaluate(0.0);
    for (double s = 0.01; s < 1e6; s *= 1.1) {
      const LossValue value = loss(scale).evaluate(s);
      EXPECT_GE(value.rho, previous.rho * (1.0 - 1e-15));
      EXPECT_LE(value.rho, s);
      EXPECT_GE(value.d_rho, 0.0);
      EXPECT_LE(value.d_rho, previous.d_rho);
      EXPECT_LE(value.d2_rho, 0.0);
      previous = value;
    }
  }
}

TEST_P(LossTest, InfluenceOfAnOutlier) {
  const double s = 1e12;
  const double influence = loss(1.0).evaluate(s).d_rho * std::sqrt(s);  // ∝ |dρ/dr|
  switch (GetParam()) {
    case LossType::TRIVIAL:
      EXPECT_EQ(influence, 1e6);
      break;
    case LossType::HUBER:
    case LossType::SOFT_L1:
      EXPECT_NEAR(influence, 1.0, 1e-6);
      break;
    case LossType::TUKEY:
      EXPECT_EQ(influence, 0.0);
      EXPECT_DOUBLE_EQ(loss(3.0).evaluate(s).rho, 3.0);
      break;
    default:
      EXPECT_LT(influence, 1e-5);
      EXPECT_GT(influence, 0.0);
  }
}

TEST_P(LossTest, NanComesOutAndIsNotCalledAnOutlier) {
  EXPECT_TRUE(std::isnan(loss(1.0).evaluate(std::numeric_limits<double>::quiet_NaN()).rho));
}

TEST_P(LossTest, TextRoundTrip) {
  const Loss law = parse_loss(to_string(GetParam()) + ":2.5");
  EXPECT_EQ(law.type, GetParam());
  EXPECT_EQ(law.scale, 2.5);
  EXPECT_EQ(law.degrees_of_freedom, 5.0);
  EXPECT_EQ(parse_loss(to_string(GetParam())).scale, 1.0);
}

std::unique_ptr<ceres::LossFunction> ceres_loss(LossType type, double a) {
  switch (type) {
    case LossType::TRIVIAL:
      return std::make_unique<ceres::TrivialLoss>();
    case LossType::HUBER:
      return std::make_unique<ceres::HuberLoss>(a);
    case LossType::SOFT_L1:
      return std::make_unique<ceres::SoftLOneLoss>(a);
    case LossType::CAUCHY:
      return std::make_unique<ceres::CauchyLoss>(a);
    case LossType::ARCTAN:
      return std::make_unique<ceres::ArctanLoss>(a * a);
    case LossType::TUKEY:
      return std::make_unique<ceres::TukeyLoss>(a);
    default:
      return nullptr;
  }
}

class CeresLossTest : public LossTest {};
INSTANTIATE_TEST_SUITE_P(InCeres,
                         CeresLossTest,
                         testing::Values(LossType::TRIVIAL,
                                         LossType::HUBER,
                                         LossType::SOFT_L1,
                                         LossType::CAUCHY,
                                         LossType::ARCTAN,
                                         LossType::TUKEY),
                         name_of);

TEST_P(CeresLossTest, AgreesWithCeres) {
  for (const double scale : scales()) {
    const auto reference = ceres_loss(GetParam(), scale);
    for (double s = 1e-6; s < 1e6; s *= 1.7) {
      double rho[3];
      reference->Evaluate(s, rho);
      const LossValue value = loss(scale).evaluate(s);
      EXPECT_NEAR(value.rho, rho[0], 1e-14 * std::max(1.0, rho[0])) << s;
      EXPECT_NEAR(value.d_rho, rho[1], 1e-14) << s;
      EXPECT_NEAR(value.d2_rho, rho[2], 1e-13 * std::max(1.0, std::abs(rho[2]))) << s;
    }
  }
}

TEST(Loss, StudentTTendsToLeastSquaresAndCauchy) {
  const double s = 3.0;
  EXPECT_NEAR((Loss{LossType::STUDENT_T, 1.0, 1e9}.evaluate(s).rho), s, 1e-8);
  EXPECT_DOUBLE_EQ((Loss{LossType::STUDENT_T, 1.5, 1.0}.evaluate(s).rho),
                   (Loss{LossType::CAUCHY, 1.5}.evaluate(s).rho));
}

TEST(ParseLoss, ReadsAllFields) {
  const Loss law = parse_loss("student_t:0.5:7");
  EXPECT_EQ(law.type, LossType::STUDENT_T);
  EXPECT_EQ(law.scale, 0.5);
  EXPECT_EQ(law.degrees_of_freedom, 7.0);
}

TEST(ParseLoss, RefusesTheRest) {
  for (const char* text : {"", "hubert", "Huber", "huber:", "huber:x", "huber:1.0x", "huber: 1",
                           "huber:-1", "huber:0", "huber:nan", "huber:inf", "huber:1e999",
                           "huber:1:5", "huber:1:", "student_t:1:0", "student_t:1:2:3", ":1"}) {
    EXPECT_THROW(parse_loss(text), OptionsError) << text;
  }
}

TEST(Loss, ValidateNamesFieldRuleAndValue) {
  try {
    Loss{LossType::HUBER, -1.0}.validate();
    FAIL() << "accepted a negative scale";
  } catch (const OptionsError& error) {
    EXPECT_STREQ(error.what(), "Loss.scale must be > 0 and within [1e-100, 1e100], got -1");
  }
  EXPECT_THROW((Loss{LossType::STUDENT_T, 1.0, 0.0}.validate()), OptionsError);
}

}  // namespace
}  // namespace raylign::test
