// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include "batch.h"
#include "bindings.h"
#include "image.h"
#include "options_binder.h"
#include "raylign/depth/depth_model.h"
#include "raylign/depth/inverse_depth.h"

namespace raylign::python {
namespace {

void bind_depth_noise(py::module_& m) {
  py::native_enum<DepthNoise>(m, "DepthNoise", "enum.Enum", "How the error of a depth Z grows.")
      .value("KINECT", DepthNoise::KINECT)
      .value("DISPARITY", DepthNoise::DISPARITY)
      .value("TIME_OF_FLIGHT", DepthNoise::TIME_OF_FLIGHT)
      .value("CONSTANT", DepthNoise::CONSTANT)
      .finalize();
}

F64Array inverse_depth_sigma(const DepthModel& model, const py::object& depth) {
  model.validate();
  const F64Array Z = batch_from_numpy(depth, {}, "depth");
  F64Array sigma(batch_shape(Z, 0));
  for (py::ssize_t i = 0; i < Z.size(); ++i) {
    sigma.mutable_data()[i] = model.inverse_depth_sigma(Z.data()[i]);
  }
  return sigma;
}

py::tuple inverse_depth(const py::object& depth, const DepthModel& model, double depth_scale) {
  const ImageView view = view_of_image(depth, "depth");
  InverseDepthConverter converter(model);
  const std::vector<py::ssize_t> shape = {view.height, view.width};
  py::array_t<float> D(shape), V(shape);
  float* out[] = {D.mutable_data(), V.mutable_data()};
  {
    const py::gil_scoped_release release;
    converter.convert(view, depth_scale, out[0], out[1]);
  }
  return py::make_tuple(D, V);
}

constexpr const char* kModelDoc =
    R"(What the numbers of a depth sensor are worth.

Standard deviation of a depth Z (m), s = sigma or the law's own value where it is 0: KINECT s (0.0012 +
0.0019 (Z - 0.4)²) m, s = 1 (Nguyen et al. 2012); DISPARITY s Z² / focal_baseline, s = 0.5 px;
TIME_OF_FLIGHT s, 0.01 m; CONSTANT s Z², 0.002 1/m.)";

}  // namespace

void bind_depth(py::module_& m) {
  bind_depth_noise(m);
  OptionsBinder<DepthModel> binder(m, "DepthModel", kModelDoc,
                                   [](const DepthModel& model) { model.validate(); });
  binder.field("noise", &DepthModel::noise, "DepthNoise.")
      .field("sigma", &DepthModel::sigma, "Size of the noise, >= 0; 0: the law's own.")
      .field("focal_baseline", &DepthModel::focal_baseline, "f b in px m, DISPARITY only, > 0.")
      .field("min_depth", &DepthModel::min_depth, "m, > 0; nearer is invalid.")
      .field("max_depth", &DepthModel::max_depth, "m, > min_depth; farther is invalid.")
      .field("edge_ratio", &DepthModel::edge_ratio,
             "Invalid where 1/Z varies within edge_radius by more than this part of it; 0: off.")
      .field("edge_radius", &DepthModel::edge_radius, "px, in [0, 16]; 0: off.");
  binder.finish().def("inverse_depth_sigma", &inverse_depth_sigma, py::arg("depth"),
                      "Standard deviation of 1/Z (1/m) at depth Z (m), (...) float64.");
  m.def("inverse_depth", &inverse_depth, py::arg("depth"), py::kw_only(), py::arg("model"),
        py::arg("depth_scale"));
}

}  // namespace raylign::python
