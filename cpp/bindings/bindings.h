// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

/// One function per module of the library; module.cpp calls them in the order of the layer rule.
namespace raylign::python {

void bind_errors(pybind11::module_& m);
void bind_build_info(pybind11::module_& m);
void bind_geometry(pybind11::module_& m);
void bind_camera(pybind11::module_& m);
void bind_image(pybind11::module_& m);
void bind_depth(pybind11::module_& m);
void bind_robust(pybind11::module_& m);
void bind_solver(pybind11::module_& m);
void bind_scene(pybind11::module_& m);
void bind_bundle_problem(pybind11::module_& m);
void bind_io(pybind11::module_& m);
void bind_synthetic(pybind11::module_& m);
void bind_render(pybind11::module_& m);
void bind_tracking(pybind11::module_& m);
void bind_odometry(pybind11::module_& m);
void bind_bundle(pybind11::module_& m);
void bind_photometric_options(pybind11::module_& m);
void bind_photometric(pybind11::module_& m);

}  // namespace raylign::python
