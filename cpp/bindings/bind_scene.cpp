// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/eigen.h>
#include <pybind11/numpy.h>
#include <pybind11/operators.h>

#include <string>
#include <tuple>
#include <utility>

#include "bindings.h"
#include "numpy.h"
#include "options_binder.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/scene/bal_statistics.h"
#include "raylign/scene/bal_transform.h"

namespace raylign::python {
namespace {

using Release = py::call_guard<py::gil_scoped_release>;

BalProblem make_problem(const py::object& cameras,
                        const py::object& points,
                        const py::object& camera_index,
                        const py::object& point_index,
                        const py::object& observations,
                        const py::object& colors) {
  BalProblem problem;
  problem.cameras = rows_from_numpy<double, 9>(cameras, "cameras");
  problem.points = rows_from_numpy<double, 3>(points, "points");
  problem.camera_index = rows_from_numpy<std::int32_t, 1>(camera_index, "camera_index");
  problem.point_index = rows_from_numpy<std::int32_t, 1>(point_index, "point_index");
  problem.observations = rows_from_numpy<double, 2>(observations, "observations");
  if (!colors.is_none()) problem.colors = rows_from_numpy<std::uint8_t, 3>(colors, "colors");
  problem.validate();
  return problem;
}

// The constructor's arguments by name: pickle and replace() go through the checking constructor.
py::dict to_dict(const py::object& self) {
  py::dict arrays;
  for (const char* name :
       {"cameras", "points", "camera_index", "point_index", "observations", "colors"}) {
    arrays[name] = self.attr(name);
  }
  return arrays;
}

py::object replace(const py::object& self, const py::kwargs& changes) {
  py::dict arrays = to_dict(self);
  for (auto item : changes) arrays[item.first] = item.second;
  return py::type::of(self)(**arrays);
}

std::string repr(const BalProblem& problem) {
  return "<BalProblem: " + std::to_string(problem.num_cameras()) + " cameras, " +
         std::to_string(problem.num_points()) + " points, " +
         std::to_string(problem.num_observations()) + " observations>";
}

template <typename T, int Cols>
void def_view(py::class_<BalProblem>& cls,
              const char* name,
              Rows<T, Cols> BalProblem::* member,
              const char* doc) {
  cls.def_property_readonly(
      name,
      [member](const py::object& self) {
        return view_of<T, Cols>(self.cast<BalProblem&>().*member, self);
      },
      doc);
}

void bind_arrays(py::class_<BalProblem>& cls) {
  def_view(cls, "cameras", &BalProblem::cameras,
           "(C, 9) float64 view: angle-axis of R_cw (rad), t_cw (scene units), f (px), k1, k2.");
  def_view(cls, "points", &BalProblem::points, "(P, 3) float64 view: world frame, scene units.");
  def_view(cls, "camera_index", &BalProblem::camera_index, "(N,) int32 view: in [0, C).");
  def_view(cls, "point_index", &BalProblem::point_index, "(N,) int32 view: in [0, P).");
  def_view(cls, "observations", &BalProblem::observations,
           "(N, 2) float64 view: pixels, principal point at the origin, v up.");
  def_view(cls, "colors", &BalProblem::colors, "(P, 3) uint8 view: RGB; (0, 3) when unknown.");
  cls.def_property_readonly("num_cameras", &BalProblem::num_cameras, "C.");
  cls.def_property_readonly("num_points", &BalProblem::num_points, "P.");
  cls.def_property_readonly("num_observations", &BalProblem::num_observations, "N.");
}

void bind_value_semantics(py::class_<BalProblem>& cls) {
  cls.def(py::self == py::self);  // bitwise
  cls.def("copy", [](const BalProblem& self) { return BalProblem(self); }, "Deep copy.");
  cls.def("__copy__", [](const BalProblem& self) { return BalProblem(self); });
  cls.def("__deepcopy__", [](const BalProblem& self, const py::dict&) { return BalProblem(self); });
  cls.def("__repr__", &repr);
  cls.def("to_dict", &to_dict, "The six arrays by name, as views.");
  cls.def("replace", &replace,
          "Copy with the given arrays changed; checked as in the constructor.");
  cls.def("__reduce__", [](const py::object& self) {
    return py::make_tuple(py::module_::import("raylign._pickle").attr("rebuild"),
                          py::make_tuple(py::type::of(self), to_dict(self)));
  });
}

void bind_geometry_of_problem(py::class_<BalProblem>& cls) {
  cls.def(
      "residuals", &reprojection_residuals, Release(),
      "(N, 2) float64, px: predicted − observed, without a cheirality test; NaN where the camera "
      "cannot project at all.");
  cls.def("depths", &depths, Release(), "(N,) float64, scene units: −P_z, positive in front.");
  cls.def("cost", &reprojection_cost, Release(), "½ Σ ‖r‖² over all observations, px².");
  cls.def("statistics", &statistics, Release(), "Counts, track lengths, reprojection errors.");
  cls.def("camera_centers", &camera_centers, Release(),
          "(C, 3) float64: c = −R_cwᵀ t_cw, world frame.");
  cls.def(
      "T_cw",
      [](const BalProblem& self) {
        return py::cast(camera_poses(self)).cast<py::array>().reshape({-1, 4, 4});
      },
      "(C, 4, 4) float64: p_c = T_cw p_w, camera axes of the file (looks along −z).");
  cls.def(
      "normalized",
      [](const BalProblem& self, double extent) {
        NormalizedProblem result = normalize(self, extent);
        return std::make_pair(std::move(result.problem), RowMajor<4, 4>(result.S_nw));
      },
      py::kw_only(), py::arg("extent") = 100.0,
      "(problem, S_nw): median of the points at 0, median L1 distance from it `extent`. "
      "Undo with `transformed(np.linalg.inv(S_nw))`; exact to rounding.");
  cls.def(
      "transformed", &transform, Release(), py::arg("S_nw"),
      "Problem in the world coordinates X' = S_nw X, S_nw (4, 4) = [s R, t; 0, 1]; same pixels. "
      "ShapeError when S_nw is not a similarity.");
  cls.def(
      "validate", &BalProblem::validate, Release(),
      "Raise ShapeError when lengths disagree or an index is out of range (views are writable).");
}

void bind_count_summary(py::module_& m) {
  OptionsBinder<CountSummary>(m, "CountSummary", "Order statistics of a list of counts.", nullptr)
      .field("min", &CountSummary::min, "Smallest.")
      .field("median", &CountSummary::median, "Middle, or mean of the two middle ones.")
      .field("mean", &CountSummary::mean, "Mean.")
      .field("max", &CountSummary::max, "Largest.")
      .finish();
}

void bind_statistics(py::module_& m) {
  using S = ProblemStatistics;
  OptionsBinder<S>(m, "ProblemStatistics", "What a problem looks like before it is solved.",
                   nullptr)
      .field("num_cameras", &S::num_cameras, "C.")
      .field("num_points", &S::num_points, "P.")
      .field("num_observations", &S::num_observations, "N.")
      .field("observations_per_camera", &S::observations_per_camera, "Over all cameras.")
      .field("observations_per_point", &S::observations_per_point, "Track length, over all points.")
      .field("track_length_histogram", &S::track_length_histogram, "[k] = points seen k times.")
      .field("cost", &S::cost, "½ Σ ‖r‖² of the finite residuals, px².")
      .field("rmse", &S::rmse, "√(Σ ‖r‖² / (2 N)), px per coordinate.")
      .field("median_error", &S::median_error, "Median of ‖r‖, px.")
      .field("max_error", &S::max_error, "Maximum of ‖r‖, px.")
      .field("num_behind_camera", &S::num_behind_camera, "Observations with depth <= 0.")
      .field("num_non_finite", &S::num_non_finite, "Observations with a NaN or infinite residual.")
      .field("num_unobserved_cameras", &S::num_unobserved_cameras, "Cameras never used.")
      .field("num_unobserved_points", &S::num_unobserved_points, "Points never seen.")
      .field("num_underconstrained_points", &S::num_underconstrained_points, "Seen < 2 times.")
      .field("num_underconstrained_cameras", &S::num_underconstrained_cameras, "See < 3 points.")
      .field("num_duplicate_observations", &S::num_duplicate_observations,
             "Repeats of an earlier (camera, point) pair.")
      .field("num_non_positive_focal", &S::num_non_positive_focal, "Cameras with f <= 0.")
      .finish();
}

}  // namespace

void bind_scene(py::module_& m) {
  bind_count_summary(m);
  bind_statistics(m);
  py::class_<BalProblem> cls(
      m, "BalProblem",
      "A Bundle-Adjustment-in-the-Large problem (Agarwal et al., ECCV 2010) as six arrays.\n\n"
      "The arrays are writable views that keep the problem alive; their shapes are fixed. The "
      "constructor copies and refuses (ShapeError) a wrong dtype, shape, memory order or index.");
  cls.def(py::init(&make_problem), py::arg("cameras"), py::arg("points"), py::arg("camera_index"),
          py::arg("point_index"), py::arg("observations"), py::kw_only(),
          py::arg("colors") = py::none());
  bind_arrays(cls);
  bind_value_semantics(cls);
  bind_geometry_of_problem(cls);
}

}  // namespace raylign::python
