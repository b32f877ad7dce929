// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/base/eigen.h"
#include "raylign/scene/bundle_scene.h"

namespace raylign {

/// Where homogeneous coordinates [x̃; w̃] are taken: X = center + scale · x̃ / w̃. A unit 4-vector
/// mixes lengths with a pure number, so it is well-conditioned only in units of the cameras' own
/// extent.
struct HomogeneousFrame {
  Vector3 center = Vector3::Zero();
  double scale = 1.0;

  /// Unit 4-vector of a world point, w̃ > 0.
  Vector4 from_world(const Vector3& X) const;
  /// A problem has no points at infinity: they come out 1e12 scales away, where the pixel is the
  /// same to about 1e-9 px.
  Vector3 to_world(const Vector4& x) const;
  /// w̃, but never nearer to zero than 1e-12.
  static double bounded_weight(double w);
};

/// Center and root-mean-square extent of the cameras; where they all stand in one place, the median
/// distance of the points; 1 when that is zero too.
HomogeneousFrame homogeneous_frame(const BundleScene& scene);

/// The unit sphere of R⁴ at x, with the Householder basis that Ceres' SphereManifold takes
/// (Hertzberg et al. 2013, App. B.2): H = I − β v vᵀ, H x = e₄, plus(δ) = H [½ sinc(‖δ‖ / 2) δ;
/// cos(‖δ‖ / 2)].
class SphereTangent {
 public:
  explicit SphereTangent(const Vector4& x);

  /// ∂ plus / ∂δ at δ = 0: half of the first three columns of H, (4, 3).
  RowMajor<4, 3> basis() const;
  Vector4 plus(const Vector3& delta) const;

 private:
  Vector4 v_;
  double beta_;
};

}  // namespace raylign
