// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/functional.h>
#include <pybind11/numpy.h>

#include <utility>

#include "bindings.h"
#include "raylign/base/stopwatch.h"
#include "raylign/bundle/bundle_adjuster.h"

namespace raylign::python {
namespace {

namespace py = pybind11;

// False or NumPy's False, which comparisons of array elements give; 0 and None are no answer.
bool is_false(const py::object& answer) {
  if (answer.is(py::bool_(false))) return true;
  return py::isinstance(answer, py::module_::import("numpy").attr("bool_")) && !answer.cast<bool>();
}

// Asks Python whether to go on. Ctrl-C means "stop and keep the best state", here and inside the
// user's callback; any other exception travels through the solver to the caller.
CallbackAction ask_python(const py::object& callback, const IterationSummary& summary) {
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

// Ctrl-C inside a long linear solve; asked at most every 50 ms, for it takes the GIL.
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

// Options by value: other Python threads may change theirs while the GIL is released.
template <typename Problem>
Summary adjust_in_place(Problem& problem,
                        BundleConfig config,
                        BundleOptions options,
                        const py::object& callback) {
  const py::gil_scoped_release release;
  const auto ask = [&callback](const IterationSummary& row) { return ask_python(callback, row); };
  return adjust(problem, config, options, ask, SignalCheck());
}

template <typename T>
py::array_t<T> to_numpy(const std::vector<T>& values) {
  return py::array_t<T>(static_cast<py::ssize_t>(values.size()), values.data());
}

template <typename Problem>
void bind_engines(py::module_& m) {
  m.def(
      "linearize",
      [](const Problem& problem, const BundleConfig& config, const BundleOptions& options) {
        return linearize(problem, config, options);
      },
      py::arg("problem"), py::kw_only(), py::arg("config"), py::arg("options"),
      py::call_guard<py::gil_scoped_release>());
  m.def("adjust", &adjust_in_place<Problem>, py::arg("problem"), py::kw_only(), py::arg("config"),
        py::arg("options"), py::arg("callback").none(true),
        "Refine `problem` in place; the façade raylign.bundle.adjust copies first.");
}

}  // namespace

void bind_bundle(py::module_& m) {
  py::class_<Linearization>(m, "Linearization", "r(x ⊞ δ) ≈ r + J δ, robust weights applied.")
      .def_readonly("cost", &Linearization::cost, "½ Σ ρ(‖r‖²).")
      .def_property_readonly(
          "residuals", [](const Linearization& l) { return to_numpy(l.residuals); },
          "(2N,) weighted.")
      .def_property_readonly(
          "gradient", [](const Linearization& l) { return to_numpy(l.gradient); }, "(n,) Jᵀr.")
      .def_readonly("num_columns", &Linearization::num_columns, "n.")
      .def_property_readonly(
          "row_starts", [](const Linearization& l) { return to_numpy(l.row_starts); },
          "(2N + 1,) CRS.")
      .def_property_readonly(
          "columns", [](const Linearization& l) { return to_numpy(l.columns); }, "CRS.")
      .def_property_readonly(
          "values", [](const Linearization& l) { return to_numpy(l.values); }, "CRS.");
  bind_engines<BalProblem>(m);
  bind_engines<BundleProblem>(m);
}

}  // namespace raylign::python
