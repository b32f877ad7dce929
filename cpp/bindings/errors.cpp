// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/base/error.h"

#include "bindings.h"

namespace raylign::python {
namespace {

namespace py = pybind11;

// Exception types live as long as the interpreter: leaked on purpose, as pybind11 itself does.
PyObject* g_format_error = nullptr;

PyObject* add_exception(py::module_& m, const char* name, const py::tuple& bases, const char* doc) {
  const std::string qualified = std::string("raylign.errors.") + name;
  PyObject* type = PyErr_NewExceptionWithDoc(qualified.c_str(), doc, bases.ptr(), nullptr);
  if (type == nullptr) throw py::error_already_set();
  m.attr(name) = py::reinterpret_borrow<py::object>(type);
  return type;
}

void set_format_error(const FormatError& error) {
  py::object instance = py::reinterpret_borrow<py::object>(g_format_error)(error.what());
  instance.attr("file") = error.file();
  instance.attr("line") = error.line();
  instance.attr("field") = error.field();
  instance.attr("reason") = error.reason();
  PyErr_SetObject(g_format_error, instance.ptr());
}

}  // namespace

void bind_errors(py::module_& m) {
  static PyObject* base = add_exception(
      m, "Error", py::make_tuple(py::reinterpret_borrow<py::object>(PyExc_RuntimeError)),
      "Base of every exception that raylign raises on purpose.");
  const py::tuple bases = py::make_tuple(py::reinterpret_borrow<py::object>(base),
                                         py::reinterpret_borrow<py::object>(PyExc_ValueError));
  static PyObject* options = add_exception(m, "OptionsError", bases,
                                           "An option is out of range or contradicts another one.");
  static PyObject* shape = add_exception(
      m, "ShapeError", bases, "Array shapes, dtypes, memory order or index ranges disagree.");
  g_format_error =
      add_exception(m, "FormatError", bases,
                    "A file is not what its format promises. Attributes: `file` (str), `line` "
                    "(int, 1-based, 0 = none), `field` (str), `reason` (str).");
  py::register_exception_translator([](std::exception_ptr pending) {
    try {
      if (pending) std::rethrow_exception(pending);
    } catch (const FormatError& error) {
      set_format_error(error);
    } catch (const OptionsError& error) {
      PyErr_SetString(options, error.what());
    } catch (const ShapeError& error) {
      PyErr_SetString(shape, error.what());
    } catch (const Error& error) {
      PyErr_SetString(base, error.what());
    }
  });
}

}  // namespace raylign::python
