// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>
#include <pybind11/operators.h>

#include <string>

#include "batch.h"
#include "bindings.h"
#include "options_binder.h"
#include "raylign/photometric/options.h"

namespace raylign::python {
namespace {

void bind_patch_enums(py::module_& m) {
  py::native_enum<LossScope>(m, "LossScope", "enum.Enum",
                             "What the robust law sees: PIXEL each residual by itself, PATCH the "
                             "norm of all residuals of a patch together.")
      .value("PIXEL", LossScope::PIXEL)
      .value("PATCH", LossScope::PATCH)
      .finalize();
  py::native_enum<LeavingRule>(m, "LeavingRule", "enum.Enum",
                               "What a patch costs that leaves its image: KEEP_COST what it cost "
                               "at the start of the solve, ZERO nothing.")
      .value("KEEP_COST", LeavingRule::KEEP_COST)
      .value("ZERO", LeavingRule::ZERO)
      .finalize();
  py::native_enum<PatchBorder>(m, "PatchBorder", "enum.Enum",
                               "What lies behind the right border: REPLICATE the border pixel, "
                               "WRAP the next row, for the original exercise.")
      .value("REPLICATE", PatchBorder::REPLICATE)
      .value("WRAP", PatchBorder::WRAP)
      .finalize();
}

void bind_photometric_enums(py::module_& m) {
  py::native_enum<PatchWarp>(m, "PatchWarp", "enum.Enum",
                             "How a patch is deformed: NONE shifted only, DEPTH as a surface of "
                             "constant depth in its host, NORMAL as a plane with the point's "
                             "normal, AUTO the best of these that is known.")
      .value("AUTO", PatchWarp::AUTO)
      .value("NONE", PatchWarp::NONE)
      .value("DEPTH", PatchWarp::DEPTH)
      .value("NORMAL", PatchWarp::NORMAL)
      .finalize();
  py::native_enum<BrightnessModel>(m, "BrightnessModel", "enum.Enum",
                                   "What of e^a I + b is estimated per image: AFFINE a and b, "
                                   "GAIN a, NONE nothing.")
      .value("AFFINE", BrightnessModel::AFFINE)
      .value("GAIN", BrightnessModel::GAIN)
      .value("NONE", BrightnessModel::NONE)
      .finalize();
  py::native_enum<VisibilityRule>(m, "VisibilityRule", "enum.Enum",
                                  "Which images see a point: AUTO those that pass the tests of "
                                  "VisibilityOptions, TRACKS the problem's tracks, ALL every "
                                  "image.")
      .value("AUTO", VisibilityRule::AUTO)
      .value("TRACKS", VisibilityRule::TRACKS)
      .value("ALL", VisibilityRule::ALL)
      .finalize();
  py::native_enum<CovarianceScope>(m, "CovarianceScope", "enum.Enum",
                                   "Which covariances a result has.")
      .value("NONE", CovarianceScope::NONE)
      .value("POSES", CovarianceScope::POSES)
      .value("ALL", CovarianceScope::ALL)
      .finalize();
}

py::array_t<double> offsets_of(const PatchPattern& pattern) {
  py::array_t<double> offsets({static_cast<py::ssize_t>(pattern.size()), py::ssize_t{2}});
  double* out = offsets.mutable_data();
  for (const auto& offset : pattern.offsets) out = std::copy(offset.begin(), offset.end(), out);
  return offsets;
}

PatchPattern custom_pattern(const py::object& offsets) {
  const F64Array array = batch_from_numpy(offsets, {2}, "offsets");
  if (array.ndim() != 2) {
    throw ShapeError("offsets must be (n, 2) real numbers, got " + describe_array(array));
  }
  PatchPattern pattern{"custom", {}};
  for (py::ssize_t i = 0; i < array.shape(0); ++i) {
    pattern.offsets.push_back({array.at(i, 0), array.at(i, 1)});
  }
  pattern.validate();
  for (const char* name : {"3x3", "4x4", "5x5", "spread8"}) {
    if (PatchPattern::parse(name) == pattern) return PatchPattern::parse(name);
  }
  return pattern;
}

std::string pattern_repr(const PatchPattern& pattern) {
  if (pattern.name != "custom") return "PatchPattern.parse('" + pattern.name + "')";
  return "PatchPattern(" + py::repr(offsets_of(pattern).attr("tolist")()).cast<std::string>() + ")";
}

void bind_pattern(py::module_& m) {
  using P = PatchPattern;
  py::class_<P> cls(m, "PatchPattern", R"(The pixels of a patch, as offsets (du, dv) in px.

PatchPattern([[0, 0], [1, 0], …]) makes one of at most 32 pixels; wherever a pattern is wanted, its
name will do: "4x4" (offsets −2 … 1, by columns), "3x3", "5x5", "spread8" (DSO's eight pixels).)");
  cls.def(py::init(&custom_pattern), py::arg("offsets"))
      .def_static("parse", &P::parse, py::arg("text"), "One of the named patterns.")
      .def_readonly("name", &P::name, "Name, or 'custom'.")
      .def_property_readonly("offsets", &offsets_of, "(n, 2) float64 (du, dv), px.")
      .def_property_readonly("size", &P::size, "n.")
      .def(py::self == py::self)
      .def(
          "to_dict",
          [](const P& self) {
            return py::dict(py::arg("name") = self.name, py::arg("offsets") = offsets_of(self));
          },
          "Name and offsets.")
      .def("__repr__", &pattern_repr)
      .def("__copy__", [](const P& self) { return P(self); })
      .def("__deepcopy__", [](const P& self, const py::dict&) { return P(self); })
      .def("__reduce__", [](const py::object& self) {
        return py::make_tuple(py::type::of(self),
                              py::make_tuple(self.attr("offsets").attr("tolist")()));
      });
  cls.attr("__hash__") = py::none();
}

void bind_brightness_and_noise(py::module_& m) {
  using B = BrightnessOptions;
  OptionsBinder<B>(m, "BrightnessOptions", "Brightness e^a I + b of each image.",
                   [](const B& o) { o.validate(); })
      .field("model", &B::model, "BrightnessModel.")
      .field("prior_sigma_a", &B::prior_sigma_a, "Standard deviation of a around 0, > 0.")
      .field("prior_sigma_b", &B::prior_sigma_b, "Of b around 0, grey levels, > 0.")
      .field("balanced", &B::balanced,
             "Residuals are scaled to one variance at every gain: noise of both images is taken "
             "into account (total least squares). Else it pulls a towards 0.")
      .finish();
  using N = NoiseOptions;
  OptionsBinder<N>(m, "NoiseOptions", "The law of the residuals.", [](const N& o) { o.validate(); })
      .field("loss", &N::loss, "LossType: STUDENT_T, HUBER, CAUCHY or TRIVIAL.")
      .field("scope", &N::scope, "LossScope.")
      .field("scale", &N::scale,
             "0: estimated from the residuals. Else fixed, grey levels: σ of STUDENT_T and "
             "TRIVIAL, the threshold of HUBER and CAUCHY.")
      .field("nu", &N::nu, "Degrees of freedom of STUDENT_T; 0: fitted.")
      .field("sensor_sigma", &N::sensor_sigma,
             "σ of a pixel, grey levels: no estimate is smaller; >= 0.")
      .finish();
}

void bind_visibility(py::module_& m) {
  using V = VisibilityOptions;
  OptionsBinder<V>(m, "VisibilityOptions", "Which images see a point, and which pixels count.",
                   [](const V& o) { o.validate(); })
      .field("rule", &V::rule, "VisibilityRule.")
      .field("max_view_angle", &V::max_view_angle, "Degrees between normal and ray, (0, 90].")
      .field("max_scale_change", &V::max_scale_change,
             "Larger or smaller than in the host by this factor at most, >= 1.")
      .field("occlusion", &V::occlusion,
             "Hidden when behind the nearest point by more than this share; 0: no test.")
      .field("max_residual", &V::max_residual,
             "Median |r| of a patch below this many σ, or min_zncc holds.")
      .field("min_zncc", &V::min_zncc, "Correlation with what the image shows, [-1, 1].")
      .field("min_grey", &V::min_grey, "Darker pixels do not count, grey levels.")
      .field("max_grey", &V::max_grey, "Brighter pixels do not count, grey levels.")
      .field("min_texture", &V::min_texture,
             "Least standard deviation of a patch's grey values, >= 0.")
      .field("min_views", &V::min_views, "Views of a point, its host included, >= 1.")
      .finish();
}

}  // namespace

void bind_photometric_options(py::module_& m) {
  bind_patch_enums(m);
  bind_photometric_enums(m);
  bind_pattern(m);
  bind_brightness_and_noise(m);
  bind_visibility(m);
  using P = PhotometricOptions;
  OptionsBinder<P>(m, "PhotometricOptions", "How a photometric bundle adjustment is solved.",
                   [](const P& o) { o.validate(); })
      .field("backend", &P::backend, "Backend.")
      .field("point_parametrization", &P::point_parametrization,
             "PointParametrization: XYZ, or INVERSE_DEPTH, which needs hosts.")
      .field("pattern", &P::pattern, "PatchPattern, or its name.")
      .field("warp", &P::warp, "PatchWarp.")
      .field("interpolation", &P::interpolation, "SampleInterpolation.")
      .field("presmooth", &P::presmooth,
             "σ of a Gaussian on the images, px; 0 with stored patches. Negative: by the noise of "
             "the pixels, σ: 0.3 √σ and 0.7 at most where σ is a grey level or more, else 0.")
      .field("num_levels", &P::num_levels,
             "Pyramid levels; 0: as many as the expected shift needs.")
      .field("brightness", &P::brightness, "BrightnessOptions.")
      .field("noise", &P::noise, "NoiseOptions.")
      .field("visibility", &P::visibility, "VisibilityOptions.")
      .field("refine_poses", &P::refine_poses, "Poses may move.")
      .field("refine_points", &P::refine_points, "Points may move.")
      .field("refine_intrinsics", &P::refine_intrinsics, "fx, fy, cx, cy may move.")
      .field("max_num_rounds", &P::max_num_rounds,
             "Per level, each with its own visibility, warps and law, >= 1.")
      .field("hold_out", &P::hold_out,
             "Every this many points one is kept for the acceptance test; 0: no test.")
      .field("force", &P::force, "Return the refined state even when it is not accepted.")
      .field("covariance", &P::covariance, "CovarianceScope.")
      .field("leaving", &P::leaving, "LeavingRule.")
      .field("max_leaving_share", &P::max_leaving_share,
             "A step that more of the seen patches leave by is refused.")
      .field("border", &P::border, "PatchBorder.")
      .field("min_depth", &P::min_depth, "Nearer points are not seen; -inf: seen from behind, too.")
      .field("lm", &P::lm, "LmOptions, threads among them.")
      .field("additive_damping", &P::additive_damping,
             "λ I instead of λ diag(H), lm.initial_lambda a share of max diag(H): the original "
             "exercise.")
      .finish();
}

}  // namespace raylign::python
