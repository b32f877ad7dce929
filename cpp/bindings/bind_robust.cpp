// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include "batch.h"
#include "bindings.h"
#include "options_binder.h"
#include "raylign/robust/loss.h"

namespace raylign::python {
namespace {

void bind_loss_type(py::module_& m) {
  py::native_enum<LossType>(m, "LossType", "enum.Enum", "Robust laws ρ(s) of s = ‖r‖².")
      .value("TRIVIAL", LossType::TRIVIAL)
      .value("HUBER", LossType::HUBER)
      .value("SOFT_L1", LossType::SOFT_L1)
      .value("CAUCHY", LossType::CAUCHY)
      .value("ARCTAN", LossType::ARCTAN)
      .value("TUKEY", LossType::TUKEY)
      .value("GEMAN_MCCLURE", LossType::GEMAN_MCCLURE)
      .value("STUDENT_T", LossType::STUDENT_T)
      .finalize();
}

py::tuple evaluate(const Loss& loss, const py::object& squared_norm) {
  const F64Array s = batch_from_numpy(squared_norm, {}, "squared_norm");
  const Shape shape = batch_shape(s, 0);
  F64Array rho(shape), d_rho(shape), d2_rho(shape);
  const double* in = s.data();
  double* out[] = {rho.mutable_data(), d_rho.mutable_data(), d2_rho.mutable_data()};
  const py::ssize_t size = batch_size(shape);
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < size; ++i) {
      const LossValue value = loss.evaluate(in[i]);
      out[0][i] = value.rho;
      out[1][i] = value.d_rho;
      out[2][i] = value.d2_rho;
    }
  }
  return py::make_tuple(rho, d_rho, d2_rho);
}

constexpr const char* kLossDoc =
    R"(Robust law ρ(s) of the squared residual norm, ρ(0) = 0, ρ'(0) = 1.

With a = scale and x = s / a²: TRIVIAL s; HUBER s or 2a√s − a²; SOFT_L1 2a²(√(1 + x) − 1);
CAUCHY a² log(1 + x); ARCTAN a² atan(x); TUKEY a²/3 (1 − (1 − x)³), a²/3 for x > 1; GEMAN_MCCLURE s / (1 + x);
STUDENT_T ν a² log(1 + x / ν) with ν = degrees_of_freedom.)";

}  // namespace

void bind_robust(py::module_& m) {
  bind_loss_type(m);
  OptionsBinder<Loss> binder(m, "Loss", kLossDoc, [](const Loss& loss) { loss.validate(); });
  binder.field("type", &Loss::type, "LossType.")
      .field("scale", &Loss::scale, "a, in units of the residual (px for reprojection), > 0.")
      .field("degrees_of_freedom", &Loss::degrees_of_freedom, "ν of STUDENT_T, > 0.");
  binder.finish()
      .def("evaluate", &evaluate, py::arg("squared_norm"),
           "(ρ, ρ', ρ'') at s >= 0, (...) real; three float64 arrays of the same shape.")
      .def_static("parse", &parse_loss, py::arg("text"),
                  "Loss from type[:scale[:degrees_of_freedom]], e.g. \"huber:1.0\"; OptionsError.");
}

}  // namespace raylign::python
