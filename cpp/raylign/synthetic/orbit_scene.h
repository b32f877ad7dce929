// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include "raylign/synthetic/bal_scene.h"

namespace raylign {

/// A photo collection around a rotunda: steps, colonnade, drum, dome and lantern (a surface of
/// revolution with windows and ribs) on a paved plaza with cypresses. Rings of cameras look
/// inwards.
class OrbitScene : public BalScene {
 public:
  explicit OrbitScene(const SyntheticBalOptions& options);

  bool sample(int camera, RandomStream& random, ScenePoint& point) const override;
  bool line_of_sight(int camera, const ScenePoint& point) const override;

 private:
  double max_distance_;
};

}  // namespace raylign
