// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <pybind11/pybind11.h>

#include "raylign/base/stopwatch.h"
#include "raylign/solver/summary.h"

/// How a running solve talks to Python: its callback and Ctrl-C.
namespace raylign::python {

namespace py = pybind11;

/// False or NumPy's False, which comparisons of array elements give; 0 and None are no answer.
inline bool is_false(const py::object& answer) {
  if (answer.is(py::bool_(false))) return true;
  return py::isinstance(answer, py::module_::import("numpy").attr("bool_")) && !answer.cast<bool>();
}

/// Asks Python whether to go on; without the GIL. Ctrl-C means "stop and keep the best state", here
/// and inside the user's callback; any other exception travels through the solver to the caller.
inline CallbackAction ask_python(const py::object& callback, const IterationSummary& summary) {
  const py::gil_scoped_acquire gil;
  try {
    if (PyErr_CheckSignals() != 0) throw py::error_already_set();
    if (callback.is_none()) return CallbackAction::CONTINUE;
    return is_false(callback(summary)) ? CallbackAction::STOP : CallbackAction::CONTINUE;
  } catch (py::error_already_set& error) {
    if (error.matches(PyExc_KeyboardInterrupt)) return CallbackAction::STOP;
    throw;
  }
}

/// Ctrl-C between two callbacks; asked at most every 50 ms, for it takes the GIL.
class SignalCheck {
 public:
  bool operator()() {
    constexpr double kPeriod_s = 0.05;
    if (clock_.seconds() < kPeriod_s) return false;
    clock_.restart();
    const py::gil_scoped_acquire gil;
    if (PyErr_CheckSignals() == 0) return false;
    py::error_already_set error;
    if (error.matches(PyExc_KeyboardInterrupt)) return true;
    throw error;
  }

 private:
  Stopwatch clock_;
};

}  // namespace raylign::python
