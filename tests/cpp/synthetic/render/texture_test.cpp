// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/texture.h"

#include <gtest/gtest.h>

#include <cmath>
#include <vector>

#include "raylign/base/error.h"
#include "raylign/base/random.h"

namespace raylign::render {
namespace {

constexpr int kSize = 4 * kPointBlock;
constexpr double kPi = 3.141592653589793;

// Random points with a footprint of `pixel` each way.
struct Points {
  std::vector<double> storage[9];
  WavePoints view;

  explicit Points(double pixel, int size = kSize) {
    RandomStream random(7, "texture_test");
    for (int a = 0; a < 9; ++a) {
      for (int i = 0; i < size; ++i) {
        storage[a].push_back(random.uniform(-1.0, 1.0) * (a < 3 ? 3.0 : pixel));
      }
    }
    view.size = size;
    for (int axis = 0; axis < 3; ++axis) {
      view.position[axis] = storage[axis].data();
      view.by_u[axis] = storage[3 + axis].data();
      view.by_v[axis] = storage[6 + axis].data();
    }
  }
};

TEST(SinusoidKernels, EqualTheirScalarTwin) {
  const WaveTable table = random_waves(3, 0, TextureSpace::SOLID, 60, 0.06, 0.6, 32.0);
  const Waves waves = table.view();
  const Points points(0.02);
  std::vector<double> value(kSize), banded(kSize), plain(kSize), slope[3];
  for (auto& s : slope) s.resize(kSize);
  double* const gradient[3] = {slope[0].data(), slope[1].data(), slope[2].data()};
  sum_waves(waves, points.view, plain.data());
  sum_banded_waves(waves, points.view, banded.data());
  sum_wave_gradients(waves, points.view, value.data(), gradient);
  int num_limited = 0;
  for (int i = 0; i < kSize; ++i) {
    double sum = 0.0, band = 0.0;
    Vector3 by_x = Vector3::Zero();
    for (int k = 0; k < waves.count; ++k) {
      Vector3 f, x, u, v;
      for (int a = 0; a < 3; ++a) {
        f[a] = waves.frequency[a][k];
        x[a] = points.view.position[a][i];
        u[a] = points.view.by_u[a][i];
        v[a] = points.view.by_v[a][i];
      }
      const double angle = kPi * (f.dot(x) + waves.phase[k]);
      // Cycles per px, squared: frequencies are half turns.
      const double q = 0.25 * (f.dot(u) * f.dot(u) + f.dot(v) * f.dot(v));
      const double s = std::fmin(1.0, std::fmax(0.0, (0.16 - q) / (0.16 - 0.0625)));
      const double weight = s * s * s * (s * (6.0 * s - 15.0) + 10.0);
      sum += waves.amplitude[k] * std::sin(angle);
      band += weight * waves.amplitude[k] * std::sin(angle);
      by_x += waves.amplitude[k] * kPi * std::cos(angle) * f;
    }
    EXPECT_NEAR(plain[i], sum, 1e-11);
    EXPECT_EQ(value[i], plain[i]);
    EXPECT_NEAR(banded[i], band, 1e-10);
    num_limited += std::abs(banded[i] - sum) > 1e-3;
    for (int a = 0; a < 3; ++a) EXPECT_NEAR(slope[a][i], by_x[a], 1e-9);
  }
  EXPECT_GT(num_limited, kSize / 4);
  EXPECT_LT(num_limited, kSize);
}

TEST(SinusoidKernels, SineIsGoodToRoundingOverTheWholeRange) {
  WaveTable table;
  table.add(Vector3::UnitX(), 0.0, 1.0);
  std::vector<double> x(10 * kPointBlock), zero(x.size(), 0.0), value(x.size());
  for (std::size_t i = 0; i < x.size(); ++i) x[i] = -2.0 + i * (4.0 / 159.0);
  WavePoints points;
  points.size = static_cast<int>(x.size());
  points.position[0] = x.data();
  points.position[1] = points.position[2] = zero.data();
  sum_waves(table.view(), points, value.data());
  for (std::size_t i = 0; i < x.size(); ++i) EXPECT_NEAR(value[i], std::sin(kPi * x[i]), 1e-15);
}

class Textures : public testing::TestWithParam<std::tuple<TextureKind, TextureSpace>> {
 protected:
  std::shared_ptr<const Texture> make(double contrast = 32.0) const {
    TextureOptions options;
    options.kind = std::get<0>(GetParam());
    options.contrast = contrast;
    options.seed = 5;
    return make_texture(options, std::get<1>(GetParam()), 2);
  }
};

TEST_P(Textures, GradientEqualsTheNumericOne) {
  const auto texture = make();
  Points points(0.0);
  std::vector<double> value(kSize), ahead(kSize), behind(kSize), slope[3];
  for (auto& s : slope) s.resize(kSize);
  double* const gradient[3] = {slope[0].data(), slope[1].data(), slope[2].data()};
  texture->evaluate_with_gradient(points.view, value.data(), gradient);
  texture->evaluate(points.view, ahead.data());
  EXPECT_EQ(value, ahead);
  constexpr double kStep = 1e-6;
  for (int axis = 0; axis < 3; ++axis) {
    for (double& x : points.storage[axis]) x += kStep;
    texture->evaluate(points.view, ahead.data());
    for (double& x : points.storage[axis]) x -= 2.0 * kStep;
    texture->evaluate(points.view, behind.data());
    for (double& x : points.storage[axis]) x += kStep;
    for (int i = 0; i < kSize; ++i) {
      const double numeric = (ahead[i] - behind[i]) / (2.0 * kStep);
      EXPECT_NEAR(slope[axis][i], numeric, 1e-7 * 5000.0);  // slopes reach 5000 grey values per m
    }
  }
}

TEST_P(Textures, WideFootprintLeavesTheMeanAndNoneLeavesAll) {
  const auto texture = make();
  const Points wide(30.0), narrow(1e-12);
  std::vector<double> value(kSize), all(kSize);
  texture->evaluate_banded(wide.view, value.data());
  for (const double v : value) EXPECT_NEAR(v, 128.0, 1.0);
  texture->evaluate_banded(narrow.view, value.data());
  texture->evaluate(narrow.view, all.data());
  for (int i = 0; i < kSize; ++i) EXPECT_NEAR(value[i], all[i], 1e-6);
}

TEST_P(Textures, HaveTheirMeanAndContrast) {
  const auto texture = make();
  const Points points(0.0, 4096 * kPointBlock);
  std::vector<double> value(points.view.size);
  texture->evaluate(points.view, value.data());
  double sum = 0.0, square = 0.0;
  for (const double v : value) {
    sum += v - 128.0;
    square += (v - 128.0) * (v - 128.0);
  }
  EXPECT_NEAR(sum / value.size(), 0.0, 2.0);
  EXPECT_NEAR(std::sqrt(square / value.size()), 32.0, 2.0);
}

INSTANTIATE_TEST_SUITE_P(All,
                         Textures,
                         testing::Combine(testing::Values(TextureKind::BANDLIMITED,
                                                          TextureKind::NOISE,
                                                          TextureKind::CHECKER),
                                          testing::Values(TextureSpace::PLANE,
                                                          TextureSpace::SOLID)));

TEST(CheckerTexture, BandedValueIsTheMeanOverTheFootprint) {
  TextureOptions options;
  options.kind = TextureKind::CHECKER;
  const auto texture = make_texture(options, TextureSpace::PLANE, 0);
  Points points(0.03);
  for (int i = 0; i < kSize; ++i) points.storage[4][i] = points.storage[6][i] = 0.0;  // a box
  std::vector<double> banded(kSize), sample(kSize), mean(kSize, 0.0);
  texture->evaluate_banded(points.view, banded.data());
  const Points centre = points;
  constexpr int kGrid = 200;
  for (int a = 0; a < kGrid; ++a) {
    for (int b = 0; b < kGrid; ++b) {
      for (int i = 0; i < kSize; ++i) {
        const double s = (a + 0.5) / kGrid - 0.5, t = (b + 0.5) / kGrid - 0.5;
        points.storage[0][i] = centre.storage[0][i] + s * centre.storage[3][i];
        points.storage[1][i] = centre.storage[1][i] + t * centre.storage[7][i];
      }
      texture->evaluate(points.view, sample.data());
      for (int i = 0; i < kSize; ++i) mean[i] += sample[i] / (kGrid * kGrid);
    }
  }
  for (int i = 0; i < kSize; ++i) EXPECT_NEAR(banded[i], mean[i], 1.0);
}

TEST(TextureOptions, RefusesBadValues) {
  TextureOptions options;
  options.max_wavelength = 0.01;
  EXPECT_THROW(options.validate(), OptionsError);
  options = {};
  options.num_waves = 0;
  EXPECT_THROW(options.validate(), OptionsError);
}

}  // namespace
}  // namespace raylign::render
