// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/orbit_scene.h"

#include <algorithm>
#include <array>
#include <cmath>

#include "raylign/base/portable_math.h"

namespace raylign {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;
constexpr double kPlazaRadius = 24.0;  // m
constexpr double kWallRadius = 7.5;    // closed body of the building up to kDrumTop, m
constexpr double kDrumTop = 14.0;      // m
constexpr double kDomeRadius = 7.5;    // m
constexpr double kDomeHeight = 6.5;    // m
constexpr int kNumColumns = 16;
constexpr int kNumRibs = 24;
constexpr double kColumnRing = 9.4;     // m
constexpr double kColumnRadius = 0.55;  // m

constexpr Rgb kStone = {226, 214, 188};
constexpr Rgb kLightStone = {244, 238, 222};
constexpr Rgb kPlaster = {206, 170, 128};
constexpr Rgb kCopper = {108, 164, 144};
constexpr Rgb kRib = {72, 120, 108};
constexpr Rgb kGlass = {60, 74, 96};
constexpr Rgb kGold = {230, 186, 70};
constexpr Rgb kPaving = {172, 160, 148};
constexpr Rgb kDarkPaving = {128, 108, 98};
constexpr Rgb kCypress = {48, 92, 50};

// A cone frustum of revolution between (r0, z0) and (r1, z1); the normal is left of the way up.
struct Ring {
  double r0, z0, r1, z1;
  Rgb color;
};
constexpr std::array<Ring, 11> kRings = {{
    {12.0, 0.0, 12.0, 0.5, kLightStone},  // steps: riser, tread, …
    {12.0, 0.5, 11.3, 0.5, kStone},
    {11.3, 0.5, 11.3, 1.0, kLightStone},
    {11.3, 1.0, 10.6, 1.0, kStone},
    {10.6, 1.0, 10.6, 1.5, kLightStone},
    {10.6, 1.5, kWallRadius, 1.5, kStone},  // floor of the colonnade
    {10.1, 9.0, 10.1, 10.4, kLightStone},   // entablature
    {10.5, 10.4, kWallRadius, 11.6, kRib},  // roof of the colonnade
    {1.3, 20.3, 1.3, 23.0, kStone},         // lantern
    {1.5, 23.0, 0.05, 25.2, kGold},
    {10.1, 10.4, 10.5, 10.4, kLightStone},  // cornice, from below
}};

double wrap_to_cell(double x, double pitch) { return x - pitch * std::floor(x / pitch); }

Vector3 radial(double phi) {
  const auto [s, c] = portable::sincos(phi);
  return Vector3(c, s, 0.0);
}

// Cylindrical (r, z) of position and normal, in the half plane through the z axis and `out`.
void set_revolved(ScenePoint& point, const Vector3& out, const Vector2& rz, const Vector2& n_rz) {
  point.position = rz.x() * out + rz.y() * Vector3::UnitZ();
  point.normal = (n_rz.x() * out + n_rz.y() * Vector3::UnitZ()).normalized();
}

void sample_ring(double phi, RandomStream& random, ScenePoint& point) {
  const Ring& ring = kRings[random.below(static_cast<std::uint32_t>(kRings.size()))];
  // Joints of the masonry: half of the features sit on a grid of 3° and at the edges.
  double tau = random.uniform();
  if (random.uniform() < 0.5) {
    tau = tau < 0.5 ? 0.0 : 1.0;
    phi = 3.0 * kDegree * std::floor(phi / (3.0 * kDegree));
  }
  const Vector2 way(ring.r1 - ring.r0, ring.z1 - ring.z0);
  set_revolved(point, radial(phi), Vector2(ring.r0, ring.z0) + tau * way,
               Vector2(way.y(), -way.x()));
  point.color = shade(ring.color, 1.0, random);
}

// Wall of the cella (z 1.5 … 9) or the drum above it (11.6 … 14), with arched or square windows.
void sample_wall(double phi, RandomStream& random, ScenePoint& point) {
  const bool drum = random.uniform() < 0.3;
  const double pitch = (drum ? 15.0 : 22.5) * kDegree;
  const double low = drum ? 12.1 : 3.0;
  const double high = drum ? 13.6 : 6.6;
  double in_cell = wrap_to_cell(phi, pitch) / pitch;
  double z = drum ? random.uniform(11.6, kDrumTop) : random.uniform(1.5, 9.0);
  if (random.uniform() < 0.55) {
    phi += ((in_cell < 0.5 ? 0.3 : 0.7) - in_cell) * pitch;
    in_cell = in_cell < 0.5 ? 0.3 : 0.7;
    z = random.uniform(low, high);
  }
  const bool glass = in_cell > 0.31 && in_cell < 0.69 && z > low && z < high;
  set_revolved(point, radial(phi), {kWallRadius - (glass ? 0.25 : 0.0), z}, {1.0, 0.0});
  point.color = shade(glass ? kGlass : (drum ? kLightStone : kPlaster), 1.0, random);
}

void sample_column(double phi, RandomStream& random, ScenePoint& point) {
  const double pitch = 2.0 * kPi / kNumColumns;
  const Vector3 axis = kColumnRing * radial(pitch * (std::floor(phi / pitch) + 0.5));
  const double z = random.uniform(1.5, 9.0);
  const bool capital = z < 2.0 || z > 8.4;
  const double flute = kPi / 8.0;  // 16 flutes
  const Vector3 out = radial(flute * std::floor(random.uniform(-kPi, kPi) / flute));
  point.position = axis + (kColumnRadius + (capital ? 0.15 : 0.0)) * out + z * Vector3::UnitZ();
  point.normal = out;
  point.color = shade(capital ? kStone : kLightStone, 1.0, random);
}

void sample_dome(double phi, RandomStream& random, ScenePoint& point) {
  const double pitch = 2.0 * kPi / kNumRibs;
  const bool rib = random.uniform() < 0.5;
  if (rib) phi = pitch * std::floor(phi / pitch) + (random.uniform() < 0.5 ? 0.02 : -0.02);
  const auto [s, c] = portable::sincos(0.5 * kPi * 0.9 * random.uniform());
  set_revolved(point, radial(phi),
               {(kDomeRadius + (rib ? 0.12 : 0.0)) * c, kDrumTop + kDomeHeight * s},
               {kDomeHeight * c, kDomeRadius * s});
  point.color = shade(rib ? kRib : kCopper, 0.9 + 0.2 * s, random);
}

void sample_plaza(double phi, RandomStream& random, ScenePoint& point) {
  double r = random.uniform(12.0, kPlazaRadius);
  const bool on_circle = random.uniform() < 0.4;
  if (on_circle) r = 12.0 + 2.0 * std::floor(0.5 * (r - 12.0));
  if (!on_circle && random.uniform() < 0.5)
    phi = 10.0 * kDegree * std::floor(phi / (10.0 * kDegree));
  const auto tile = static_cast<int>(std::floor(phi / (10.0 * kDegree)) + std::floor(0.5 * r));
  point.position = r * radial(phi);
  point.normal = Vector3::UnitZ();
  point.color = shade(tile % 2 == 0 ? kPaving : kDarkPaving, 1.0, random);
}

// Cones, 6 m high, on a circle inside the plaza.
void sample_cypress(double phi, RandomStream& random, ScenePoint& point) {
  const double pitch = 2.0 * kPi / 12.0;
  const Vector3 axis = 18.0 * radial(pitch * (std::floor(phi / pitch) + 0.25));
  const double tau = std::sqrt(random.uniform());
  const Vector3 out = radial(random.uniform(-kPi, kPi));
  point.position = axis + 1.0 * tau * out + (6.0 - 5.6 * tau) * Vector3::UnitZ();
  point.normal = (5.6 * out + Vector3::UnitZ()).normalized();
  point.color = shade(kCypress, 1.2 - 0.4 * tau, random);
}

}  // namespace

