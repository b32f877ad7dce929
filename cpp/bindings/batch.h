// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <functional>
#include <numeric>
#include <string>
#include <vector>

#include "numpy.h"
#include "raylign/base/eigen.h"
#include "raylign/base/error.h"

/// NumPy arrays (..., item shape): any number of leading batch dimensions over vectors and
/// matrices.
namespace raylign::python {

namespace py = pybind11;

using F64Array = py::array_t<double, py::array::c_style>;
using Shape = std::vector<py::ssize_t>;

/// How a fixed-size Eigen type lies in a C-ordered array: column vectors (N,), matrices (R, C).
template <typename T>
struct Item {
  static constexpr int kRows = T::RowsAtCompileTime;
  static constexpr int kCols = T::ColsAtCompileTime;
  static constexpr int kSize = kRows * kCols;
  using Layout = RowMajor<kRows, kCols>;

  static Shape shape() { return kCols == 1 ? Shape{kRows} : Shape{kRows, kCols}; }
  static T load(const double* data) { return Eigen::Map<const Layout>(data); }
  static void store(const T& value, double* data) { Eigen::Map<Layout>{data} = value; }
};

namespace detail {

inline std::string shape_text(const Shape& item) {
  std::string text = "(...";
  for (const py::ssize_t size : item) text += ", " + std::to_string(size);
  return text + ")";
}

[[noreturn]] inline void fail(const std::string& name,
                              const Shape& item,
                              const py::object& object) {
  throw ShapeError(name + " must be an array of real numbers of shape " + shape_text(item) +
                   ", got " + describe_array(object));
}

inline bool has_trailing(const py::array& array, const Shape& item) {
  const auto dimensions = static_cast<std::size_t>(array.ndim());
  if (dimensions < item.size()) return false;
  return std::equal(item.begin(), item.end(), array.shape() + (dimensions - item.size()));
}

}  // namespace detail

/// float64, C order, trailing dimensions as `item`. Lists, other real dtypes and memory orders are
/// converted (exact but for 64-bit integers and long double); everything else is a ShapeError
/// naming the argument.
inline F64Array batch_from_numpy(const py::object& object,
                                 const Shape& item,
                                 const std::string& name) {
  const py::array array = py::array::ensure(object);
  // ensure() has cleared NumPy's own error, e.g. of a ragged list.
  if (!array) detail::fail(name, item, object);
  const char kind = array.dtype().kind();
  const bool is_real = kind == 'f' || kind == 'i' || kind == 'u';
  if (!is_real || !detail::has_trailing(array, item)) detail::fail(name, item, array);
  return py::array_t<double, py::array::c_style | py::array::forcecast>::ensure(array);
}

/// The leading dimensions of a batch.
inline Shape batch_shape(const py::array& batch, std::size_t item_dimensions) {
  return Shape(batch.shape(), batch.shape() + batch.ndim() - item_dimensions);
}

/// Their product.
inline py::ssize_t batch_size(const Shape& shape) {
  return std::accumulate(shape.begin(), shape.end(), py::ssize_t{1}, std::multiplies<>());
}

/// `batch` with `item` appended.
inline Shape join(Shape batch, const Shape& item) {
  batch.insert(batch.end(), item.begin(), item.end());
  return batch;
}

}  // namespace raylign::python
