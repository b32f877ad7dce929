// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/street_scene.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "raylign/base/portable_math.h"

namespace raylign {
namespace {

constexpr double kPi = 3.14159265358979323846;
constexpr double kDegree = kPi / 180.0;
constexpr double kHalfWidth = StreetRoute::kHalfWidth;
constexpr double kCurb = 4.0;            // centre line to pavement, m
constexpr double kBuildingWidth = 14.0;  // m
constexpr double kFloor = 3.2;           // storey height, m
constexpr double kTowerSetback = 30.0;   // facade line to the second row, m
constexpr double kTowerWidth = 28.0;     // m
constexpr double kTreePitch = 9.0;       // m
constexpr double kGardenWall = 1.8;      // m
constexpr double kFirstStop = 8.0;       // past the first crossing, m

constexpr int kNoRegion = -1;
constexpr int kTowerBit = 1 << 28;
constexpr int kRightBit = 1 << 27;

constexpr std::array<Rgb, 8> kWalls = {{{196, 112, 84},
                                        {222, 199, 156},
                                        {170, 178, 186},
                                        {232, 222, 205},
                                        {150, 84, 70},
                                        {188, 164, 120},
                                        {206, 150, 130},
                                        {160, 172, 150}}};
constexpr Rgb kGlass = {58, 78, 104};
constexpr Rgb kFrame = {245, 243, 236};
constexpr Rgb kShop = {120, 62, 48};
constexpr Rgb kAsphalt = {92, 92, 96};
constexpr Rgb kMarking = {238, 238, 228};
constexpr Rgb kPavement = {168, 164, 156};
constexpr Rgb kLeaf = {70, 128, 52};
constexpr Rgb kTrunk = {98, 72, 48};
constexpr Rgb kTower = {142, 160, 182};

// Stops of a short loop move apart so that it closes, up to here in m: neighbouring stops must
// share points, also round a corner, where a single view turns away.
double max_stop_spacing(int views_per_stop) { return views_per_stop == 1 ? 4.0 : 12.0; }

double cross(const Vector2& a, const Vector2& b) { return a.x() * b.y() - a.y() * b.x(); }

double loop_length(const SyntheticBalOptions& options) {
  const int stops = (options.num_cameras + options.views_per_stop - 1) / options.views_per_stop;
  const int stops_per_lap = (stops + options.num_laps - 1) / options.num_laps;
  return stops_per_lap * options.stop_spacing;
}

// Position of x in cells of `pitch`, moved to the outline [low, high] of the cell most of the time:
// features sit on edges and corners.
double snap(double x, double pitch, double low, double high, RandomStream& random) {
  const double cell = std::floor(x / pitch);
  const double inside = x - cell * pitch;
  if (random.uniform() < 0.4) return x;
  const double edge = 2.0 * inside < low + high ? low : high;
  return cell * pitch + edge + 0.02 * random.uniform(-1.0, 1.0);
}

}  // namespace

struct StreetScene::Ray {
  Vector3 origin;
  Vector3 direction;  // any length
  int segment;
};

// The nearest facade plane that the ray meets from the street.
struct StreetScene::Hit {
  int segment = kNoRegion;
  int side = 0;
  double along = 0.0;
  double height = 0.0;
  double t = std::numeric_limits<double>::infinity();
};

StreetScene::StreetScene(const SyntheticBalOptions& options)
    : options_(options), route_(loop_length(options)) {
  viewing_distance_ = 10.0;
  int stop = 0;
  for (int first = 0; first < options.num_cameras; first += options.views_per_stop) {
    add_stop(options, stop++, first);
  }
}

void StreetScene::add_stop(const SyntheticBalOptions& options, int stop, int first_camera) {
  const int views = options.views_per_stop;
  const int stops = (options.num_cameras + views - 1) / views;
  const int stops_per_lap = (stops + options.num_laps - 1) / options.num_laps;
  const double spacing = std::min(route_.length() / stops_per_lap,
                                  std::max(options.stop_spacing, max_stop_spacing(views)));
  baseline_ = spacing;
  RandomStream random(options.seed, "street_stop", stop);
  const int lap = stop / stops_per_lap;
  // Later laps stop in between and keep another line in the lane.
  const double shift =
      static_cast<double>(lap) / options.num_laps + 0.1 * random.uniform(-1.0, 1.0);
  const RoutePose pose = route_.pose(kFirstStop + (stop % stops_per_lap + shift) * spacing);
  const Vector2 left(-pose.heading.y(), pose.heading.x());
  const Vector2 xy = pose.position + (random.uniform(-0.5, 0.5) + 0.8 * (lap % 2) - 0.4) * left;
  const Vector3 center(xy.x(), xy.y(), 2.4 + 0.03 * random.normal());
  const double step = std::min(45.0, 360.0 / views) * kDegree;
  const double car_yaw = 1.5 * kDegree * random.normal();
  for (int view = 0; view < views && first_camera + view < options.num_cameras; ++view) {
    const double yaw =
        (0.5 * (views - 1) - view) * step + car_yaw + 0.3 * kDegree * random.normal();
    const double pitch = (9.0 + 0.8 * random.normal()) * kDegree;
    const auto [sin_yaw, cos_yaw] = portable::sincos(yaw);
    const auto [sin_pitch, cos_pitch] = portable::sincos(pitch);
    const Vector2 look = cos_yaw * pose.heading + sin_yaw * left;
    // The sensors of a rig sit 15 cm from its axis.
    const Vector3 sensor = center + 0.15 * Vector3(look.x(), look.y(), 0.0);
    add_camera(options, sensor, Vector3(cos_pitch * look.x(), cos_pitch * look.y(), sin_pitch),
               0.8 * kDegree * random.normal(), lap);
    segment_of_camera_.push_back(pose.segment);
  }
}

Vector3 StreetScene::to_world(int segment, double along, double across, double height) const {
  const StreetSegment& s = route_.segments()[segment];
  const Vector2 xy = s.start + along * s.direction + across * s.left;
  return Vector3(xy.x(), xy.y(), height);
}

// One plot in seven is empty but for a garden wall: the towers behind show through the gap.
double StreetScene::roof_height(int segment, int side, double along) const {
  const double offset = along - route_.facade_range(segment, side).first;
  const auto building = static_cast<std::int64_t>(std::floor(offset / kBuildingWidth));
  const std::uint32_t style = hash_cell(segment, side, building);
  return style % 7 == 0 ? kGardenWall : kFloor * (2 + (style >> 8) % 5) + 0.8;
}

bool StreetScene::sample(int camera, RandomStream& random, ScenePoint& point) const {
  point.reach = options_.max_distance;
  if (random.uniform() < 0.25) return sample_tree(camera, random, point);
  Ray ray{cameras()[camera].center, Vector3::Zero(), segment_of_camera_[camera]};
  if (!sample_direction(options_, cameras()[camera], random, ray.direction)) return false;
  const Hit hit = cast(ray);
  const double t_ground = ray.direction.z() < 0.0 ? -ray.origin.z() / ray.direction.z()
                                                  : std::numeric_limits<double>::infinity();
  point.region = ray.segment;
  if (t_ground < hit.t) return sample_ground(ray.origin + t_ground * ray.direction, random, point);
  if (hit.segment == kNoRegion) return false;
  if (hit.height < roof_height(hit.segment, hit.side, hit.along))
    return sample_facade(hit, random, point);
  return sample_tower(ray, random, point);
}

StreetScene::Hit StreetScene::cast(const Ray& ray) const {
  Hit best;
  for (const int i : {ray.segment, route_.next(ray.segment), route_.previous(ray.segment)}) {
    const StreetSegment& s = route_.segments()[i];
    const Vector2 offset = ray.origin.head<2>() - s.start;
    const Vector2 d = ray.direction.head<2>();
    const double slope = d.dot(s.left);
    if (slope == 0.0) continue;
    const int side = slope > 0.0 ? 1 : -1;  // the other side shows its back
    const double t = (side * kHalfWidth - offset.dot(s.left)) / slope;
    const double along = offset.dot(s.direction) + t * d.dot(s.direction);
    const auto [begin, end] = route_.facade_range(i, side);
    if (t <= 0.0 || t >= best.t || along < begin || along > end) continue;
    best = {i, side, along, ray.origin.z() + t * ray.direction.z(), t};
  }
  return best;
}

bool StreetScene::sample_ground(const Vector3& hit, RandomStream& random, ScenePoint& point) const {
  if (random.uniform() > 0.35) return false;  // asphalt has few features
  const StreetSegment& s = route_.segments()[point.region];
  const Vector2 offset = hit.head<2>() - s.start;
  const double along = offset.dot(s.direction);
  double across = offset.dot(s.left);
  const double off_center = std::abs(across);
  const double dash = along / 6.0 - std::floor(along / 6.0);
  point.normal = Vector3::UnitZ();
  if (off_center < 0.6 && dash < 0.5) {
    across = across < 0.0 ? -0.08 : 0.08;
    point.color = shade(kMarking, 1.0, random);
  } else if (std::abs(off_center - kCurb) < 0.5) {
    across = across < 0.0 ? -kCurb : kCurb;
    point.color = shade(kPavement, 1.1, random);
  } else {
    point.color = shade(off_center > kCurb ? kPavement : kAsphalt, 1.0, random);
  }
  point.position = to_world(point.region, along, across, off_center > kCurb ? 0.12 : 0.0);
  return true;
}

bool StreetScene::sample_facade(const Hit& hit, RandomStream& random, ScenePoint& point) const {
  const double begin = route_.facade_range(hit.segment, hit.side).first;
  const double building = std::floor((hit.along - begin) / kBuildingWidth);
  const double corner = begin + building * kBuildingWidth;
  const auto number = static_cast<std::int64_t>(building);
  const std::uint32_t style = hash_cell(hit.segment, hit.side, number + 1000003);
  const double pitch = kBuildingWidth / (4 + style % 3);
  const double along = corner + snap(hit.along - corner, pitch, 0.27 * pitch, 0.73 * pitch, random);
  const double height = snap(std::max(hit.height, 0.05), kFloor, 0.9, 2.5, random);
  const double in_cell = (along - corner) / pitch - std::floor((along - corner) / pitch);
  const double in_floor = height - kFloor * std::floor(height / kFloor);
  const bool glass = in_cell > 0.29 && in_cell < 0.71 && in_floor > 0.95 && in_floor < 2.45;
  const bool frame =
      !glass && in_cell > 0.24 && in_cell < 0.76 && in_floor > 0.85 && in_floor < 2.55;
  const Rgb& wall =
      height < kFloor && style % 5 == 0 ? kShop : kWalls[(style >> 8) % kWalls.size()];
  const double setback = 0.8 * hash_unit(hit.segment, hit.side, number + 2000003);
  point.normal = -hit.side * to_world(hit.segment, 0.0, 1.0, 0.0) +
                 hit.side * to_world(hit.segment, 0.0, 0.0, 0.0);
  point.position =
      to_world(hit.segment, along, hit.side * (kHalfWidth + setback + (glass ? 0.2 : 0.0)), height);
  const double light = 0.88 + 0.12 * point.normal.dot(Vector3(0.6, -0.8, 0.0));
  point.color = shade(glass ? kGlass : (frame ? kFrame : wall), light, random);
  point.region = hit.segment;
  return true;
}

bool StreetScene::sample_tower(const Ray& ray, RandomStream& random, ScenePoint& point) const {
  const StreetSegment& s = route_.segments()[ray.segment];
  const Vector2 offset = ray.origin.head<2>() - s.start;
  const double slope = ray.direction.head<2>().dot(s.left);
  if (slope == 0.0) return false;
  const int side = slope > 0.0 ? 1 : -1;
  const double across = side * (kHalfWidth + kTowerSetback);
  const double t = (across - offset.dot(s.left)) / slope;
  const double along = offset.dot(s.direction) + t * ray.direction.head<2>().dot(s.direction);
  const double height = ray.origin.z() + t * ray.direction.z();
  const auto number = static_cast<std::int64_t>(std::floor(along / kTowerWidth));
  const std::uint32_t style = hash_cell(ray.segment, side, number + 3000017);
  if (style % 5 < 2) return false;  // a gap
  if (height < 0.0 || height > 30.0 + style % 35) return false;
  if (along < -kTowerWidth || along > s.length + kTowerWidth) return false;
  point.position = to_world(ray.segment, snap(along, 3.5, 0.5, 3.0, random), across,
                            snap(height, 3.5, 0.7, 2.8, random));
  point.normal = Vector3(-side * s.left.x(), -side * s.left.y(), 0.0);
  point.color = shade(random.uniform() < 0.5 ? kTower : kGlass, 0.9 + 0.02 * (style % 10), random);
  point.reach = 4.0 * options_.max_distance;
  point.region = ray.segment | kTowerBit | (side < 0 ? kRightBit : 0);
  return true;
}

bool StreetScene::sample_tree(int camera, RandomStream& random, ScenePoint& point) const {
  const int segment = segment_of_camera_[camera];
  const StreetSegment& s = route_.segments()[segment];
  const Vector3& center = cameras()[camera].center;
  const double here = (center.head<2>() - s.start).dot(s.direction);
  const double number = std::floor((here + random.uniform(-30.0, 30.0)) / kTreePitch);
  const double along = (number + 0.5) * kTreePitch;
  if (along < kHalfWidth || along > s.length - kHalfWidth) return false;
  const int side = random.uniform() < 0.5 ? -1 : 1;
  const std::uint32_t style = hash_cell(segment, side, static_cast<std::int64_t>(number) + 4000037);
  if (style % 4 == 0) return false;  // a missing tree
  const double z = random.uniform(-1.0, 1.0);
  const auto [sin_phi, cos_phi] = portable::sincos(random.uniform(-kPi, kPi));
  const bool trunk = random.uniform() < 0.15;
  const double ring = trunk ? 1.0 : std::sqrt(1.0 - z * z);
  const double radius = trunk ? 0.16 : (1.1 + 0.01 * (style % 60)) * random.uniform(0.85, 1.0);
  point.normal = Vector3(ring * cos_phi, ring * sin_phi, trunk ? 0.0 : z);
  const Vector3 crown = to_world(segment, along, side * (kHalfWidth - 1.7), 4.6);
  point.position = crown + radius * point.normal;
  if (trunk) point.position.z() = 1.6 + 1.5 * z;
  point.color = shade(trunk ? kTrunk : kLeaf, trunk ? 1.0 : 1.0 + 0.25 * z, random);
  point.region = segment;
  return true;
}

bool StreetScene::line_of_sight(int camera, const ScenePoint& point) const {
  const int from = segment_of_camera_[camera];
  const int to = point.region & ~(kTowerBit | kRightBit);
  const Vector3& c = cameras()[camera].center;
  if ((point.region & kTowerBit) != 0) {
    if (from != to) return false;
    const StreetSegment& s = route_.segments()[to];  // over the roof of the first row
    const int side = (point.region & kRightBit) != 0 ? -1 : 1;
    const Vector2 a = c.head<2>() - s.start;
    const Vector2 b = point.position.head<2>() - s.start;
    const double depth = a.dot(s.left);
    const double tau = (side * kHalfWidth - depth) / (b.dot(s.left) - depth);
    const double along = a.dot(s.direction) + tau * (b - a).dot(s.direction);
    return c.z() + tau * (point.position.z() - c.z()) > roof_height(to, side, along);
  }
  if (from == to) return true;
  // Round one corner: the inner edge of the crossing must not stand in the way.
  const int first = route_.next(from) == to ? from : to;
  if (route_.next(first) != (first == from ? to : from)) return false;
  const StreetSegment& in = route_.segments()[first];
  const StreetSegment& out = route_.segments()[route_.next(first)];
  const Vector2 edge = out.start + kHalfWidth * (out.direction - in.direction);
  Vector2 a = c.head<2>();
  Vector2 b = point.position.head<2>();
  if (first != from) std::swap(a, b);
  return in.turn_at_end * cross(b - a, edge - a) > 0.0;
}

}  // namespace raylign
