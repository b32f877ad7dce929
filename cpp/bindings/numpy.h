// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>

#include <algorithm>
#include <cstring>
#include <string>
#include <vector>

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

/// A C-ordered array of exactly dtype T whose rows have the shape `record`, {} for numbers;
/// anything else is a ShapeError that says what was wanted and what came. Values are never
/// converted.
template <typename T>
py::array_t<T, py::array::c_style> records_from_numpy(const py::handle& object,
                                                      const std::string& name,
                                                      const std::vector<py::ssize_t>& record) {
  using Array = py::array_t<T, py::array::c_style>;
  if (py::isinstance<Array>(object)) {
    const auto array = py::reinterpret_borrow<Array>(object);
    const auto num_dimensions = static_cast<py::ssize_t>(record.size()) + 1;
    if (array.ndim() == num_dimensions &&
        std::equal(record.begin(), record.end(), array.shape() + 1)) {
      return array;
    }
  }
  std::string shape = "(N";
  for (const py::ssize_t size : record) shape += ", " + std::to_string(size);
  shape += record.empty() ? ",)" : ")";
  throw ShapeError(name + " must be a C-ordered " + std::string(py::str(py::dtype::of<T>())) +
                   " array of shape " + shape + ", got " + describe_array(object) +
                   "; np.ascontiguousarray(…, dtype=np." +
                   std::string(py::str(py::dtype::of<T>())) + ") converts");
}

/// Copies such an array into a table with one record per row.
template <typename Table>
Table table_from_numpy(const py::handle& object,
                       const std::string& name,
                       const std::vector<py::ssize_t>& record) {
  using T = typename Table::Scalar;
  const auto array = records_from_numpy<T>(object, name, record);
  py::ssize_t columns = 1;
  for (const py::ssize_t size : record) columns *= size;
  Table table(array.shape(0), columns);
  if (table.size() > 0) std::memcpy(table.data(), array.data(), table.size() * sizeof(T));
  return table;
}

/// Copies a C-ordered (rows, Cols) array of exactly dtype T, or (rows,) for Cols = 1.
template <typename T, int Cols>
Rows<T, Cols> rows_from_numpy(const py::handle& object, const std::string& name) {
  const std::vector<py::ssize_t> record(Cols == 1 ? 0 : 1, Cols);
  return table_from_numpy<Rows<T, Cols>>(object, name, record);
}

/// Writable NumPy view of `rows`, which must be a member of the C++ object behind `owner`; the view
/// keeps `owner` alive.
template <typename T, int Cols>
py::array_t<T> view_of(Rows<T, Cols>& rows, const py::handle& owner) {
  if constexpr (Cols == 1) {
    return py::array_t<T>(rows.rows(), rows.data(), owner);
  } else {
    return py::array_t<T>({rows.rows(), rows.cols()}, rows.data(), owner);
  }
}

}  // namespace raylign::python
