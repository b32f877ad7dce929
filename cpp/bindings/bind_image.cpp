// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>
#include <pybind11/typing.h>

#include <optional>
#include <string>

#include "batch.h"
#include "bindings.h"
#include "image.h"
#include "numpy.h"
#include "options_binder.h"
#include "raylign/base/error.h"
#include "raylign/image/bspline.h"
#include "raylign/image/depth_pyramid.h"
#include "raylign/image/gradient.h"
#include "raylign/image/pyramid.h"
#include "raylign/image/remap.h"
#include "raylign/image/sample_points.h"

namespace raylign::python {
namespace {

using FloatMap = py::array_t<float, py::array::c_style>;
using BoolArray = py::array_t<bool, py::array::c_style>;

Eigen::Map<const Rows<float, Eigen::Dynamic>> coordinate_map(const py::object& object,
                                                             const std::string& name) {
  if (py::isinstance<FloatMap>(object)) {
    const auto array = py::reinterpret_borrow<FloatMap>(object);
    if (array.ndim() == 2) return {array.data(), array.shape(0), array.shape(1)};
  }
  throw ShapeError(name + " must be a C-ordered float32 array of shape (H, W), got " +
                   describe_array(object));
}

py::array remap_array(const py::object& image,
                      const py::object& map_x,
                      const py::object& map_y,
                      Interpolation interpolation) {
  const ImageView view = view_of_image(image);
  const auto x = coordinate_map(map_x, "map_x");
  const auto y = coordinate_map(map_y, "map_y");
  Image result;
  {
    const py::gil_scoped_release release;
    result = remap(view, x, y, interpolation);
  }
  return to_numpy(std::move(result));
}

py::array grey_array(const py::object& image, ColorOrder order) {
  const ImageView view = view_of_image(image);
  Plane<float> grey;
  {
    const py::gil_scoped_release release;
    to_grey(view, order, grey);
  }
  return to_numpy(std::move(grey));
}

py::array gradient_array(const py::object& image, ColorOrder order) {
  const ImageView view = view_of_image(image);
  GradientImage cells;
  {
    const py::gil_scoped_release release;
    Plane<float> memory;
    make_gradient_image(grey_view(view, order, memory), cells);
  }
  return to_numpy(std::move(cells));
}

py::array max_gradient_array(const py::object& image, ColorOrder order) {
  const ImageView view = view_of_image(image);
  Plane<float> maximum;
  {
    const py::gil_scoped_release release;
    Plane<float> memory;
    GradientImage cells;
    make_gradient_image(grey_view(view, order, memory), cells);
    make_max_gradient(cells.view(), maximum);
  }
  return to_numpy(std::move(maximum));
}

// The three arrays over the points uv (..., 2); sample(points) fills them.
template <typename Sampler>
py::tuple sampled(const py::object& uv, const Sampler& sampler) {
  const F64Array in = batch_from_numpy(uv, {2}, "uv");
  const Shape batch = batch_shape(in, 1);
  F64Array values(batch), gradients(join(batch, {2}));
  BoolArray valid(batch);
  const SamplePoints points{batch_size(batch), in.data(), values.mutable_data(),
                            gradients.mutable_data(), valid.mutable_data()};
  {
    const py::gil_scoped_release release;
    sampler(points);
  }
  return py::make_tuple(values, gradients, valid);
}

py::tuple sample_array(const py::object& image,
                       const py::object& uv,
                       SampleInterpolation interpolation,
                       ColorOrder order) {
  const ImageView view = view_of_image(image);
  return sampled(uv, [&](const SamplePoints& points) {
    Plane<float> memory;
    sample_points(grey_view(view, order, memory), interpolation, points);
  });
}

BSplineImage make_bspline(const py::object& image, ColorOrder order) {
  const ImageView view = view_of_image(image);
  const py::gil_scoped_release release;
  Plane<float> memory;
  return BSplineImage(grey_view(view, order, memory));
}

ImagePyramid make_pyramid(const py::object& image,
                          const std::optional<PyramidOptions>& options,
                          ColorOrder order) {
  const ImageView view = view_of_image(image);
  const py::gil_scoped_release release;
  return ImagePyramid(view, options.value_or(PyramidOptions{}), order);
}

// Arrays that show the levels exist: the memory must stay where it is.
void reassign(ImagePyramid& pyramid, const py::object& image, ColorOrder order) {
  const ImageView view = view_of_image(image);
  const Plane<float>& finest = pyramid.level(0);
  if (view.width != finest.width() || view.height != finest.height()) {
    throw ShapeError("image must have the size of the pyramid, (" +
                     std::to_string(finest.height()) + ", " + std::to_string(finest.width()) +
                     "), got " + describe_array(image));
  }
  const py::gil_scoped_release release;
  pyramid.assign(view, {pyramid.num_levels(), 1}, order);
}

DepthPyramid make_depth_pyramid(const py::object& inverse_depth,
                                const py::object& variance,
                                const std::optional<DepthPyramidOptions>& options) {
  const PlaneView<float> D = view_of_plane(inverse_depth, "inverse_depth");
  const PlaneView<float> V = view_of_plane(variance, "variance");
  const py::gil_scoped_release release;
  return DepthPyramid(D, V, options.value_or(DepthPyramidOptions{}));
}

// Counts from the end when negative, as a Python sequence does.
int checked_level(int level, int num_levels) {
  const int index = level < 0 ? level + num_levels : level;
  if (index < 0 || index >= num_levels) throw py::index_error("no such level");
  return index;
}

py::array level_of(const py::object& self, int level) {
  const auto& pyramid = self.cast<const ImagePyramid&>();
  return view_of(pyramid.level(checked_level(level, pyramid.num_levels())).view(), self);
}

using DepthLevel = py::typing::Tuple<py::array, py::array>;

DepthLevel depth_level_of(const py::object& self, int level) {
  const auto& pyramid = self.cast<const DepthPyramid&>();
  const int l = checked_level(level, pyramid.num_levels());
  return py::make_tuple(view_of(pyramid.inverse_depth(l).view(), self),
                        view_of(pyramid.variance(l).view(), self));
}

template <typename Level, typename Pyramid>
void bind_sequence(py::class_<Pyramid>& cls, Level (*level_at)(const py::object&, int)) {
  cls.def("__len__", &Pyramid::num_levels);
  cls.def("__getitem__", level_at, py::arg("level"));
  cls.def("__iter__", [level_at](const py::object& self) -> py::typing::Iterator<Level> {
    py::list levels;
    const int num_levels = self.cast<const Pyramid&>().num_levels();
    for (int l = 0; l < num_levels; ++l) levels.append(level_at(self, l));
    return py::iter(levels);
  });
  cls.def_property_readonly("num_levels", &Pyramid::num_levels, "Levels, the full size included.");
}

void bind_enums(py::module_& m) {
  py::native_enum<Interpolation>(m, "Interpolation", "enum.Enum", "How remap reads between pixels.")
      .value("NEAREST", Interpolation::NEAREST)
      .value("LINEAR", Interpolation::LINEAR)
      .value("CUBIC", Interpolation::CUBIC)
      .finalize();
  py::native_enum<SampleInterpolation>(m, "SampleInterpolation", "enum.Enum",
                                       "How sample reads between pixels.")
      .value("BILINEAR", SampleInterpolation::BILINEAR)
      .value("CENTRAL_DIFFERENCE", SampleInterpolation::CENTRAL_DIFFERENCE)
      .value("CUBIC_BSPLINE", SampleInterpolation::CUBIC_BSPLINE)
      .finalize();
  py::native_enum<ColorOrder>(m, "ColorOrder", "enum.Enum", "Which channel comes first.")
      .value("RGB", ColorOrder::RGB)
      .value("BGR", ColorOrder::BGR)
      .finalize();
}

void bind_functions(py::module_& m) {
  m.def("remap", &remap_array, py::arg("image"), py::arg("map_x"), py::arg("map_y"), py::kw_only(),
        py::arg("interpolation"));
  m.def("to_grey", &grey_array, py::arg("image"), py::kw_only(), py::arg("color_order"));
  m.def("gradient_image", &gradient_array, py::arg("image"), py::kw_only(), py::arg("color_order"));
  m.def("max_gradient", &max_gradient_array, py::arg("image"), py::kw_only(),
        py::arg("color_order"));
  m.def("sample", &sample_array, py::arg("image"), py::arg("uv"), py::kw_only(),
        py::arg("interpolation"), py::arg("color_order"));
}

void bind_options(py::module_& m) {
  using P = PyramidOptions;
  OptionsBinder<P>(m, "PyramidOptions", "How many levels a pyramid has.",
                   [](const P& o) { o.validate(); })
      .field("max_levels", &P::max_levels, ">= 1, level 0 counts.")
      .field("min_side", &P::min_side, "px, >= 1: no level below level 0 has a shorter side.")
      .finish();
  using D = DepthPyramidOptions;
  OptionsBinder<D>(m, "DepthPyramidOptions", "How inverse depth is averaged.",
                   [](const D& o) { o.validate(); })
      .field("pyramid", &D::pyramid, "PyramidOptions, those of the image beside it.")
      .field(
          "max_depth_ratio", &D::max_depth_ratio,
          "> 1: pixels whose depths differ by more than this factor straddle a depth edge, their "
          "parent has no depth; inf: they are averaged.")
      .finish();
}

constexpr const char* kPyramidDoc =
    R"(Grey float images, each half the size of the one before.

pyramid[l] is a read-only (H_l, W_l) float32 array that shows level l; level 0 is the image in grey
0..255. A pixel of level l + 1 is the mean of four of level l, (2u..2u+1, 2v..2v+1); the last column
or row of an odd size is dropped. PinholeCamera.at_level(l) is the camera of level l.)";

void bind_pyramid(py::module_& m) {
  py::class_<ImagePyramid> cls(m, "ImagePyramid", kPyramidDoc);
  cls.def(py::init(&make_pyramid), py::arg("image"), py::kw_only(), py::arg("options") = py::none(),
          py::arg("color_order") = ColorOrder::RGB);
  cls.def("assign", &reassign, py::arg("image"), py::kw_only(),
          py::arg("color_order") = ColorOrder::RGB,
          "Rebuild in place from an image of the same size: nothing is allocated, and arrays taken "
          "from this pyramid before show the new pixels. Not while another thread reads them.");
  bind_sequence(cls, &level_of);
}

constexpr const char* kDepthPyramidDoc =
    R"(Inverse depth D (1 / scene unit) and its variance V per level.

pyramid[l] is (D, V), read-only (H_l, W_l) float32. A pixel has depth where D and V are positive and
finite; all others hold (0, 0). A parent of n >= 1 pixels with depth has D = Σ(D/V) / Σ(1/V) and
V = n / Σ(1/V): their errors count as one, so that averaging does not shrink them.)";

