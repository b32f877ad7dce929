// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/eigen.h>

#include <limits>
#include <string>

#include "batch.h"
#include "bindings.h"
#include "raylign/base/error.h"
#include "raylign/camera/bal.h"
#include "raylign/camera/pinhole.h"
#include "raylign/camera/radtan.h"
#include "raylign/camera/undistort.h"

namespace raylign::python {
namespace {

using BoolArray = py::array_t<bool, py::array::c_style>;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

// One array over a batch, written item by item.
template <typename T>
struct Output {
  explicit Output(const Shape& batch) : array(join(batch, Item<T>::shape())) {
    data = array.mutable_data();
  }
  void store(py::ssize_t i, const T& value, bool valid) {
    Item<T>::store(valid ? value : T(T::Constant(kNan)), data + i * Item<T>::kSize);
  }

  F64Array array;
  double* data;
};

// Runs map(item, out, J_in, J_params) over a batch. Rows without a value are NaN and valid is
// False.
template <typename In, typename Out, typename JacobianIn, typename JacobianParams, typename Map>
py::tuple map_camera(const py::object& object,
                     const char* name,
                     bool with_jacobians,
                     const Map& map) {
  const F64Array in = batch_from_numpy(object, Item<In>::shape(), name);
  const Shape batch = batch_shape(in, 1);
  const py::ssize_t size = batch_size(batch);
  Output<Out> out(batch);
  BoolArray valid(batch);
  Output<JacobianIn> J_in(with_jacobians ? batch : Shape{0});
  Output<JacobianParams> J_params(with_jacobians ? batch : Shape{0});
  const double* source = in.data();
  bool* is_valid = valid.mutable_data();
  {
    const py::gil_scoped_release release;
    for (py::ssize_t i = 0; i < size; ++i) {
      Out value;
      JacobianIn by_in;
      JacobianParams by_params;
      is_valid[i] = map(Item<In>::load(source + i * Item<In>::kSize), value,
                        with_jacobians ? &by_in : nullptr, with_jacobians ? &by_params : nullptr);
      out.store(i, value, is_valid[i]);
      if (!with_jacobians) continue;
      J_in.store(i, by_in, is_valid[i]);
      J_params.store(i, by_params, is_valid[i]);
    }
  }
  if (!with_jacobians) return py::make_tuple(out.array, valid);
  return py::make_tuple(out.array, valid, J_in.array, J_params.array);
}

template <typename Camera>
py::tuple project(const Camera& camera, const py::object& p_c, bool with_jacobians) {
  using JacobianParams = RowMajor<2, Camera::kNumParams>;
  return map_camera<Vector3, Vector2, RowMajor<2, 3>, JacobianParams>(
      p_c, "p_c", with_jacobians,
      [&](const Vector3& p, Vector2& uv, RowMajor<2, 3>* J_point, JacobianParams* J_params) {
        return camera.project(p, uv, J_point, J_params);
      });
}

template <typename Camera>
py::tuple unproject(const Camera& camera, const py::object& uv, bool with_jacobians) {
  using JacobianParams = RowMajor<3, Camera::kNumParams>;
  return map_camera<Vector2, Vector3, RowMajor<3, 2>, JacobianParams>(
      uv, "uv", with_jacobians,
      [&](const Vector2& pixel, Vector3& b, RowMajor<3, 2>* J_uv, JacobianParams* J_params) {
        return camera.unproject(pixel, b, J_uv, J_params);
      });
}

template <typename Camera>
py::object is_in_front(const py::object& p_c) {
  const F64Array in = batch_from_numpy(p_c, {3}, "p_c");
  BoolArray front(batch_shape(in, 1));
  bool* out = front.mutable_data();
  const double* source = in.data();
  for (py::ssize_t i = 0; i < front.size(); ++i) {
    out[i] = Camera::is_in_front(Item<Vector3>::load(source + 3 * i));
  }
  return front;
}

// Parameters as Python floats in constructor order: repr, pickle, == and hash all follow from it.
template <typename Camera>
py::tuple params_tuple(const Camera& camera) {
  py::tuple values(Camera::kNumParams);
  for (int i = 0; i < Camera::kNumParams; ++i) values[i] = py::float_(camera.params()[i]);
  return values;
}

template <typename Camera>
std::string repr(const py::object& self) {
  const py::tuple names = self.attr("__fields__");
  const py::tuple values = params_tuple(self.cast<const Camera&>());
  std::string text = py::str(py::type::of(self).attr("__name__")).cast<std::string>() + "(";
  for (std::size_t i = 0; i < names.size(); ++i) {
    text += (i == 0 ? "" : ", ") + names[i].cast<std::string>() + "=" +
            py::repr(values[i]).cast<std::string>();
  }
  return text + ")";
}

template <typename Camera>
void bind_values(py::class_<Camera>& cls, const py::tuple& names) {
  cls.attr("__fields__") = names;
  cls.attr("num_params") = static_cast<int>(Camera::kNumParams);
  for (int i = 0; i < Camera::kNumParams; ++i) {
    cls.def_property_readonly(names[i].cast<std::string>().c_str(),
                              [i](const Camera& self) { return self.params()[i]; });
  }
  cls.def_property_readonly("params", &Camera::params, "(P,) float64, in constructor order.");
  cls.def("__repr__", &repr<Camera>);
  cls.def("__eq__", [](const Camera& self, const py::object& other) -> py::object {
    if (!py::isinstance<Camera>(other))
      return py::reinterpret_borrow<py::object>(Py_NotImplemented);
    return py::bool_(self.params() == other.cast<const Camera&>().params());
  });
  cls.def("__hash__", [](const Camera& self) { return py::hash(params_tuple(self)); });
  cls.def("__copy__", [](const Camera& self) { return Camera(self); });
  cls.def("__deepcopy__", [](const Camera& self, const py::dict&) { return Camera(self); });
  cls.def("__reduce__", [](const py::object& self) {
    return py::make_tuple(py::type::of(self), params_tuple(self.cast<const Camera&>()));
  });
}

constexpr const char* kProjectDoc = R"(Project points.

Args:
    p_c: (..., 3) points in the camera frame, scene units.

Returns:
    uv (..., 2) float64, px, and valid (...) bool; uv is NaN where valid is False: behind the camera
    (not for BalCamera, whose cost has no such test), too near to its plane, or outside the domain
    of its distortion.)";

constexpr const char* kProjectJacobiansDoc =
    R"(As project, and J_point (..., 2, 3) = d(uv)/d(p_c), J_params (..., 2, P) = d(uv)/d(params).)";

constexpr const char* kUnprojectDoc = R"(Viewing rays of pixels.

Args:
    uv: (..., 2) pixels, integer at the pixel centre.

Returns:
    bearing (..., 3) float64 unit vectors in the camera frame, and valid (...) bool; bearing is NaN
    where valid is False: no ray within the one-to-one part of the distortion reaches the pixel.)";

