// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/synthetic/render/texture.h"

namespace raylign::render {

/// Rays from one centre, in any one frame: point = origin + t · direction. In the camera frame the
/// directions have z = 1, so t is the depth.
struct Rays {
  int size = 0;
  Vector3 origin = Vector3::Zero();
  const Vector3* direction = nullptr;
};

/// What a ray met first, in the frame of the surface it was asked of.
struct Hits {
  double* t = nullptr;  ///< infinite: nothing yet
  int* face = nullptr;  ///< face of the scene, −1: nothing yet
};

/// Points nearer than this part of the scene unit along a ray are not seen: the camera itself.
inline constexpr double kNearest = 1e-9;

/// A textured surface in its own frame. Immutable.
class Surface {
 public:
  virtual ~Surface() = default;

  virtual int num_faces() const = 0;
  /// Updates the hits of rays that meet this surface nearer than before; its faces are numbered
  /// from first_face.
  virtual void intersect(const Rays& rays, int first_face, Hits& hits) const = 0;
  /// Normals at points of a face, of either sense and any length.
  virtual void normals(int face, int size, const Vector3* p, Vector3* out) const = 0;
  /// Texture coordinates = map · p.
  virtual Matrix3 texture_map(int face) const = 0;
  virtual TextureSpace texture_space() const { return TextureSpace::PLANE; }
};

/// Axis-parallel box around the origin, six faces (−x, +x, −y, +y, −z, +z), seen from outside or,
/// a room, from inside.
std::shared_ptr<const Surface> make_box(const Vector3& size);
/// The rectangle z = 0, |x| <= width / 2, |y| <= height / 2; sides may be infinite.
std::shared_ptr<const Surface> make_rectangle(double width, double height);
/// Sphere around the origin, seen from outside or inside.
std::shared_ptr<const Surface> make_sphere(double radius);

}  // namespace raylign::render