void bind_depth_pyramid(py::module_& m) {
  py::class_<DepthPyramid> cls(m, "DepthPyramid", kDepthPyramidDoc);
  cls.def(py::init(&make_depth_pyramid), py::arg("inverse_depth"), py::arg("variance"),
          py::kw_only(), py::arg("options") = py::none());
  bind_sequence(cls, &depth_level_of);
}

constexpr const char* kBSplineDoc =
    R"(The cubic spline through all pixels of an image, mirrored at the border pixels.

Twice continuously differentiable: value and gradient agree everywhere. A pixel that is not finite
has no data; samples that need it are not valid, the others do not see it. Solving for the
coefficients is the expensive part: keep this object when an image is sampled more than once.

Source: Unser, IEEE Signal Processing Magazine 16(6), 1999.)";

void bind_bspline(py::module_& m) {
  py::class_<BSplineImage> cls(m, "BSplineImage", kBSplineDoc);
  cls.def(py::init(&make_bspline), py::arg("image"), py::kw_only(),
          py::arg("color_order") = ColorOrder::RGB);
  cls.def(
      "sample",
      [](const BSplineImage& self, const py::object& uv) {
        return sampled(uv, [&](const SamplePoints& points) { sample_points(self, points); });
      },
      py::arg("uv"), "values, gradients, valid at uv (..., 2): as raylign.image.sample.");
  cls.def_property_readonly(
      "coefficients",
      [](const py::object& self) {
        return view_of(self.cast<const BSplineImage&>().coefficients(), self);
      },
      "(H + 3, W + 3) float32, read-only: that of pixel (u, v) at [v + 1, u + 1].");
}

}  // namespace

void bind_image(py::module_& m) {
  bind_enums(m);
  bind_functions(m);
  bind_options(m);
  bind_pyramid(m);
  bind_depth_pyramid(m);
  bind_bspline(m);
}

}  // namespace raylign::python
