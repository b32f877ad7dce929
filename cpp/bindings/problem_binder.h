// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/operators.h>
#include <pybind11/stl.h>

#include <string>
#include <vector>

#include "numpy.h"
#include "raylign/scene/bal_statistics.h"

/// What the classes of problems have in common in Python.
namespace raylign::python {

using Release = py::call_guard<py::gil_scoped_release>;

/// A read-only attribute that is a writable view of the member.
template <typename Problem, typename T, int Cols>
void def_view(py::class_<Problem>& cls,
              const char* name,
              Rows<T, Cols> Problem::* member,
              const char* doc) {
  cls.def_property_readonly(
      name,
      [member](const py::object& self) {
        return view_of<T, Cols>(self.cast<Problem&>().*member, self);
      },
      doc);
}

template <typename Problem>
std::string problem_repr(const Problem& problem, const std::string& name) {
  return "<" + name + ": " + std::to_string(problem.num_cameras()) + " cameras, " +
         std::to_string(problem.num_points()) + " points, " +
         std::to_string(problem.num_observations()) + " observations>";
}

using FieldNames = std::vector<std::string>;

/// The constructor's arguments by name: pickle and replace() go through the checking constructor.
inline py::dict problem_to_dict(const py::object& self, const FieldNames& fields) {
  py::dict values;
  for (const std::string& name : fields) values[name.c_str()] = self.attr(name.c_str());
  return values;
}

/// Points, observations, indices, colours and counts.
/// The arrays that `bind_tracks` shows, from what the caller gave; `colors` may be None.
template <typename Problem>
void set_tracks(Problem& problem,
                const py::object& points,
                const py::object& camera_index,
                const py::object& point_index,
                const py::object& observations,
                const py::object& colors) {
  problem.points = rows_from_numpy<double, 3>(points, "points");
  problem.camera_index = rows_from_numpy<std::int32_t, 1>(camera_index, "camera_index");
  problem.point_index = rows_from_numpy<std::int32_t, 1>(point_index, "point_index");
  problem.observations = rows_from_numpy<double, 2>(observations, "observations");
  if (!colors.is_none()) problem.colors = rows_from_numpy<std::uint8_t, 3>(colors, "colors");
}

template <typename Problem>
void bind_tracks(py::class_<Problem>& cls, const char* doc_of_observations) {
  def_view(cls, "points", &Problem::points, "(P, 3) float64 view: world frame, scene units.");
  def_view(cls, "camera_index", &Problem::camera_index, "(N,) int32 view: in [0, C).");
  def_view(cls, "point_index", &Problem::point_index, "(N,) int32 view: in [0, P).");
  def_view(cls, "observations", &Problem::observations, doc_of_observations);
  def_view(cls, "colors", &Problem::colors, "(P, 3) uint8 view: RGB; (0, 3) when unknown.");
  cls.def_property_readonly("num_cameras", &Problem::num_cameras, "C.");
  cls.def_property_readonly("num_points", &Problem::num_points, "P.");
  cls.def_property_readonly("num_observations", &Problem::num_observations, "N.");
}

/// ==, copies, replace(), to_dict() and pickle of a class whose constructor takes `fields`.
template <typename Problem>
void bind_value_semantics(py::class_<Problem>& cls, const FieldNames& fields) {
  cls.def(py::self == py::self);  // bitwise
  cls.def("copy", [](const Problem& self) { return Problem(self); }, "Deep copy.");
  cls.def("__copy__", [](const Problem& self) { return Problem(self); });
  cls.def("__deepcopy__", [](const Problem& self, const py::dict&) { return Problem(self); });
  cls.def(
      "to_dict", [fields](const py::object& self) { return problem_to_dict(self, fields); },
      "The constructor's arguments by name; arrays as views.");
  cls.def(
      "replace",
      [fields](const py::object& self, const py::kwargs& changes) {
        py::dict values = problem_to_dict(self, fields);
        for (auto item : changes) values[item.first] = item.second;
        return py::type::of(self)(**values);
      },
      "Copy with the given arguments changed; checked as in the constructor.");
  cls.def("__reduce__", [fields](const py::object& self) {
    return py::make_tuple(py::module_::import("raylign._pickle").attr("rebuild"),
                          py::make_tuple(py::type::of(self), problem_to_dict(self, fields)));
  });
  cls.def(
      "validate", &Problem::validate, Release(),
      "Raise ShapeError when lengths disagree or an index is out of range (views are writable).");
}

/// What is computed from the problem as it stands.
template <typename Problem>
void bind_reprojection(py::class_<Problem>& cls, const char* doc_of_residuals) {
  cls.def(
      "residuals", [](const Problem& self) { return reprojection_residuals(self); }, Release(),
      doc_of_residuals);
  cls.def(
      "cost", [](const Problem& self) { return reprojection_cost(self); }, Release(),
      "½ Σ ‖r‖² over all observations, px².");
  cls.def(
      "depths", [](const Problem& self) { return depths(self); }, Release(),
      "(N,) float64, scene units: along the viewing axis, positive in front.");
  cls.def(
      "statistics", [](const Problem& self) { return statistics(self); }, Release(),
      "Counts, track lengths, reprojection errors.");
  cls.def(
      "camera_centers", [](const Problem& self) { return camera_centers(self); }, Release(),
      "(C, 3) float64: c = −R_cwᵀ t_cw, world frame.");
}

}  // namespace raylign::python
