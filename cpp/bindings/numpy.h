// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <cstring>
#include <string>

#include "raylign/base/eigen.h"
#include "raylign/base/error.h"

namespace raylign::python {

namespace py = pybind11;

/// "float64 (49, 9), C order" or "list": what the caller gave, for messages.
inline std::string describe_array(const py::handle& object) {
  if (!py::isinstance<py::array>(object)) return py::str(py::type::of(object).attr("__name__"));
  const auto array = py::reinterpret_borrow<py::array>(object);
  std::string text =
      std::string(py::str(array.dtype())) + " " + std::string(py::str(array.attr("shape")));
  if ((array.flags() & py::array::c_style) == 0) text += ", not in C order";
  return text;
}

/// Copies a C-ordered (rows, Cols) array of exactly dtype T, or (rows,) for Cols = 1; anything else
/// is a ShapeError that says what was wanted and what came. Values are never converted.
template <typename T, int Cols>
Rows<T, Cols> rows_from_numpy(const py::handle& object, const std::string& name) {
  using Array = py::array_t<T, py::array::c_style>;
  constexpr int kDimensions = Cols == 1 ? 1 : 2;
  if (py::isinstance<Array>(object)) {
    const auto array = py::reinterpret_borrow<Array>(object);
    if (array.ndim() == kDimensions && (Cols == 1 || array.shape(1) == Cols)) {
      Rows<T, Cols> rows(array.shape(0), Cols);
      if (rows.size() > 0) std::memcpy(rows.data(), array.data(), rows.size() * sizeof(T));
      return rows;
    }
  }
  const std::string shape = Cols == 1 ? "(N,)" : "(N, " + std::to_string(Cols) + ")";
  throw ShapeError(name + " must be a C-ordered " + std::string(py::str(py::dtype::of<T>())) +
                   " array of shape " + shape + ", got " + describe_array(object) +
                   "; np.ascontiguousarray(…, dtype=np." +
                   std::string(py::str(py::dtype::of<T>())) + ") converts");
}

/// Writable NumPy view of `rows`, which must be a member of the C++ object behind `owner`; the view
/// keeps `owner` alive.
template <typename T, int Cols>
py::array_t<T> view_of(Rows<T, Cols>& rows, const py::handle& owner) {
  if constexpr (Cols == 1) {
    return py::array_t<T>(rows.rows(), rows.data(), owner);
  } else {
    return py::array_t<T>({rows.rows(), Eigen::Index{Cols}}, rows.data(), owner);
  }
}

}  // namespace raylign::python
