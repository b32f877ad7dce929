// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "bindings.h"

PYBIND11_MODULE(_core, m) {
  m.doc() = "Compiled core of raylign. Private: import the façades of `raylign` instead.";
  m.attr("__version__") = RAYLIGN_VERSION;
  namespace rp = raylign::python;
  rp::bind_errors(m);
  rp::bind_build_info(m);
  rp::bind_geometry(m);
  rp::bind_camera(m);
  rp::bind_image(m);
  rp::bind_depth(m);
  rp::bind_robust(m);
  rp::bind_solver(m);
  rp::bind_scene(m);
  rp::bind_bundle_problem(m);
  rp::bind_io(m);
  rp::bind_synthetic(m);
  rp::bind_render(m);
  rp::bind_tracking(m);
  rp::bind_odometry(m);
  rp::bind_bundle(m);
  rp::bind_photometric_options(m);
  rp::bind_photometric(m);
}
