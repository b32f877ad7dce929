// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "batch.h"
#include "bindings.h"
#include "numpy.h"
#include "raylign/geometry/quaternion.h"
#include "raylign/geometry/se3.h"
#include "raylign/geometry/sim3.h"
#include "raylign/geometry/so3.h"
#include "raylign/geometry/umeyama.h"

namespace raylign::python {

/// Quaternions are (4,) xyzw, their order in memory.
template <>
struct Item<Quaternion> {
  static constexpr int kSize = 4;
  static Shape shape() { return {4}; }
  static Quaternion load(const double* data) { return Quaternion(data); }
  static void store(const Quaternion& q, double* data) { Eigen::Map<Vector4>{data} = q.coeffs(); }
};

namespace {

template <typename Out, typename In>
F64Array map_batch(Out (*function)(const In&), const F64Array& in) {
  const Shape batch = batch_shape(in, Item<In>::shape().size());
  F64Array out(join(batch, Item<Out>::shape()));
  const double* source = in.data();
  double* target = out.mutable_data();
  const py::ssize_t size = batch_size(batch);
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < size; ++i) {
    Item<Out>::store(function(Item<In>::load(source + i * Item<In>::kSize)),
                     target + i * Item<Out>::kSize);
  }
  return out;
}

// f: In -> Out becomes name((..., In)) -> (..., Out).
template <typename Out, typename In>
void def_batch(py::module_& m, const char* name, const char* argument, Out (*function)(const In&)) {
  m.def(
      name,
      [function, argument](const py::object& in) {
        return map_batch(function, batch_from_numpy(in, Item<In>::shape(), argument));
      },
      py::arg(argument), py::pos_only());
}

void bind_so3(py::module_& m) {
  def_batch(m, "so3_hat", "omega", so3_hat);
  def_batch(m, "so3_vee", "omega_hat", so3_vee);
  def_batch(m, "so3_exp", "omega", so3_exp);
  def_batch(m, "so3_log", "R", so3_log);
  def_batch(m, "so3_adjoint", "R", so3_adjoint);
  def_batch(m, "so3_left_jacobian", "omega", so3_left_jacobian);
  def_batch(m, "so3_right_jacobian", "omega", so3_right_jacobian);
  def_batch(m, "so3_left_jacobian_inverse", "omega", so3_left_jacobian_inverse);
  def_batch(m, "so3_right_jacobian_inverse", "omega", so3_right_jacobian_inverse);
  def_batch(m, "quaternion_exp", "omega", quaternion_exp);
  def_batch(m, "quaternion_log", "q", quaternion_log);
  def_batch(m, "quaternion_to_matrix", "q", quaternion_to_matrix);
  def_batch(m, "quaternion_from_matrix", "R", quaternion_from_matrix);
}

void bind_se3(py::module_& m) {
  def_batch(m, "se3_hat", "xi", se3_hat);
  def_batch(m, "se3_vee", "xi_hat", se3_vee);
  def_batch(m, "se3_exp", "xi", se3_exp);
  def_batch(m, "se3_log", "T", se3_log);
  def_batch(m, "se3_inverse", "T", se3_inverse);
  def_batch(m, "se3_adjoint", "T", se3_adjoint);
  def_batch(m, "se3_left_jacobian", "xi", se3_left_jacobian);
  def_batch(m, "se3_right_jacobian", "xi", se3_right_jacobian);
  def_batch(m, "se3_left_jacobian_inverse", "xi", se3_left_jacobian_inverse);
  def_batch(m, "se3_right_jacobian_inverse", "xi", se3_right_jacobian_inverse);
}

void bind_sim3(py::module_& m) {
  def_batch(m, "sim3_hat", "xi", sim3_hat);
  def_batch(m, "sim3_vee", "xi_hat", sim3_vee);
  def_batch(m, "sim3_exp", "xi", sim3_exp);
  def_batch(m, "sim3_log", "S", sim3_log);
  def_batch(m, "sim3_inverse", "S", sim3_inverse);
  def_batch(m, "sim3_adjoint", "S", sim3_adjoint);
  def_batch(m, "sim3_left_jacobian", "xi", sim3_left_jacobian);
  def_batch(m, "sim3_right_jacobian", "xi", sim3_right_jacobian);
  def_batch(m, "sim3_left_jacobian_inverse", "xi", sim3_left_jacobian_inverse);
  def_batch(m, "sim3_right_jacobian_inverse", "xi", sim3_right_jacobian_inverse);
}

F64Array align(const py::object& source, const py::object& target, bool with_scale) {
  const auto from = rows_from_numpy<double, 3>(source, "source");
  const auto to = rows_from_numpy<double, 3>(target, "target");
  Matrix4 S;
  {
    const py::gil_scoped_release release;
    S = umeyama(from, to, with_scale);
  }
  F64Array out(Item<Matrix4>::shape());
  Item<Matrix4>::store(S, out.mutable_data());
  return out;
}

}  // namespace

void bind_geometry(py::module_& m) {
  bind_so3(m);
  bind_se3(m);
  bind_sim3(m);
  m.def("umeyama", &align, py::arg("source"), py::arg("target"), py::kw_only(),
        py::arg("with_scale") = true);
}

}  // namespace raylign::python
