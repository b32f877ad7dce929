// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/render/surface.h"

#include <algorithm>
#include <cmath>
#include <limits>

namespace raylign::render {
namespace {

constexpr double kInfinity = std::numeric_limits<double>::infinity();

void keep_nearest(double t, int face, int i, Hits& hits) {
  if (t > kNearest && t < hits.t[i]) {
    hits.t[i] = t;
    hits.face[i] = face;
  }
}

// Texture coordinates of the face ⟂ axis: the two other axes.
Matrix3 drop_axis(int axis) {
  Matrix3 map = Matrix3::Zero();
  map(0, (axis + 1) % 3) = 1.0;
  map(1, (axis + 2) % 3) = 1.0;
  return map;
}

class Box : public Surface {
 public:
  explicit Box(const Vector3& size) : half_(0.5 * size) {}

  int num_faces() const override { return 6; }
  void normals(int face, int size, const Vector3*, Vector3* out) const override {
    std::fill_n(out, size, Vector3::Unit(face / 2));
  }
  Matrix3 texture_map(int face) const override { return drop_axis(face / 2); }

  // Slabs (Kay & Kajiya, SIGGRAPH 1986): in from the last of three planes, out at the first.
  void intersect(const Rays& rays, int first_face, Hits& hits) const override {
    for (int i = 0; i < rays.size; ++i) {
      double enter = -kInfinity, leave = kInfinity;
      int enter_face = 0, leave_face = 0;
      for (int axis = 0; axis < 3; ++axis) {
        const double d = rays.direction[i][axis];
        const double o = rays.origin[axis];
        const int upper = std::signbit(d) ? 0 : 1;  // a zero, too, has a side: ±h / ±0 = +∞
        const double out = ((upper ? half_[axis] : -half_[axis]) - o) / d;
        const double in = ((upper ? -half_[axis] : half_[axis]) - o) / d;
        if (in > enter) {
          enter = in;
          enter_face = 2 * axis + 1 - upper;
        }
        if (out < leave) {
          leave = out;
          leave_face = 2 * axis + upper;
        }
      }
      if (!(enter <= leave)) continue;
      const bool is_outside = enter > kNearest;
      keep_nearest(is_outside ? enter : leave, first_face + (is_outside ? enter_face : leave_face),
                   i, hits);
    }
  }

 private:
  Vector3 half_;
};

class Rectangle : public Surface {
 public:
  Rectangle(double width, double height) : half_width_(0.5 * width), half_height_(0.5 * height) {}

  int num_faces() const override { return 1; }
  void normals(int, int size, const Vector3*, Vector3* out) const override {
    std::fill_n(out, size, Vector3::UnitZ());
  }
  Matrix3 texture_map(int) const override { return Vector3(1.0, 1.0, 0.0).asDiagonal(); }

  void intersect(const Rays& rays, int first_face, Hits& hits) const override {
    const Vector3& o = rays.origin;
    for (int i = 0; i < rays.size; ++i) {
      const Vector3& d = rays.direction[i];
      const double t = -o.z() / d.z();
      const bool is_inside =
          std::abs(o.x() + t * d.x()) <= half_width_ && std::abs(o.y() + t * d.y()) <= half_height_;
      if (is_inside) keep_nearest(t, first_face, i, hits);
    }
  }

 private:
  double half_width_, half_height_;
};

class Sphere : public Surface {
 public:
  explicit Sphere(double radius) : radius_(radius) {}

  int num_faces() const override { return 1; }
  void normals(int, int size, const Vector3* p, Vector3* out) const override {
    std::copy_n(p, size, out);
  }
  Matrix3 texture_map(int) const override { return Matrix3::Identity(); }
  TextureSpace texture_space() const override { return TextureSpace::SOLID; }

  // Roots of d·d t² + 2 o·d t + o·o − r², the one without cancellation first.
  void intersect(const Rays& rays, int first_face, Hits& hits) const override {
    const Vector3& o = rays.origin;
    const double c = o.squaredNorm() - radius_ * radius_;
    for (int i = 0; i < rays.size; ++i) {
      const Vector3& d = rays.direction[i];
      const double a = d.squaredNorm();
      const double b = o.dot(d);
      // b² − a c without the cancellation of large squares: a (r² − ‖o − (b / a) d‖²).
      const double discriminant = a * (radius_ * radius_ - (o - (b / a) * d).squaredNorm());
      if (!(discriminant >= 0.0)) continue;
      const double q = -(b + std::copysign(std::sqrt(discriminant), b));
      const double t1 = q / a, t2 = c / q;
      const double nearer = std::min(t1, t2);
      keep_nearest(nearer > kNearest ? nearer : std::max(t1, t2), first_face, i, hits);
    }
  }

 private:
  double radius_;
};

}  // namespace

std::shared_ptr<const Surface> make_box(const Vector3& size) { return std::make_shared<Box>(size); }

std::shared_ptr<const Surface> make_rectangle(double width, double height) {
  return std::make_shared<Rectangle>(width, height);
}

std::shared_ptr<const Surface> make_sphere(double radius) {
  return std::make_shared<Sphere>(radius);
}

}  // namespace raylign::render
