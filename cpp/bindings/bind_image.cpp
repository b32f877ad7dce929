// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include <string>

#include "bindings.h"
#include "image.h"
#include "numpy.h"
#include "raylign/base/error.h"
#include "raylign/image/remap.h"

namespace raylign::python {
namespace {

using FloatMap = py::array_t<float, py::array::c_style>;

Eigen::Map<const Rows<float, Eigen::Dynamic>> coordinate_map(const py::object& object,
                                                             const std::string& name) {
  if (py::isinstance<FloatMap>(object)) {
    const auto array = py::reinterpret_borrow<FloatMap>(object);
    if (array.ndim() == 2) return {array.data(), array.shape(0), array.shape(1)};
  }
  throw ShapeError(name + " must be a C-ordered float32 array of shape (H, W), got " +
                   describe_array(object));
}

py::array remap_array(const py::object& image,
                      const py::object& map_x,
                      const py::object& map_y,
                      Interpolation interpolation) {
  const ImageView view = view_of_image(image);
  const auto x = coordinate_map(map_x, "map_x");
  const auto y = coordinate_map(map_y, "map_y");
  Image result;
  {
    const py::gil_scoped_release release;
    result = remap(view, x, y, interpolation);
  }
  return to_numpy(std::move(result));
}

}  // namespace

void bind_image(py::module_& m) {
  py::native_enum<Interpolation>(m, "Interpolation", "enum.Enum", "How remap reads between pixels.")
      .value("NEAREST", Interpolation::NEAREST)
      .value("LINEAR", Interpolation::LINEAR)
      .value("CUBIC", Interpolation::CUBIC)
      .finalize();
  m.def("remap", &remap_array, py::arg("image"), py::arg("map_x"), py::arg("map_y"), py::kw_only(),
        py::arg("interpolation"));
}

}  // namespace raylign::python
