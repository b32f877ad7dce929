// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <utility>

#include "bindings.h"
#include "options_binder.h"
#include "problem_binder.h"
#include "raylign/scene/bal_problem.h"
#include "raylign/scene/bal_statistics.h"
#include "raylign/scene/bal_transform.h"

namespace raylign::python {
namespace {

BalProblem make_problem(const py::object& cameras,
                        const py::object& points,
                        const py::object& camera_index,
                        const py::object& point_index,
                        const py::object& observations,
                        const py::object& colors) {
  BalProblem problem;
  problem.cameras = rows_from_numpy<double, 9>(cameras, "cameras");
  set_tracks(problem, points, camera_index, point_index, observations, colors);
  problem.validate();
  return problem;
}

void bind_arrays(py::class_<BalProblem>& cls) {
  def_view(cls, "cameras", &BalProblem::cameras,
           "(C, 9) float64 view: angle-axis of R_cw (rad), t_cw (scene units), f (px), k1, k2.");
  bind_tracks(cls, "(N, 2) float64 view: pixels, principal point at the origin, v up.");
}

void bind_geometry_of_problem(py::class_<BalProblem>& cls) {
  bind_reprojection(
      cls,
      "(N, 2) float64, px: predicted − observed, without a cheirality test; NaN where the camera "
      "cannot project at all.");
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
      .field("num_non_positive_focal", &S::num_non_positive_focal, "Cameras with f, fx or fy <= 0.")
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
  bind_value_semantics(
      cls, {"cameras", "points", "camera_index", "point_index", "observations", "colors"});
  cls.def("__repr__", [](const BalProblem& self) { return problem_repr(self, "BalProblem"); });
  bind_geometry_of_problem(cls);
}

}  // namespace raylign::python
