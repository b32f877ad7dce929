// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/renderer.h"

#include <gtest/gtest.h>

#include <cmath>

#include "raylign/base/error.h"
#include "raylign/base/random.h"
#include "raylign/geometry/se3.h"
#include "raylign/synthetic/render/height_field.h"

namespace raylign {
namespace {

const RadtanCamera kCamera({60.0, 61.0, 31.7, 23.9}, {});

TextureOptions texture(std::uint64_t seed) {
  TextureOptions options;
  options.seed = seed;
  return options;
}

RenderScene furnished_room() {
  RenderScene scene;
  Vector6 xi;
  xi << 0.3, -0.1, 0.6, 0.1, -0.4, 0.05;
  const Matrix4 T_ws = se3_exp(xi);
  scene.add_box(T_ws, {4.0, 2.6, 4.0}, texture(1));
  scene.add_sphere(T_ws, 0.4, texture(2));
  scene.add_rectangle(se3_exp(0.5 * xi), 0.5, 0.7, texture(3));
  return scene;
}

// z − h(x, y) of a height field, through the surface's own normals: the plane wave table is
// private.
TEST(HeightField, RaysEndOnTheFirstCrossing) {
  HeightFieldOptions options;
  options.amplitude = 0.3;  // steep: rays cross several times
  const auto surface = render::make_height_field(options);
  RandomStream random(3, "height_field_test");
  constexpr int kRays = 200;
  std::vector<Vector3> directions;
  for (int i = 0; i < kRays; ++i) {
    directions.emplace_back(random.uniform(-1.0, 1.0), random.uniform(-0.7, 0.7), -0.2);
  }
  const Vector3 origin(0.2, -0.1, 0.9);
  const auto cast = [&](const Vector3& from, std::vector<double>& t) {
    std::vector<int> face(kRays, -1);
    t.assign(kRays, 1e300);
    render::Hits hits{t.data(), face.data()};
    surface->intersect({kRays, from, directions.data()}, 0, hits);
    return face;
  };
  std::vector<double> t, again;
  const std::vector<int> face = cast(origin, t);
  int hits = 0;
  for (int i = 0; i < kRays; ++i) {
    if (face[i] < 0) continue;
    ++hits;
    // No crossing before the hit: rays from anywhere between end at the same point.
    const double part = random.uniform(0.1, 0.95) * t[i];
    cast(origin + part * directions[i], again);
    EXPECT_NEAR(again[i], t[i] - part, 1e-11);
    // On the surface: straight down from above the same point lies the same height.
    const Vector3 p = origin + t[i] * directions[i];
    const Vector3 down(0.0, 0.0, -1.0);
    double drop = 1e300;
    int drop_face = -1;
    render::Hits one{&drop, &drop_face};
    surface->intersect({1, Vector3(p.x(), p.y(), 5.0), &down}, 0, one);
    EXPECT_NEAR(5.0 - drop, p.z(), 1e-11);
  }
  EXPECT_GT(hits, kRays / 2);
  EXPECT_LT(hits, kRays);  // some leave at the sides
}

TEST(Surfaces, RaysParallelToAWallMissItAndOnlyIt) {
  const auto box = render::make_box({2.0, 2.0, 2.0});
  for (const double zero : {0.0, -0.0}) {
    const Vector3 direction(zero, zero, 1.0);
    double t = 1e300;
    int face = -1;
    render::Hits hits{&t, &face};
    box->intersect({1, Vector3(0.3, -0.4, 0.0), &direction}, 0, hits);
    EXPECT_EQ(t, 1.0);
    EXPECT_EQ(face, 5);
    t = 1e300;
    box->intersect({1, Vector3(1.5, 0.0, -3.0), &direction}, 0, hits);
    EXPECT_EQ(t, 1e300);
  }
}

TEST(Renderer, ThreadsDoNotChangeABit) {
  const RenderScene scene = furnished_room();
  Vector6 motion;
  motion << 0.1, 0.05, -0.1, 0.02, 0.03, -0.01;
  for (const Antialiasing mode : {Antialiasing::BANDLIMIT, Antialiasing::SUPERSAMPLE}) {
    RenderOptions options;
    options.antialiasing = mode;
    options.supersampling = 2;
    options.exposure_time = 0.5;
    options.readout_time = 0.5;
    options.blur_samples = 2;
    const auto one = render_frame(scene, kCamera, Matrix4::Identity(), 65, 49, options, motion);
    for (const int threads : {2, 3}) {
      options.num_threads = threads;
      const auto many = render_frame(scene, kCamera, Matrix4::Identity(), 65, 49, options, motion);
      EXPECT_TRUE((one.irradiance.array() == many.irradiance.array()).all());
      EXPECT_TRUE((one.depth.array() == many.depth.array()).all());
      EXPECT_TRUE((one.normal.array() == many.normal.array()).all());
      EXPECT_TRUE((one.face.array() == many.face.array()).all());
    }
  }
}

// FNV-1a over the bytes.
template <typename Map>
std::uint64_t hash_of(const Map& map) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  const auto* bytes = reinterpret_cast<const unsigned char*>(map.data());
  const std::size_t size = map.size() * sizeof(*map.data());
  for (std::size_t i = 0; i < size; ++i) hash = (hash ^ bytes[i]) * 0x100000001b3ULL;
  return hash;
}

TEST(Renderer, BitsAreTheSameEverywhere) {
  // Recorded with AVX-512 and with SSE2; a change means that every rendered data set changes.
  RenderScene scene;
  Matrix4 T_ws = Matrix4::Identity();
  T_ws(2, 3) = 1.0;
  scene.add_box(T_ws, {4.0, 3.0, 5.0}, texture(3));
  scene.add_sphere(T_ws, 0.5, texture(3));
  T_ws(2, 3) = 2.5;
  scene.add_height_field(T_ws, {}, texture(3));
  const auto frame = render_frame(scene, kCamera, Matrix4::Identity(), 65, 49);
  EXPECT_EQ(hash_of(frame.irradiance), 0x5e49f0d14456b887ULL);
  EXPECT_EQ(hash_of(frame.depth), 0xf95592f643071f91ULL);
  EXPECT_EQ(hash_of(frame.normal), 0xd5f9cb1c8bb1fe33ULL);
}

TEST(Renderer, FootprintIsTheDerivativeOfThePointByThePixel) {
  // A texture of one wave at 3 px is attenuated by the weight at its true projected wavelength:
  // compare the rendered band limit on a slanted plane with one from finite differences.
  RenderScene scene;
  TextureOptions wave;
  wave.num_waves = 1;
  wave.min_wavelength = wave.max_wavelength = 0.14;
  Vector6 xi;
  xi << 0.0, 0.0, 2.5, 0.3, 0.7, 0.0;
  scene.add_rectangle(se3_exp(xi), 50.0, 50.0, wave);
  const auto banded = render_frame(scene, kCamera, Matrix4::Identity(), 64, 48);
  RenderOptions plain;
  plain.antialiasing = Antialiasing::NONE;
  const auto full = render_frame(scene, kCamera, Matrix4::Identity(), 64, 48, plain);
  const auto point = [&](double u, double v) {
    const RadtanCamera shifted({60.0, 61.0, 31.7 - u, 23.9 - v}, {});
    const auto pixel = render_frame(scene, shifted, Matrix4::Identity(), 1, 1, plain);
    return Vector3(pixel.depth(0, 0) * Vector3((u - 31.7) / 60.0, (v - 23.9) / 61.0, 1.0));
  };
  // The direction of the wave from the gradient, its length from the options.
  Vector3 slope;
  scene.grey_value(0, point(20.0, 20.0), &slope);
  const Vector3 f = slope.normalized() / 0.14;
  int num_partial = 0;
  for (int v = 1; v < 47; v += 5) {
    for (int u = 1; u < 63; u += 3) {
      const Vector3 by_u = (point(u + 1e-3, v) - point(u - 1e-3, v)) / 2e-3;
      const Vector3 by_v = (point(u, v + 1e-3) - point(u, v - 1e-3)) / 2e-3;
      const double q = std::pow(f.dot(by_u), 2) + std::pow(f.dot(by_v), 2);
      const double s = std::fmin(1.0, std::fmax(0.0, (0.16 - q) / (0.16 - 0.0625)));
      const double weight = s * s * s * (s * (6.0 * s - 15.0) + 10.0);
      num_partial += weight > 0.01 && weight < 0.99;
      EXPECT_NEAR(banded.irradiance(v, u) - 128.0, weight * (full.irradiance(v, u) - 128.0), 1e-3);
    }
  }
  EXPECT_GT(num_partial, 20);
}

TEST(RenderScene, RefusesWhatHasNoSizeOrPlace) {
  RenderScene scene;
  const Matrix4 I = Matrix4::Identity();
  EXPECT_THROW(scene.add_box(I, {1.0, 0.0, 1.0}, {}), OptionsError);
  EXPECT_THROW(scene.add_sphere(I, std::nan(""), {}), OptionsError);
  EXPECT_THROW(scene.add_rectangle(2.0 * I, 1.0, 1.0, {}), OptionsError);
  HeightFieldOptions flat;
  flat.max_wavelength = 0.1;
  EXPECT_THROW(scene.add_height_field(I, flat, {}), OptionsError);
  EXPECT_TRUE(scene.faces().empty());
  EXPECT_THROW(render_frame(scene, kCamera, I, 40000, 3), ShapeError);
  EXPECT_EQ(render_frame(scene, kCamera, I, 3, 2).face,
            (RenderedFrame::Map<std::int32_t>::Constant(2, 3, -1)));
}

TEST(RenderScene, CanBeAddedToItself) {
  RenderScene scene = furnished_room();
  const std::size_t num_faces = scene.faces().size();
  scene.add(scene);
  EXPECT_EQ(scene.faces().size(), 2 * num_faces);
  EXPECT_EQ(scene.faces().back().surface, 5);
  EXPECT_EQ(scene.surfaces().back().first_face, static_cast<int>(2 * num_faces - 1));
}

}  // namespace
}  // namespace raylign
