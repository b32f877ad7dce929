// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/eigen.h>
#include <pybind11/native_enum.h>

#include <string>
#include <utility>

#include "batch.h"
#include "bindings.h"
#include "image.h"
#include "options_binder.h"
#include "raylign/synthetic/render/depth_sensor.h"
#include "raylign/synthetic/render/renderer.h"
#include "raylign/synthetic/render/sensor.h"

namespace raylign::python {
namespace {

void bind_texture(py::module_& m) {
  py::native_enum<TextureKind>(m, "TextureKind", "enum.Enum", "What is painted on a surface.")
      .value("BANDLIMITED", TextureKind::BANDLIMITED,
             "A sum of plane waves: no detail below min_wavelength, smooth to any order.")
      .value("NOISE", TextureKind::NOISE, "Octaves of C2 value noise.")
      .value("CHECKER", TextureKind::CHECKER, "Squares of side min_wavelength / 2.")
      .value("UNIFORM", TextureKind::UNIFORM, "The mean alone.")
      .finalize();
  using O = TextureOptions;
  OptionsBinder<O>(m, "TextureOptions", "A procedural texture, in grey values 0..255.",
                   [](const O& options) { options.validate(); })
      .field("kind", &O::kind, "TextureKind: BANDLIMITED, NOISE, CHECKER or UNIFORM.")
      .field("seed", &O::seed, "Unsigned 64-bit; every face draws its own texture from it.")
      .field("min_wavelength", &O::min_wavelength, "Shortest wavelength, scene units, > 0.")
      .field("max_wavelength", &O::max_wavelength,
             "Longest wavelength, scene units, >= min_wavelength.")
      .field("num_waves", &O::num_waves, "BANDLIMITED: plane waves, in [1, 4096].")
      .field("mean", &O::mean, "Mean grey value, in [0, 255].")
      .field("contrast", &O::contrast,
             "Standard deviation in grey values, >= 0; CHECKER: bright and dark are mean +- it.")
      .finish();
}

void bind_height_field(py::module_& m) {
  using O = HeightFieldOptions;
  OptionsBinder<O>(m, "HeightFieldOptions", "Smooth hills: a sum of plane waves over a rectangle.",
                   [](const O& options) { options.validate(); })
      .field("width", &O::width, "Extent along x, scene units, > 0.")
      .field("height", &O::height, "Extent along y, scene units, > 0.")
      .field("amplitude", &O::amplitude, "Standard deviation of z, scene units, >= 0.")
      .field("min_wavelength", &O::min_wavelength,
             "Shortest wavelength of the hills, scene units, > 0.")
      .field("max_wavelength", &O::max_wavelength,
             "Longest wavelength of the hills, scene units, >= min_wavelength.")
      .field("num_waves", &O::num_waves, "Plane waves, in [1, 256].")
      .field("seed", &O::seed, "Unsigned 64-bit: draws the hills.")
      .finish();
}

void bind_render_options(py::module_& m) {
  py::native_enum<Antialiasing>(m, "Antialiasing", "enum.Enum",
                                "How a pixel becomes one grey value.")
      .value("NONE", Antialiasing::NONE,
             "The grey value where the centre ray lands: the same from every view, to rounding.")
      .value("BANDLIMIT", Antialiasing::BANDLIMIT,
             "The same without texture detail that the pixel grid cannot hold (2.5 to 4 px).")
      .value("SUPERSAMPLE", Antialiasing::SUPERSAMPLE,
             "Mean over the pixel of supersampling^2 rays, then the lens: a Gaussian PSF.")
      .finalize();
  using O = RenderOptions;
  OptionsBinder<O>(m, "RenderOptions",
                   "Options of `raylign.synthetic.render`. Motion blur and rolling shutter need a "
                   "`motion`.",
                   [](const O& options) { options.validate(); })
      .field("antialiasing", &O::antialiasing, "Antialiasing: NONE, BANDLIMIT or SUPERSAMPLE.")
      .field("supersampling", &O::supersampling,
             "SUPERSAMPLE: rays per pixel and axis, in [1, 16].")
      .field("psf_sigma", &O::psf_sigma, "SUPERSAMPLE: sigma of the PSF in px, in [0, 5].")
      .field("background", &O::background, "Grey value where no surface is met, in [0, 255].")
      .field("exposure_time", &O::exposure_time,
             "Motion blur: shutter time in frame intervals, in [0, 1].")
      .field("blur_samples", &O::blur_samples, "Motion blur: instants averaged, in [1, 1024].")
      .field("readout_time", &O::readout_time,
             "Rolling shutter: first to last row in frame intervals, in [0, 1].")
      .field("num_threads", &O::num_threads, "In [1, 1024]; the bits do not depend on it.")
      .finish();
}

void bind_sensor(py::module_& m) {
  py::native_enum<SensorResponse>(m, "SensorResponse", "enum.Enum",
                                  "Grey value out for light in, both on the scale 0..255.")
      .value("LINEAR", SensorResponse::LINEAR)
      .value("GAMMA", SensorResponse::GAMMA, "255 (x / 255)^(1 / gamma)")
      .value("LUT", SensorResponse::LUT, "Linear between the values of `lut`.")
      .finalize();
  py::native_enum<PixelType>(m, "PixelType", "enum.Enum", "What a pixel is stored as.")
      .value("UINT8", PixelType::UINT8)
      .value("UINT16", PixelType::UINT16)
      .value("FLOAT32", PixelType::FLOAT32)
      .finalize();
  using O = SensorOptions;
  OptionsBinder<O>(
      m, "SensorOptions",
      "A camera's sensor and electronics.\n\nimage = response(vignette(r) * exposure * "
      "e^gain * irradiance + bias) + N(0, read_noise^2 +\nshot_noise * signal), then "
      "rounded and clipped to `format`; r is the distance to the image\ncentre over "
      "half the diagonal.",
      [](const O& options) { options.validate(); })
      .field("exposure", &O::exposure, "Factor of the light, > 0.")
      .field("gain", &O::gain, "a: the light is multiplied by e^a, in [-10, 10].")
      .field("bias", &O::bias, "b: grey values added.")
      .field("vignette_r2", &O::vignette_r2,
             "vignette(r) = 1 + vignette_r2 r^2 + vignette_r4 r^4 + vignette_r6 r^6 > 0.")
      .field("vignette_r4", &O::vignette_r4, "See vignette_r2.")
      .field("vignette_r6", &O::vignette_r6, "See vignette_r2.")
      .field("response", &O::response, "SensorResponse: LINEAR, GAMMA or LUT.")
      .field("gamma", &O::gamma, "GAMMA: in [0.1, 10].")
      .field("lut", &O::lut,
             "LUT: list of at least two values in [0, 255] that do not decrease, at equal steps of "
             "the light from 0 to 255.")
      .field("read_noise", &O::read_noise,
             "Sigma of the signal-independent noise in grey values, >= 0.")
      .field("shot_noise", &O::shot_noise, "Variance of the noise per grey value, >= 0.")
      .field("format", &O::format,
             "PixelType: UINT8; UINT16, where 65535 is grey 255; FLOAT32, neither rounded nor "
             "clipped.")
      .finish();
}

using DoubleMap = Eigen::Map<const Rows<double, Eigen::Dynamic>>;

DoubleMap map_of(const F64Array& array, const char* name) {
  if (array.ndim() != 2) throw ShapeError(std::string(name) + " must be of shape (H, W)");
  return {array.data(), array.shape(0), array.shape(1)};
}

py::array expose_map(const py::object& irradiance,
                     const SensorOptions& options,
                     std::uint64_t seed,
                     std::uint64_t index) {
  const F64Array array = batch_from_numpy(irradiance, {}, "irradiance");
  const DoubleMap map = map_of(array, "irradiance");
  Image image;
  {
    const py::gil_scoped_release release;
    image = expose(map, options, seed, index);
  }
  return to_numpy(std::move(image));
}

void bind_depth_sensor(py::module_& m) {
  using O = DepthSensorOptions;
  OptionsBinder<O>(
      m, "DepthSensorOptions",
      "A depth camera: noise on the inverse depth D = 1/Z, its quantisation, and holes. "
      "The default is\nlike a Kinect.",
      [](const O& options) { options.validate(); })
      .field("model", &O::model,
             "DepthModel: law of the noise, range, and how far from a step of the depth there is "
             "none.")
      .field("noise", &O::noise, "Factor of the law's sigma, >= 0; 0: no noise.")
      .field("correlation_length", &O::correlation_length,
             "l in px, in [0, 64]: the noise has autocorrelation exp(-d^2 / (2 l^2)).")
      .field("inverse_depth_step", &O::inverse_depth_step,
             "D is rounded to multiples of it, 1/m, >= 0; 0: not rounded. 0.0029 is 1/8 px of "
             "disparity at f b = 575 px * 7.5 cm.")
      .field("max_incidence_deg", &O::max_incidence_deg,
             "No depth where ray and normal differ by more, degrees, in (0, 90].")
      .field("dropout", &O::dropout, "Fraction of the pixels without depth at random, in [0, 1].")
      .finish();
}

RadtanCamera as_radtan(const RadtanCamera& camera) { return camera; }
RadtanCamera as_radtan(const PinholeCamera& camera) { return RadtanCamera(camera, {}); }

template <typename T>
T one(const py::object& object, const char* name) {
  const F64Array array = batch_from_numpy(object, Item<T>::shape(), name);
  if (array.ndim() != static_cast<py::ssize_t>(Item<T>::shape().size())) {
    throw ShapeError(std::string(name) + " must be one item of shape " +
                     detail::shape_text(Item<T>::shape()) + " without leading axes");
  }
  return Item<T>::load(array.data());
}

// Grey values (...) and gradients (..., 3), world frame, of a face's texture at points (..., 3).
py::tuple texture_at(const RenderScene& scene, int face, const py::object& p_w) {
  const int num_faces = static_cast<int>(scene.faces().size());
  require_option(face >= 0 && face < num_faces, "face", "a face of the scene", face);
  const F64Array points = batch_from_numpy(p_w, {3}, "p_w");
  const Shape batch = batch_shape(points, 1);
  F64Array values(batch);
  F64Array gradients(join(batch, {3}));
  const double* in = points.data();
  double* value = values.mutable_data();
  double* gradient = gradients.mutable_data();
  const py::ssize_t size = values.size();
  const py::gil_scoped_release release;
  for (py::ssize_t i = 0; i < size; ++i) {
    Vector3 slope;
    value[i] = scene.grey_value(face, Item<Vector3>::load(in + 3 * i), &slope);
    Item<Vector3>::store(slope, gradient + 3 * i);
  }
  py::gil_scoped_acquire acquire;
  return py::make_tuple(values, gradients);
}

void bind_scene_class(py::module_& m) {
  py::class_<RenderScene>(
      m, "Scene",
      "Textured surfaces in a world frame, all opaque and evenly lit: a point has the same grey\n"
      "value from everywhere. `T_ws` (4, 4) maps the frame of the surface to the world. The add_\n"
      "methods raise OptionsError for a size that is not positive or a T_ws that is not rigid.")
      .def(py::init<>())
      .def(
          "add_box",
          [](RenderScene& self, const py::object& T_ws, const py::object& size,
             const TextureOptions& texture) {
            self.add_box(one<Matrix4>(T_ws, "T_ws"), one<Vector3>(size, "size"), texture);
          },
          py::arg("T_ws"), py::kw_only(), py::arg("size"), py::arg("texture"),
          "Add a box of `size` (x, y, z) around the origin of s: six faces; from inside, a room.")
      .def(
          "add_rectangle",
          [](RenderScene& self, const py::object& T_ws, double width, double height,
             const TextureOptions& texture) {
            self.add_rectangle(one<Matrix4>(T_ws, "T_ws"), width, height, texture);
          },
          py::arg("T_ws"), py::kw_only(), py::arg("width"), py::arg("height"), py::arg("texture"),
          "Add the rectangle z = 0 of s, centred; infinite sides are allowed.")
      .def(
          "add_sphere",
          [](RenderScene& self, const py::object& T_ws, double radius,
             const TextureOptions& texture) {
            self.add_sphere(one<Matrix4>(T_ws, "T_ws"), radius, texture);
          },
          py::arg("T_ws"), py::kw_only(), py::arg("radius"), py::arg("texture"),
          "Add a sphere around the origin of s, with a solid texture.")
      .def(
          "add_height_field",
          [](RenderScene& self, const py::object& T_ws, const HeightFieldOptions& options,
             const TextureOptions& texture) {
            self.add_height_field(one<Matrix4>(T_ws, "T_ws"), options, texture);
          },
          py::arg("T_ws"), py::kw_only(), py::arg("options"), py::arg("texture"),
          "Add hills z(x, y) over a rectangle of s.")
      .def("add", &RenderScene::add, py::arg("other"), "Add everything in another scene.")
      .def(
          "__add__",
          [](const RenderScene& self, const RenderScene& other) {
            RenderScene sum = self;
            sum.add(other);
            return sum;
          },
          py::arg("other"))
      .def_property_readonly(
          "num_faces", [](const RenderScene& self) { return self.faces().size(); },
          "Faces, the values of the face map of a frame: a box has six, the others one.")
      .def("texture_at", &texture_at, py::arg("face"), py::arg("p_w"),
           "Grey values (...) and their gradients (..., 3) by the point, world frame, of the\n"
           "texture of a face at points (..., 3); closed form. Points off the surface are\n"
           "projected along its normal (not on a sphere, whose texture is solid).");
}

py::tuple render(const RenderScene& scene,
                 const RadtanCamera& camera,
                 const py::object& T_cw,
                 int width,
                 int height,
                 const RenderOptions& options,
                 const py::object& motion) {
  const Matrix4 pose = one<Matrix4>(T_cw, "T_cw");
  const Vector6 twist =
      motion.is_none() ? Vector6(Vector6::Zero()) : one<Vector6>(motion, "motion");
  RenderedFrame frame;
  {
    const py::gil_scoped_release release;
    frame = render_frame(scene, camera, pose, width, height, options, twist);
  }
  py::array normal = py::cast(std::move(frame.normal));
  return py::make_tuple(py::cast(std::move(frame.irradiance)), py::cast(std::move(frame.depth)),
                        normal.reshape({height, width, 3}), py::cast(std::move(frame.face)));
}

Rows<float, Eigen::Dynamic> sense(const py::object& depth,
                                  const py::object& normal,
                                  const RadtanCamera& camera,
                                  const DepthSensorOptions& options,
                                  std::uint64_t seed,
                                  std::uint64_t index) {
  const F64Array z = batch_from_numpy(depth, {}, "depth");
  const F64Array n = batch_from_numpy(normal, {3}, "normal");
  const DoubleMap depth_map = map_of(z, "depth");
  if (n.ndim() != 3 || n.shape(0) != z.shape(0) || n.shape(1) != z.shape(1)) {
    throw ShapeError("normal must be of shape (H, W, 3) as depth, got " + describe_array(n));
  }
  const Eigen::Map<const Rows<double, 3>> normals(n.data(), z.size(), 3);
  const py::gil_scoped_release release;
  return sense_depth(depth_map, normals, camera, options, seed, index);
}

template <typename Camera>
void bind_functions(py::module_& m) {
  m.def(
      "render",
      [](const RenderScene& scene, const Camera& camera, const py::object& T_cw, int width,
         int height, const RenderOptions& options, const py::object& motion) {
        return render(scene, as_radtan(camera), T_cw, width, height, options, motion);
      },
      py::arg("scene"), py::arg("camera"), py::arg("T_cw"), py::kw_only(), py::arg("width"),
      py::arg("height"), py::arg("options"), py::arg("motion"),
      "(irradiance, depth, normal, face).");
  m.def(
      "sense_depth",
      [](const py::object& depth, const py::object& normal, const Camera& camera,
         const DepthSensorOptions& options, std::uint64_t seed, std::uint64_t index) {
        return sense(depth, normal, as_radtan(camera), options, seed, index);
      },
      py::arg("depth"), py::arg("normal"), py::arg("camera"), py::kw_only(), py::arg("options"),
      py::arg("seed"), py::arg("index"));
}

}  // namespace

void bind_render(py::module_& m) {
  bind_texture(m);
  bind_height_field(m);
  bind_render_options(m);
  bind_scene_class(m);
  bind_sensor(m);
  bind_depth_sensor(m);
  m.def("expose", &expose_map, py::arg("irradiance"), py::kw_only(), py::arg("options"),
        py::arg("seed"), py::arg("index"));
  bind_functions<PinholeCamera>(m);
  bind_functions<RadtanCamera>(m);
  m.def(
      "noise_field",
      [](int width, int height, double correlation_length, std::uint64_t seed,
         std::uint64_t index) {
        const py::gil_scoped_release release;
        return noise_field(width, height, correlation_length, seed, index);
      },
      py::kw_only(), py::arg("width"), py::arg("height"), py::arg("correlation_length"),
      py::arg("seed"), py::arg("index"));
}

}  // namespace raylign::python
