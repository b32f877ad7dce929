// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/numpy.h>
#include <pybind11/pybind11.h>
#include <pybind11/stl.h>

#include <string>
#include <utility>
#include <vector>

#include "raylign/base/error.h"

namespace raylign::python {

namespace py = pybind11;

/// Binds an options struct as a Python dataclass-like class: keyword-only constructor (unknown key
/// → TypeError, bad value → OptionsError), replace(), to_dict(), ==, repr that can be pasted back,
/// pickle, copy, __fields__. One field() call per member; the C++ defaults are the Python defaults.
template <typename T>
class OptionsBinder {
 public:
  using Validator = void (*)(const T&);

  OptionsBinder(py::module_& m, const char* name, const char* doc, Validator validate)
      : cls_(m, name, doc), name_(name), validate_(validate) {}

  template <typename Value>
  OptionsBinder& field(const char* name, Value T::* member, const char* doc) {
    cls_.def_readwrite(name, member, doc);
    fields_.emplace_back(name);
    return *this;
  }

  /// A field that needs conversion: getter(T&) → object, setter(T&, value).
  template <typename Getter, typename Setter>
  OptionsBinder& property(const char* name, Getter getter, Setter setter, const char* doc) {
    cls_.def_property(name, getter, setter, doc);
    fields_.emplace_back(name);
    return *this;
  }

  /// Call last: defines everything that needs the list of fields.
  py::class_<T>& finish() {
    const Validator validate = validate_;
    const std::string name = name_;
    cls_.attr("__fields__") = py::tuple(py::cast(fields_));
    cls_.def(py::init([validate, name](const py::kwargs& values) {
      py::object self = py::cast(T{});
      assign(self, values, name);
      T result = self.cast<T>();
      if (validate != nullptr) validate(result);
      return result;
    }));
    cls_.def(
        "validate",
        [validate](const T& self) {
          if (validate != nullptr) validate(self);
        },
        "Raise OptionsError when a field is out of range.");
    cls_.def(
        "replace",
        [](const py::object& self, const py::kwargs& changes) {
          py::dict values = to_dict(self);
          for (auto item : changes) values[item.first] = item.second;
          return py::type::of(self)(**values);
        },
        "Copy with the given fields changed; validated.");
    cls_.def(
        "to_dict", [](const py::object& self) { return to_dict(self); },
        "Fields as a dict, in declaration order; nested options stay objects.");
    cls_.def("__eq__", [](const py::object& self, const py::object& other) -> py::object {
      if (!py::type::of(self).is(py::type::of(other))) {
        return py::reinterpret_borrow<py::object>(Py_NotImplemented);
      }
      return py::bool_(values_equal(self, other));
    });
    cls_.attr("__hash__") = py::none();
    cls_.def("__repr__", [name](const py::object& self) { return repr(self, name); });
    cls_.def("__copy__", [](const T& self) { return T(self); });
    cls_.def("__deepcopy__", [](const T& self, const py::dict&) { return T(self); });
    cls_.def("__reduce__", [](const py::object& self) {
      return py::make_tuple(py::module_::import("raylign._pickle").attr("rebuild"),
                            py::make_tuple(py::type::of(self), to_dict(self)));
    });
    return cls_;
  }

 private:
  static py::tuple field_names(const py::object& self) {
    return py::type::of(self).attr("__fields__").cast<py::tuple>();
  }

  static py::dict to_dict(const py::object& self) {
    py::dict values;
    for (auto field : field_names(self)) values[field] = self.attr(field);
    return values;
  }

  static bool values_equal(const py::object& a, const py::object& b) {
    const py::object array_equal = py::module_::import("numpy").attr("array_equal");
    for (auto field : field_names(a)) {
      const py::object left = a.attr(field);
      const py::object right = b.attr(field);
      const bool equal = py::isinstance<py::array>(left)
                             ? array_equal(left, right).template cast<bool>()
                             : left.equal(right);
      if (!equal) return false;
    }
    return true;
  }

  static void assign(py::object& self, const py::kwargs& values, const std::string& name) {
    const py::tuple known = field_names(self);
    for (auto item : values) {
      if (!known.contains(item.first)) {
        throw py::type_error(name + " has no option '" + py::str(item.first).cast<std::string>() +
                             "'; it has " +
                             py::str(py::str(", ").attr("join")(known)).cast<std::string>());
      }
      set_field(self, item.first, from_text(self, item.first, item.second, name), name);
    }
  }

  // What Python would call a TypeError deep inside a setter, with the option's name.
  static void set_field(py::object& self,
                        const py::handle& field,
                        const py::object& value,
                        const std::string& name) {
    try {
      self.attr(field) = value;
    } catch (py::error_already_set& error) {
      if (!error.matches(PyExc_TypeError)) throw;
      throw OptionsError(name + "." + py::str(field).cast<std::string>() + " must be like " +
                         value_repr(self.attr(field)) + ", got " +
                         py::repr(value).cast<std::string>());
    }
  }

  // Text stands for what it names on the command line: an enumerator by its lower-case name, a
  // loss by "cauchy:1.0" (any class with a static parse).
  static py::object from_text(const py::object& self,
                              const py::handle& field,
                              const py::handle& value,
                              const std::string& name) {
    const py::object type = py::type::of(self.attr(field));
    const bool is_text = py::isinstance<py::str>(value);
    if (is_text && py::hasattr(type, "parse")) return type.attr("parse")(value);
    if (!is_text || !py::hasattr(type, "__members__")) {
      return py::reinterpret_borrow<py::object>(value);
    }
    std::string known;
    for (auto member : type) {
      const py::object spelling = member.attr("name").attr("lower")();
      if (spelling.equal(value)) return py::reinterpret_borrow<py::object>(member);
      known += (known.empty() ? "" : ", ") + py::str(spelling).cast<std::string>();
    }
    throw OptionsError(name + "." + py::str(field).cast<std::string>() + " must be one of " +
                       known + ", got '" + py::str(value).cast<std::string>() + "'");
  }

  static std::string repr(const py::object& self, const std::string& name) {
    std::string text = name + "(";
    const char* separator = "";
    for (auto field : field_names(self)) {
      text += separator + py::str(field).cast<std::string>() + "=" + value_repr(self.attr(field));
      separator = ", ";
    }
    return text + ")";
  }

  // Enumerators print as Type.NAME, which can be pasted back; their own repr cannot.
  static std::string value_repr(const py::object& value) {
    if (py::isinstance(value, py::module_::import("enum").attr("Enum"))) {
      return py::str(py::type::of(value).attr("__name__")).cast<std::string>() + "." +
             py::str(value.attr("name")).cast<std::string>();
    }
    const std::string text = py::repr(value).cast<std::string>();
    if (py::isinstance<py::float_>(value) && (text == "inf" || text == "-inf")) {
      return "float('" + text + "')";
    }
    return text;
  }

  py::class_<T> cls_;
  std::string name_;
  Validator validate_;
  std::vector<std::string> fields_;
};

}  // namespace raylign::python
