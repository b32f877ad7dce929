// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/functional.h>
#include <pybind11/numpy.h>

#include <utility>

#include "bindings.h"
#include "callbacks.h"
#include "raylign/bundle/bundle_adjuster.h"

namespace raylign::python {
namespace {

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