OrbitScene::OrbitScene(const SyntheticBalOptions& options) : max_distance_(options.max_distance) {
  const int num_rings =
      std::max(1, static_cast<int>(std::floor(std::sqrt(options.num_cameras) / 5.5 + 0.5)));
  int camera = 0;
  for (int ring = 0; ring < num_rings; ++ring) {
    const auto end =
        static_cast<int>(static_cast<std::int64_t>(options.num_cameras) * (ring + 1) / num_rings);
    const int count = end - camera;
    const double level = (ring + 0.5) / num_rings;
    // A few photographs make an arc, not a ring: at most 24° from one to the next.
    const double step = std::min(24.0, 360.0 / count) * kDegree;
    if (ring == 0) baseline_ = 30.0 * step;
    for (int i = 0; i < count; ++i, ++camera) {
      RandomStream random(options.seed, "orbit_camera", camera);
      const Vector3 out = radial((i + 0.25 * random.uniform(-1.0, 1.0) + 0.5 * (ring % 2)) * step);
      const double distance = 33.0 - 6.0 * level + 2.0 * random.uniform(-1.0, 1.0);
      const double height = 1.7 + 20.0 * level * level + random.uniform(-0.2, 0.8);
      const Vector3 center = distance * out + height * Vector3::UnitZ();
      const Vector3 target(random.uniform(-2.0, 2.0), random.uniform(-2.0, 2.0),
                           random.uniform(7.0, 10.0));
      add_camera(options, center, target - center, 1.5 * kDegree * random.normal(), 0);
    }
  }
  viewing_distance_ = 22.0;
}

bool OrbitScene::sample(int camera, RandomStream& random, ScenePoint& point) const {
  const Vector3& c = cameras()[camera].center;
  const double spread = 85.0 * kDegree * (random.uniform() - random.uniform());
  const double phi = portable::atan2(c.y(), c.x()) + spread;
  point.reach = max_distance_;
  const double kind = random.uniform();
  if (kind < 0.22) {
    sample_ring(phi, random, point);
  } else if (kind < 0.45) {
    sample_wall(phi, random, point);
  } else if (kind < 0.62) {
    sample_column(phi, random, point);
  } else if (kind < 0.80) {
    sample_dome(phi, random, point);
  } else if (kind < 0.94) {
    sample_plaza(phi, random, point);
  } else {
    sample_cypress(phi, random, point);
  }
  return true;
}

// Only the closed body, a cylinder about the z axis, hides things: clip the sight line against it.
bool OrbitScene::line_of_sight(int camera, const ScenePoint& point) const {
  const Vector3& c = cameras()[camera].center;
  const Vector3 way = point.position - c;
  const double a = way.head<2>().squaredNorm();
  const double b = way.head<2>().dot(c.head<2>());
  const double radius = kWallRadius - 0.35;
  const double discriminant = b * b - a * (c.head<2>().squaredNorm() - radius * radius);
  if (discriminant <= 0.0) return true;
  const double root = std::sqrt(discriminant);
  const double enter = (-b - root) / a;
  const double leave = std::min(1.0, (-b + root) / a);
  if (enter >= 1.0 || leave <= 0.0) return true;
  return std::min(c.z() + enter * way.z(), c.z() + leave * way.z()) > kDrumTop;
}

}  // namespace raylign
