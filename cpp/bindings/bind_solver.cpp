// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include <cstdint>
#include <limits>

#include "bindings.h"
#include "options_binder.h"
#include "raylign/solver/bundle_config.h"
#include "raylign/solver/bundle_options.h"
#include "raylign/solver/options.h"
#include "raylign/solver/summary.h"

namespace raylign::python {
namespace {

void bind_solver_enums(py::module_& m) {
  py::native_enum<LinearSolverType>(m, "LinearSolverType", "enum.Enum", "How S δ = b is solved.")
      .value("AUTO", LinearSolverType::AUTO)
      .value("DENSE_NORMAL_CHOLESKY", LinearSolverType::DENSE_NORMAL_CHOLESKY)
      .value("DENSE_SCHUR", LinearSolverType::DENSE_SCHUR)
      .value("SPARSE_SCHUR", LinearSolverType::SPARSE_SCHUR)
      .value("ITERATIVE_SCHUR", LinearSolverType::ITERATIVE_SCHUR)
      .finalize();
  py::native_enum<Preconditioner>(m, "Preconditioner", "enum.Enum", "Of ITERATIVE_SCHUR.")
      .value("AUTO", Preconditioner::AUTO)
      .value("IDENTITY", Preconditioner::IDENTITY)
      .value("JACOBI", Preconditioner::JACOBI)
      .value("SCHUR_JACOBI", Preconditioner::SCHUR_JACOBI)
      .value("CLUSTER_JACOBI", Preconditioner::CLUSTER_JACOBI)
      .value("CLUSTER_TRIDIAGONAL", Preconditioner::CLUSTER_TRIDIAGONAL)
      .value("TWO_LEVEL", Preconditioner::TWO_LEVEL)
      .value("STALE_FACTOR", Preconditioner::STALE_FACTOR)
      .finalize();
  py::native_enum<Termination>(m, "Termination", "enum.Enum", "Why a solve ended.")
      .value("NOT_RUN", Termination::NOT_RUN)
      .value("CONVERGENCE", Termination::CONVERGENCE)
      .value("MAX_ITERATIONS", Termination::MAX_ITERATIONS)
      .value("TIME_LIMIT", Termination::TIME_LIMIT)
      .value("USER_STOPPED", Termination::USER_STOPPED)
      .value("FAILURE", Termination::FAILURE)
      .finalize();
}

void bind_bundle_enums(py::module_& m) {
  py::native_enum<Backend>(m, "Backend", "enum.Enum", "Engine of bundle adjustment.")
      .value("AUTO", Backend::AUTO)
      .value("CERES", Backend::CERES)
      .value("NATIVE", Backend::NATIVE)
      .finalize();
  py::native_enum<PoseParametrization>(m, "PoseParametrization", "enum.Enum", "How a pose moves.")
      .value("SE3", PoseParametrization::SE3)
      .value("QUATERNION", PoseParametrization::QUATERNION)
      .value("ANGLE_AXIS", PoseParametrization::ANGLE_AXIS)
      .finalize();
  py::native_enum<PointParametrization>(m, "PointParametrization", "enum.Enum",
                                        "How a point moves.")
      .value("XYZ", PointParametrization::XYZ)
      .value("HOMOGENEOUS", PointParametrization::HOMOGENEOUS)
      .value("INVERSE_DEPTH", PointParametrization::INVERSE_DEPTH)
      .finalize();
  py::native_enum<JacobianStorage>(m, "JacobianStorage", "enum.Enum",
                                   "How the native engine keeps the Jacobian; AUTO: FLOAT above a "
                                   "million observations.")
      .value("AUTO", JacobianStorage::AUTO)
      .value("DOUBLE", JacobianStorage::DOUBLE)
      .value("FLOAT", JacobianStorage::FLOAT)
      .finalize();
  py::native_enum<Gauge>(
      m, "Gauge", "enum.Enum",
      "What removes the seven similarity freedoms: FREE nothing; FIRST_CAMERA the pose of the "
      "first "
      "observed camera; TWO_CAMERAS that and, of the camera farthest from it, the coordinate of "
      "t_cw that a change of scale moves most.")
      .value("FREE", Gauge::FREE)
      .value("FIRST_CAMERA", Gauge::FIRST_CAMERA)
      .value("TWO_CAMERAS", Gauge::TWO_CAMERAS)
      .finalize();
  py::native_enum<ParameterKind>(m, "ParameterKind", "enum.Enum", "Kind of a parameter block.")
      .value("POSE", ParameterKind::POSE)
      .value("INTRINSICS", ParameterKind::INTRINSICS)
      .value("POINT", ParameterKind::POINT)
      .finalize();
}

void bind_lm_options(py::module_& m) {
  using O = LmOptions;
  OptionsBinder<O>(m, "LmOptions",
                   "Options of the Levenberg-Marquardt loop, the same for every engine.",
                   [](const O& o) { o.validate(); })
      .field("max_num_iterations", &O::max_num_iterations,
             "Outer iterations, >= 0; 0 only evaluates.")
      .field("max_solver_time_s", &O::max_solver_time_s, "Wall time in s, > 0.")
      .field("function_tolerance", &O::function_tolerance, "Stop when |Δcost| <= tolerance · cost.")
      .field("gradient_tolerance", &O::gradient_tolerance, "Stop when max |gradient| <= tolerance.")
      .field("parameter_tolerance", &O::parameter_tolerance, "Stop when ‖δ‖ <= tolerance · ‖x‖.")
      .field("initial_lambda", &O::initial_lambda, "Damping of the first step; Ceres: 1 / radius.")
      .field("min_lambda", &O::min_lambda, "Lower bound of λ, > 0.")
      .field("max_lambda", &O::max_lambda, "Give up when λ grows past it.")
      .field("min_relative_decrease", &O::min_relative_decrease, "Smallest accepted gain ratio.")
      .field("min_diagonal", &O::min_diagonal, "Clamp of diag(JᵀJ) from below.")
      .field("max_diagonal", &O::max_diagonal, "Clamp of diag(JᵀJ) from above.")
      .field("max_num_consecutive_invalid_steps", &O::max_num_consecutive_invalid_steps,
             "Steps without a finite trial before FAILURE.")
      .field("jacobi_scaling", &O::jacobi_scaling, "Scale the columns of J once, at the start.")
      .field("num_threads", &O::num_threads, ">= 1.")
      .finish();
}

void bind_linear_solver_options(py::module_& m) {
  using O = LinearSolverOptions;
  OptionsBinder<O>(m, "LinearSolverOptions", "How the damped normal equations are solved.",
                   [](const O& o) { o.validate(); })
      .field("type", &O::type, "LinearSolverType.")
      .field("preconditioner", &O::preconditioner, "Preconditioner; ITERATIVE_SCHUR only.")
      .field("explicit_schur", &O::explicit_schur, "Form S instead of applying it.")
      .field("max_num_iterations", &O::max_num_iterations,
             "Conjugate-gradient iterations per step.")
      .field("forcing_tolerance", &O::forcing_tolerance, "η of the inexact step, in (0, 1).")
      .finish();
}

void bind_bundle_options(py::module_& m) {
  using O = BundleOptions;
  OptionsBinder<O>(m, "BundleOptions", "How a bundle adjustment is solved.",
                   [](const O& o) { o.validate(); })
      .field("backend", &O::backend, "Backend.")
      .field("pose_parametrization", &O::pose_parametrization, "PoseParametrization.")
      .field("point_parametrization", &O::point_parametrization, "PointParametrization.")
      .field("loss", &O::loss, "Robust law of ‖r‖² per observation, scale in px.")
      .field("lm", &O::lm, "LmOptions.")
      .field("linear_solver", &O::linear_solver, "LinearSolverOptions.")
      .field("jacobian_storage", &O::jacobian_storage, "JacobianStorage; backend NATIVE only.")
      .field("parity", &O::parity,
             "Backend NATIVE: take the steps of Ceres, one by one, instead of better ones.")
      .finish();
}

void bind_bundle_config(py::module_& m) {
  using C = ConstantCoordinate;
  OptionsBinder<C>(
      m, "ConstantCoordinate",
      "One scalar held constant: POSE tx ty tz rotation, INTRINSICS the parameters of the camera "
      "model (BAL: f k1 k2), POINT x y z.",
      [](const C& c) { coordinate_offset(c.kind, c.coordinate); })
      .field("kind", &C::kind, "ParameterKind.")
      .field("index", &C::index, "Camera or point; -1 = all.")
      .field("coordinate", &C::coordinate, "Name, one of those of its kind.")
      .finish();
  constexpr std::int64_t kMaxCount = std::numeric_limits<std::int32_t>::max();
  using B = BundleConfig;
  OptionsBinder<B>(m, "BundleConfig", "What a bundle adjustment holds fixed.",
                   [](const B& b) { b.validate(kMaxCount, kMaxCount); })
      .field("gauge", &B::gauge, "Gauge.")
      .field("constant_cameras", &B::constant_cameras, "Cameras whose pose is held.")
      .field("constant_intrinsics", &B::constant_intrinsics, "Cameras whose intrinsics are held.")
      .field("constant_points", &B::constant_points, "Points that are held.")
      .field("constant_coordinates", &B::constant_coordinates, "Single scalars that are held.")
      .finish();
}

void bind_iteration_summary(py::module_& m) {
  using I = IterationSummary;
  PYBIND11_NUMPY_DTYPE(I, iteration, linear_solver_iterations, num_residual_blocks, step_is_valid,
                       step_is_accepted, cost, cost_change, gain_ratio, gradient_max_norm,
                       step_norm, lambda, linear_solver_time_s, iteration_time_s,
                       cumulative_time_s);
  OptionsBinder<I>(m, "IterationSummary", "One iteration; row 0 is the start. Times in s.", nullptr)
      .field("iteration", &I::iteration, "0, 1, 2, …")
      .field("linear_solver_iterations", &I::linear_solver_iterations,
             "CG iterations; 1 if direct.")
      .field("num_residual_blocks", &I::num_residual_blocks, "Observations in the cost.")
      .field("step_is_valid", &I::step_is_valid, "Finite trial cost, positive model decrease.")
      .field("step_is_accepted", &I::step_is_accepted, "The state moved.")
      .field("cost", &I::cost, "½ Σ ρ(‖r‖²) after the iteration.")
      .field("cost_change", &I::cost_change, "> 0: the cost went down.")
      .field("gain_ratio", &I::gain_ratio, "Actual / predicted decrease.")
      .field("gradient_max_norm", &I::gradient_max_norm, "max |x − (x ⊞ −g)|.")
      .field("step_norm", &I::step_norm, "‖δ‖.")
      .field("lambda_", &I::lambda, "Damping of the next step; column 'lambda' of the table.")
      .field("linear_solver_time_s", &I::linear_solver_time_s, "Of this iteration.")
      .field("iteration_time_s", &I::iteration_time_s, "Of this iteration.")
      .field("cumulative_time_s", &I::cumulative_time_s, "Since the call.")
      .finish();
}

using IterationArray = py::array_t<IterationSummary, py::array::c_style>;

IterationArray iterations_to_numpy(const Summary& summary) {
  return IterationArray(static_cast<py::ssize_t>(summary.iterations.size()),
                        summary.iterations.data());
}

void bind_summary(py::module_& m) {
  using S = Summary;
  py::class_<S> cls =
      OptionsBinder<S>(m, "Summary", "What a solve did; the same from every engine. Times in s.",
                       nullptr)
          .field("termination", &S::termination, "Termination.")
          .field("message", &S::message, "Why, in words.")
          .field("backend", &S::backend, "'ceres', 'native' or 'none'.")
          .field("backend_reason", &S::backend_reason, "Why AUTO took it, or 'requested'.")
          .field("initial_cost", &S::initial_cost, "½ Σ ρ(‖r‖²) at the start.")
          .field("final_cost", &S::final_cost, "½ Σ ρ(‖r‖²) at the end.")
          .field("num_accepted", &S::num_accepted, "Steps that moved the state.")
          .field("num_rejected", &S::num_rejected, "Steps that did not.")
          .field("num_residuals", &S::num_residuals, "Scalar residuals.")
          .field("num_effective_parameters", &S::num_effective_parameters, "Tangent dimension.")
          .field("linear_solver", &S::linear_solver, "What ran.")
          .field("linear_solver_reason", &S::linear_solver_reason,
                 "Why AUTO picked it, or 'requested'.")
          .field("jacobian_storage", &S::jacobian_storage,
                 "'double', 'float', or why float became double.")
          .field("num_threads", &S::num_threads, "Used.")
          .field("deterministic", &S::deterministic, "Same input, same bits, on this machine.")
          .field("preprocessor_time_s", &S::preprocessor_time_s, "Building the problem.")
          .field("residual_time_s", &S::residual_time_s, "Evaluating the cost.")
          .field("jacobian_time_s", &S::jacobian_time_s, "Evaluating residuals and Jacobians.")
          .field("linear_solver_time_s", &S::linear_solver_time_s, "Solving for steps.")
          .field("total_time_s", &S::total_time_s, "Wall time of the call.")
          .property(
              "iterations", &iterations_to_numpy,
              [](S& s, const IterationArray& rows) {
                s.iterations.assign(rows.data(), rows.data() + rows.size());
              },
              "(iterations + 1,) structured array; summary.iterations['cost'] plots directly.")
          .finish();
  cls.def("is_usable", &S::is_usable, "True when the state is at least as good as the start.");
  cls.def("brief_report", &S::brief_report, "One line.");
  cls.def("full_report", &S::full_report, "Several lines.");
  cls.attr("__repr__") = py::cpp_function(
      [](const S& s) { return "<Summary: " + s.brief_report() + ">"; }, py::is_method(cls));
}

}  // namespace

void bind_solver(py::module_& m) {
  bind_solver_enums(m);
  bind_bundle_enums(m);
  bind_lm_options(m);
  bind_linear_solver_options(m);
  bind_bundle_options(m);
  bind_bundle_config(m);
  bind_iteration_summary(m);
  bind_summary(m);
}

}  // namespace raylign::python