constexpr const char* kUnprojectJacobiansDoc =
    R"(As unproject, and J_uv (..., 3, 2) = d(bearing)/d(uv), J_params (..., 3, P).)";

template <typename Camera>
void bind_methods(py::class_<Camera>& cls) {
  cls.def(
      "project",
      [](const Camera& self, const py::object& p_c) { return project(self, p_c, false); },
      py::arg("p_c"), kProjectDoc);
  cls.def(
      "project_with_jacobians",
      [](const Camera& self, const py::object& p_c) { return project(self, p_c, true); },
      py::arg("p_c"), kProjectJacobiansDoc);
  cls.def(
      "unproject",
      [](const Camera& self, const py::object& uv) { return unproject(self, uv, false); },
      py::arg("uv"), kUnprojectDoc);
  cls.def(
      "unproject_with_jacobians",
      [](const Camera& self, const py::object& uv) { return unproject(self, uv, true); },
      py::arg("uv"), kUnprojectJacobiansDoc);
  cls.def_static("is_in_front", &is_in_front<Camera>, py::arg("p_c"),
                 "(...) bool: points (..., 3) on the side the camera looks at.");
}

template <typename Camera>
Camera validated(Camera camera) {
  camera.validate();
  return camera;
}

void bind_pinhole(py::module_& m) {
  py::class_<PinholeCamera> cls(
      m, "PinholeCamera", "Pinhole: u = fx x / z + cx, v = fy y / z + cy; px. Looks along +z.");
  cls.def(py::init([](double fx, double fy, double cx, double cy) {
            return validated(PinholeCamera(fx, fy, cx, cy));
          }),
          py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"));
  bind_values(cls, py::make_tuple("fx", "fy", "cx", "cy"));
  bind_methods(cls);
  cls.def(
      "matrix", [](const PinholeCamera& self) { return RowMajor<3, 3>(self.matrix()); },
      "(3, 3) float64: [fx 0 cx; 0 fy cy; 0 0 1].");
  cls.def("at_level", &PinholeCamera::at_level, py::arg("level"),
          "Camera of level >= 0 of an ImagePyramid: f / 2^l, (c + 1/2) / 2^l - 1/2; OptionsError.");
}

void bind_radtan(py::module_& m) {
  py::class_<RadtanCamera> cls(
      m, "RadtanCamera",
      "Pinhole with Brown-Conrady distortion, coefficients in OpenCV's order. Looks along +z.");
  cls.def(py::init([](double fx, double fy, double cx, double cy, double k1, double k2, double p1,
                      double p2, double k3) {
            return validated(RadtanCamera({fx, fy, cx, cy}, {k1, k2, p1, p2, k3}));
          }),
          py::arg("fx"), py::arg("fy"), py::arg("cx"), py::arg("cy"), py::arg("k1"), py::arg("k2"),
          py::arg("p1"), py::arg("p2"), py::arg("k3") = 0.0);
  bind_values(cls, py::make_tuple("fx", "fy", "cx", "cy", "k1", "k2", "p1", "p2", "k3"));
  bind_methods(cls);
}

void bind_bal(py::module_& m) {
  py::class_<BalCamera> cls(
      m, "BalCamera",
      "BAL camera: p = −P_xy / P_z, (u, v) = f (1 + k1 ‖p‖² + k2 ‖p‖⁴) p; looks "
      "along −z, v up, principal point at the origin.");
  cls.def(py::init([](double f, double k1, double k2) { return validated(BalCamera(f, k1, k2)); }),
          py::arg("f"), py::arg("k1") = 0.0, py::arg("k2") = 0.0);
  bind_values(cls, py::make_tuple("f", "k1", "k2"));
  bind_methods(cls);
}

template <typename Camera>
py::tuple map_of(const Camera& camera, const py::object& K_new, int width, int height) {
  const F64Array K = batch_from_numpy(K_new, {3, 3}, "K_new");
  if (K.ndim() != 2) throw ShapeError("K_new must be one 3x3 matrix");
  const Matrix3 matrix = Item<Matrix3>::load(K.data());
  UndistortMap map;
  {
    const py::gil_scoped_release release;
    map = undistort_map(camera, matrix, width, height);
  }
  return py::make_tuple(py::cast(std::move(map.map_x)), py::cast(std::move(map.map_y)));
}

template <typename Camera>
void bind_undistort(py::module_& m) {
  m.def("undistort_map", &map_of<Camera>, py::arg("camera"), py::arg("K_new"), py::kw_only(),
        py::arg("width"), py::arg("height"));
}

}  // namespace

void bind_camera(py::module_& m) {
  bind_pinhole(m);
  bind_radtan(m);
  bind_bal(m);
  bind_undistort<PinholeCamera>(m);
  bind_undistort<RadtanCamera>(m);
}

}  // namespace raylign::python
