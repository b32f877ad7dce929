// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/portable_math.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/base/random.h"

namespace raylign {
namespace {

constexpr double kTolerance = 1e-15;  // about 4 ulp

TEST(PortableMath, LogAgreesWithLibm) {
  RandomStream random(1, "log");
  for (int i = 0; i < 10000; ++i) {
    const double x = std::exp(random.uniform(-700.0, 700.0));
    EXPECT_NEAR(portable::log(x), std::log(x), kTolerance * (1.0 + std::abs(std::log(x)))) << x;
  }
  EXPECT_EQ(portable::log(1.0), 0.0);
}

TEST(PortableMath, ExpAgreesWithLibm) {
  RandomStream random(2, "exp");
  for (int i = 0; i < 10000; ++i) {
    const double x = random.uniform(-700.0, 700.0);
    EXPECT_NEAR(portable::exp(x) / std::exp(x), 1.0, kTolerance) << x;
  }
  EXPECT_EQ(portable::exp(0.0), 1.0);
}

TEST(PortableMath, SinCosAgreeWithLibmInEveryQuadrant) {
  RandomStream random(3, "sincos");
  for (int i = 0; i < 10000; ++i) {
    const double x = i % 2 == 0 ? random.uniform(-7.0, 7.0) : random.uniform(-1e5, 1e5);
    const auto [s, c] = portable::sincos(x);
    EXPECT_NEAR(s, std::sin(x), kTolerance) << x;
    EXPECT_NEAR(c, std::cos(x), kTolerance) << x;
  }
}

TEST(PortableMath, Atan2AgreesWithLibmInEveryQuadrant) {
  RandomStream random(4, "atan2");
  for (int i = 0; i < 10000; ++i) {
    const double x = random.normal();
    const double y = random.normal() * (i % 3 == 0 ? 1e-9 : 1.0);
    EXPECT_NEAR(portable::atan2(y, x), std::atan2(y, x), 2 * kTolerance) << y << " " << x;
  }
  EXPECT_EQ(portable::atan2(0.0, 0.0), 0.0);
  EXPECT_DOUBLE_EQ(portable::atan2(0.0, -1.0), std::atan2(0.0, -1.0));
}

}  // namespace
}  // namespace raylign
