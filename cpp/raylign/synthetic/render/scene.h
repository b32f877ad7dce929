// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <memory>
#include <vector>

#include "raylign/base/eigen.h"
#include "raylign/synthetic/render/height_field.h"
#include "raylign/synthetic/render/surface.h"
#include "raylign/synthetic/render/texture.h"

namespace raylign {

/// Textured surfaces in a world frame, all opaque and Lambertian under even light: a point has the
/// same grey value from everywhere. The add_ functions throw OptionsError for a size that is not
/// positive or a T_ws (surface to world) that is no rigid transform.
class RenderScene {
 public:
  /// Surface and texture of one face, and where they stand.
  struct Face {
    std::shared_ptr<const render::Texture> texture;
    Matrix3 R_xw;  ///< texture coordinates = R_xw p_w + t_xw; the third row is zero on flat faces
    Vector3 t_xw;
    int surface;
    int index;  ///< among the faces of the surface
  };
  struct Placed {
    std::shared_ptr<const render::Surface> surface;
    Matrix3 R_sw;
    Vector3 t_sw;
    int first_face;
  };

  /// A box (size along x, y, z) around the origin of s; seen from inside it is a room. Six faces.
  void add_box(const Matrix4& T_ws, const Vector3& size, const TextureOptions& texture);
  /// The rectangle z = 0 of s, centred; infinite sides are allowed.
  void add_rectangle(const Matrix4& T_ws,
                     double width,
                     double height,
                     const TextureOptions& texture);
  void add_sphere(const Matrix4& T_ws, double radius, const TextureOptions& texture);
  void add_height_field(const Matrix4& T_ws,
                        const HeightFieldOptions& options,
                        const TextureOptions& texture);
  /// Everything in `other`, in its order.
  void add(const RenderScene& other);

  /// Grey value of the texture of a face at a world point (projected along the normal of a flat
  /// face), and its gradient by the point: closed form.
  double grey_value(int face, const Vector3& p_w, Vector3* gradient = nullptr) const;

  const std::vector<Placed>& surfaces() const { return surfaces_; }
  const std::vector<Face>& faces() const { return faces_; }

 private:
  void place(std::shared_ptr<const render::Surface> surface,
             const Matrix4& T_ws,
             const TextureOptions& texture);

  std::vector<Placed> surfaces_;
  std::vector<Face> faces_;
};

}  // namespace raylign
