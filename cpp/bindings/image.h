// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <limits>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "numpy.h"
#include "raylign/base/error.h"
#include "raylign/image/grey.h"
#include "raylign/image/image.h"

/// Images across the border: NumPy arrays seen as ImageView, Image handed over as an array.
namespace raylign::python {

inline std::optional<PixelType> pixel_type_of(const py::array& array) {
  if (py::isinstance<py::array_t<std::uint8_t>>(array)) return PixelType::UINT8;
  if (py::isinstance<py::array_t<std::uint16_t>>(array)) return PixelType::UINT16;
  if (py::isinstance<py::array_t<float>>(array)) return PixelType::FLOAT32;
  return std::nullopt;
}

// Rows may be apart (a crop), the pixels of a row may not, and each stands where its type may.
inline bool has_dense_rows(const py::array& array, py::ssize_t channels) {
  const py::ssize_t pixel = channels * array.itemsize();
  if ((array.flags() & py::detail::npy_api::NPY_ARRAY_ALIGNED_) == 0) return false;
  if (array.ndim() == 3 && array.strides(2) != array.itemsize()) return false;
  const bool rows_follow = array.shape(0) == 1 || array.strides(0) >= pixel * array.shape(1);
  return array.strides(1) == pixel && rows_follow;
}

/// View of an (H, W) or (H, W, 3) array of uint8, uint16 or float32; valid while the array lives.
inline ImageView view_of_image(const py::object& object, const std::string& name = "image") {
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
      name +
      " must be a non-empty uint8, uint16 or float32 array of shape (H, W) or (H, W, 3) "
      "with dense, aligned rows, got " +
      describe_array(object));
}

/// View of an (H, W) float32 array; as above.
inline PlaneView<float> view_of_plane(const py::object& object, const std::string& name) {
  const ImageView view = view_of_image(object, name);
  if (view.type == PixelType::FLOAT32 && view.channels == 1) return plane_view(view);
  throw ShapeError(name + " must be a float32 array of shape (H, W), got " +
                   describe_array(object));
}

inline py::dtype dtype_of(PixelType type) {
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

/// The array takes the pixels over without a copy.
inline py::array to_numpy(Image image) {
  auto owner = std::make_unique<Image>(std::move(image));
  Image* raw = owner.get();
  std::vector<py::ssize_t> shape = {raw->height(), raw->width()};
  if (raw->channels() == 3) shape.push_back(3);
  const py::capsule base(raw, [](void* pointer) { delete static_cast<Image*>(pointer); });
  owner.release();
  return py::array(dtype_of(raw->type()), shape, raw->data(), base);
}

/// Read-only array that shows a plane in the C++ object behind `owner` and keeps it alive.
inline py::array view_of(const PlaneView<float>& plane, const py::handle& owner) {
  constexpr auto kFloat = static_cast<py::ssize_t>(sizeof(float));
  py::array array(py::dtype::of<float>(), {plane.height, plane.width},
                  {kFloat * plane.stride, kFloat}, plane.data, owner);
  array.attr("setflags")(py::arg("write") = false);
  return array;
}

/// The array takes the plane over without a copy; T is float or a struct of floats, which become
/// the last axis.
template <typename T>
py::array to_numpy(Plane<T> plane) {
  constexpr auto kFloats = static_cast<py::ssize_t>(sizeof(T) / sizeof(float));
  auto owner = std::make_unique<Plane<T>>(std::move(plane));
  Plane<T>* raw = owner.get();
  std::vector<py::ssize_t> shape = {raw->height(), raw->width()};
  if (kFloats > 1) shape.push_back(kFloats);
  const py::capsule base(raw, [](void* pointer) { delete static_cast<Plane<T>*>(pointer); });
  owner.release();
  return py::array(py::dtype::of<float>(), shape, raw->data(), base);
}

}  // namespace raylign::python
