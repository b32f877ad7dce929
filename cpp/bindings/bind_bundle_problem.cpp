// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include <string>

#include "bindings.h"
#include "problem_binder.h"
#include "raylign/scene/bundle_problem.h"

namespace raylign::python {
namespace {

BundleProblem make_problem(CameraModel camera_model,
                           const py::object& T_cw,
                           const py::object& intrinsics,
                           const py::object& points,
                           const py::object& camera_index,
                           const py::object& point_index,
                           const py::object& observations,
                           const py::object& colors) {
  BundleProblem problem;
  problem.camera_model = camera_model;
  problem.T_cw = table_from_numpy<Rows<double, 16>>(T_cw, "T_cw", {4, 4});
  problem.intrinsics = table_from_numpy<Rows<double, Eigen::Dynamic>>(intrinsics, "intrinsics",
                                                                      {num_params(camera_model)});
  set_tracks(problem, points, camera_index, point_index, observations, colors);
  problem.validate();
  return problem;
}

void bind_camera_model(py::module_& m) {
  py::native_enum<CameraModel>(m, "CameraModel", "enum.Enum", "The cameras by name.")
      .value("BAL", CameraModel::BAL, "f, k1, k2; looks along −z, v up.")
      .value("PINHOLE", CameraModel::PINHOLE, "fx, fy, cx, cy; looks along +z, v down.")
      .value("RADTAN", CameraModel::RADTAN,
             "Brown-Conrady: fx, fy, cx, cy, k1, k2, p1, p2, k3; looks along +z, v down.")
      .finalize();
  m.def("camera_param_names", &param_names, py::arg("camera_model"));
}

void bind_arrays(py::class_<BundleProblem>& cls) {
  cls.def_readonly("camera_model", &BundleProblem::camera_model, "CameraModel of all cameras.");
  cls.def_property_readonly(
      "T_cw",
      [](const py::object& self) {
        Rows<double, 16>& poses = self.cast<BundleProblem&>().T_cw;
        return py::array_t<double>({poses.rows(), Eigen::Index{4}, Eigen::Index{4}}, poses.data(),
                                   self);
      },
      "(C, 4, 4) float64 view: p_c = T_cw p_w, axes of the camera model.");
  def_view(cls, "intrinsics", &BundleProblem::intrinsics,
           "(C, m) float64 view: parameters of each camera in the order of its class.");
  bind_tracks(cls, "(N, 2) float64 view: pixels of the camera model.");
}

}  // namespace

void bind_bundle_problem(py::module_& m) {
  bind_camera_model(m);
  py::class_<BundleProblem> cls(
      m, "BundleProblem",
      "A reprojection problem with cameras of one model, each with its own pose and intrinsics.\n\n"
      "The arrays are writable views that keep the problem alive; their shapes are fixed. The "
      "constructor copies and refuses (ShapeError) a wrong dtype, shape, memory order or index and "
      "a T_cw that is not rigid (to 1e-5).");
  cls.def(py::init(&make_problem), py::arg("camera_model"), py::arg("T_cw"), py::arg("intrinsics"),
          py::arg("points"), py::arg("camera_index"), py::arg("point_index"),
          py::arg("observations"), py::kw_only(), py::arg("colors") = py::none());
  bind_arrays(cls);
  bind_value_semantics(cls, {"camera_model", "T_cw", "intrinsics", "points", "camera_index",
                             "point_index", "observations", "colors"});
  bind_reprojection(
      cls,
      "(N, 2) float64, px: predicted − observed; NaN where the camera cannot project: PINHOLE and "
      "RADTAN behind it or in its plane, RADTAN beyond the fold of its distortion, BAL in its "
      "plane only.");
  cls.def("__repr__", [](const BundleProblem& self) {
    return problem_repr(self, "BundleProblem " + to_string(self.camera_model));
  });
  cls.def_static(
      "from_bal", &to_bundle_problem, Release(), py::arg("problem"), py::kw_only(),
      py::arg("camera_model"),
      "The same problem, the same cost. BAL keeps axes and numbers; RADTAN and PINHOLE "
      "look along +z, v down, principal point at pixel (0, 0). OptionsError when PINHOLE "
      "is asked for and a camera has distortion.");
  cls.def("to_bal", &to_bal_problem, Release(),
          "The same problem as a BalProblem. OptionsError when fx and fy differ or p1, p2 or k3 is "
          "not zero.");
}

}  // namespace raylign::python
