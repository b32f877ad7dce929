// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/stl.h>

#include <string>
#include <string_view>

#include "bindings.h"
#include "raylign/io/bal.h"
#include "raylign/io/ply.h"

namespace raylign::python {
namespace {

namespace py = pybind11;
using Release = py::call_guard<py::gil_scoped_release>;

void bind_bal(py::module_& m) {
  m.def(
      "read_bal",
      [](const std::string& path, const std::string& duplicates) {
        return read_bal(path, parse_duplicate_policy(duplicates));
      },
      Release(), py::arg("path"), py::kw_only(), py::arg("duplicates"));
  m.def(
      "parse_bal",
      [](const py::bytes& text, const std::string& name, const std::string& duplicates) {
        const std::string_view view = text;  // `text` is held by the caller: safe without the GIL
        const py::gil_scoped_release release;
        return parse_bal(view, name, parse_duplicate_policy(duplicates));
      },
      py::arg("text"), py::kw_only(), py::arg("name"), py::arg("duplicates"));
  m.def("write_bal", &write_bal, Release(), py::arg("problem"), py::arg("path"));
  m.def(
      "format_bal", [](const BalProblem& problem) { return py::bytes(format_bal(problem)); },
      py::arg("problem"));
}

py::tuple to_tuple(const PlySummary& summary) {
  return py::make_tuple(summary.num_points, summary.num_cameras, summary.num_skipped_points,
                        summary.num_skipped_cameras);
}

void bind_ply(py::module_& m) {
  m.def(
      "write_ply",
      [](const BalProblem& problem, const std::string& path, bool cameras, double camera_scale,
         const Rgb& camera_color, const Rgb& point_color) {
        const PlyOptions options{cameras, camera_scale, camera_color, point_color};
        py::gil_scoped_release release;
        const PlySummary summary = write_ply(problem, path, options);
        py::gil_scoped_acquire acquire;
        return to_tuple(summary);
      },
      py::arg("problem"), py::arg("path"), py::kw_only(), py::arg("cameras"),
      py::arg("camera_scale"), py::arg("camera_color"), py::arg("point_color"));
}

}  // namespace

void bind_io(py::module_& m) {
  bind_bal(m);
  bind_ply(m);
}

}  // namespace raylign::python
