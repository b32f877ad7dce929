// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>

#include "bindings.h"
#include "numpy.h"
#include "raylign/base/error.h"
#include "raylign/image/remap.h"

namespace raylign::python {
namespace {

using FloatMap = py::array_t<float, py::array::c_style>;

std::optional<PixelType> pixel_type_of(const py::array& array) {
  if (py::isinstance<py::array_t<std::uint8_t>>(array)) return PixelType::UINT8;
  if (py::isinstance<py::array_t<std::uint16_t>>(array)) return PixelType::UINT16;
  if (py::isinstance<py::array_t<float>>(array)) return PixelType::FLOAT32;
  return std::nullopt;
}

// Rows may be apart (a crop), the pixels of a row may not.
bool has_dense_rows(const py::array& array, py::ssize_t channels) {
  const py::ssize_t pixel = channels * array.itemsize();
  if (array.ndim() == 3 && array.strides(2) != array.itemsize()) return false;
  const bool rows_follow = array.shape(0) == 1 || array.strides(0) >= pixel * array.shape(1);
  return array.strides(1) == pixel && rows_follow;
}

/// View of an (H, W) or (H, W, 3) array of uint8, uint16 or float32; valid while the array lives.
ImageView view_of_image(const py::object& object) {
  constexpr py::ssize_t kMax = std::numeric_limits<int>::max();
  if (py::isinstance<py::array>(object)) {
    const auto array = py::reinterpret_borrow<py::array>(object);
    const std::optional<PixelType> type = pixel_type_of(array);
    const bool is_color = array.ndim() == 3 && array.shape(2) == 3;
    const int channels = is_color ? 3 : 1;
    if (type && (array.ndim() == 2 || is_color) && array.shape(0) <= kMax &&
        array.shape(1) <= kMax && array.size() > 0 && has_dense_rows(array, channels)) {
      return {array.data(),
              *type,
              static_cast<int>(array.shape(1)),
              static_cast<int>(array.shape(0)),
              channels,
              static_cast<std::size_t>(array.shape(0) == 1 ? array.shape(1) * array.strides(1)
                                                           : array.strides(0))};
    }
  }
  throw ShapeError(
      "image must be a non-empty uint8, uint16 or float32 array of shape (H, W) or (H, W, 3) "
      "with dense rows, got " +
      describe_array(object));
}

Eigen::Map<const Rows<float, Eigen::Dynamic>> coordinate_map(const py::object& object,
                                                             const std::string& name) {
  if (py::isinstance<FloatMap>(object)) {
    const auto array = py::reinterpret_borrow<FloatMap>(object);
    if (array.ndim() == 2) return {array.data(), array.shape(0), array.shape(1)};
  }
  throw ShapeError(name + " must be a C-ordered float32 array of shape (H, W), got " +
                   describe_array(object));
}

py::dtype dtype_of(PixelType type) {
  switch (type) {
    case PixelType::UINT8:
      return py::dtype::of<std::uint8_t>();
    case PixelType::UINT16:
      return py::dtype::of<std::uint16_t>();
    case PixelType::FLOAT32:
      break;
  }
  return py::dtype::of<float>();
}

// The array takes the pixels over without a copy.
py::array to_numpy(Image image) {
  auto owner = std::make_unique<Image>(std::move(image));
  Image* raw = owner.get();
  std::vector<py::ssize_t> shape = {raw->height(), raw->width()};
  if (raw->channels() == 3) shape.push_back(3);
  const py::capsule base(raw, [](void* pointer) { delete static_cast<Image*>(pointer); });
  owner.release();
  return py::array(dtype_of(raw->type()), shape, raw->data(), base);
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
