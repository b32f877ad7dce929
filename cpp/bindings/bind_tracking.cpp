// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/eigen.h>
#include <pybind11/native_enum.h>

#include <memory>
#include <mutex>
#include <utility>

#include "batch.h"
#include "bindings.h"
#include "image.h"
#include "options_binder.h"
#include "raylign/tracking/aligner.h"

namespace raylign::python {
namespace {

void bind_tracking_enums(py::module_& m) {
  py::native_enum<NoiseModel>(
      m, "NoiseModel", "enum.Enum",
      "Intensity noise of the residual: CONSTANT 2 σ_I² as the paper, EXACT "
      "what interpolation and the pyramid leave of it.")
      .value("CONSTANT", NoiseModel::CONSTANT)
      .value("EXACT", NoiseModel::EXACT)
      .finalize();
  py::native_enum<SigmaMode>(
      m, "SigmaMode", "enum.Enum",
      "When σ_r is computed: REEVALUATE at each accepted pose, FROZEN at the "
      "start of a level.")
      .value("REEVALUATE", SigmaMode::REEVALUATE)
      .value("FROZEN", SigmaMode::FROZEN)
      .finalize();
  py::native_enum<GradientMode>(m, "GradientMode", "enum.Enum",
                                "Gradient in the Jacobian: FORWARD the target's, ESM the mean of "
                                "both images'.")
      .value("FORWARD", GradientMode::FORWARD)
      .value("ESM", GradientMode::ESM)
      .finalize();
  py::native_enum<AffineMode>(m, "AffineMode", "enum.Enum",
                              "How the target's brightness e^a I + b is found.")
      .value("NONE", AffineMode::NONE)
      .value("CLOSED_FORM", AffineMode::CLOSED_FORM)
      .value("JOINT", AffineMode::JOINT)
      .finalize();
  py::native_enum<MotionGroup>(
      m, "MotionGroup", "enum.Enum",
      "What moves: SE3, SO3 (rotation about the target's own centre), SIM3 "
      "(needs depth of the target).")
      .value("SE3", MotionGroup::SE3)
      .value("SO3", MotionGroup::SO3)
      .value("SIM3", MotionGroup::SIM3)
      .finalize();
  py::native_enum<AlignmentStatus>(m, "AlignmentStatus", "enum.Enum",
                                   "Whether a result may be used, and if not, why.")
      .value("OK", AlignmentStatus::OK)
      .value("LOST_OVERLAP", AlignmentStatus::LOST_OVERLAP)
      .value("TOO_FEW_POINTS", AlignmentStatus::TOO_FEW_POINTS)
      .value("DIVERGED", AlignmentStatus::DIVERGED)
      .value("NOT_CONVERGED", AlignmentStatus::NOT_CONVERGED)
      .value("DEGENERATE", AlignmentStatus::DEGENERATE)
      .value("LOW_TEXTURE", AlignmentStatus::LOW_TEXTURE)
      .value("MOTION_BOUND", AlignmentStatus::MOTION_BOUND)
      .finalize();
}

void bind_nested_options(py::module_& m) {
  using A = AffineOptions;
  OptionsBinder<A>(m, "AffineOptions", "Brightness e^a I + b of the target.",
                   [](const A& a) { a.validate(); })
      .field("mode", &A::mode, "AffineMode.")
      .field("prior_sigma_a", &A::prior_sigma_a,
             "JOINT: standard deviation of a, as if each point had measured a = 0.")
      .field("prior_sigma_b", &A::prior_sigma_b, "JOINT: the same of b, grey levels.")
      .finish();
  using D = DepthTermOptions;
  OptionsBinder<D>(m, "DepthTermOptions",
                   "The depth residual 1/Z' − D_t(p'), used when the target has depth.",
                   [](const D& d) { d.validate(); })
      .field("enabled", &D::enabled, "Use it.")
      .field("estimate_weight", &D::estimate_weight,
             "Weigh the two terms by their own residuals, level by level.")
      .field("weight", &D::weight, "Factor of the depth term's cost, times the estimated one.")
      .field("use_gradient", &D::use_gradient, "Slope of the target's depth in the derivatives.")
      .field("max_difference", &D::max_difference,
             "Share of the target's inverse depth beyond which it shows another surface, > 0.")
      .finish();
  using C = AcceptanceOptions;
  OptionsBinder<C>(m, "AcceptanceOptions",
                   "When a result is not OK. Ratios are of reference points.",
                   [](const C& c) { c.validate(); })
      .field("min_points", &C::min_points, "Reference points on the finest level.")
      .field("min_overlap", &C::min_overlap, "Share of them in the target's view.")
      .field("min_good_ratio", &C::min_good_ratio, "Share of those with r² < 40² + |∇I|²/4.")
      .field("min_agreement", &C::min_agreement, "AlignmentResult.agreement.")
      .field("max_translation", &C::max_translation,
             "From keyframe to target, share of the mean depth.")
      .field("max_rotation", &C::max_rotation, "From keyframe to target, rad.")
      .field("max_sigma", &C::max_sigma,
             "Standard deviation along the weakest direction: rad, or share of the mean depth.")
      .finish();
}

void bind_tracking_options(py::module_& m) {
  bind_nested_options(m);
  using T = TrackingOptions;
  OptionsBinder<T>(m, "TrackingOptions", "How a frame is aligned with a keyframe.",
                   [](const T& t) { t.validate(); })
      .field("motion", &T::motion, "MotionGroup.")
      .field("noise_model", &T::noise_model, "NoiseModel.")
      .field("sigma_intensity", &T::sigma_intensity, "σ_I, grey levels; √8: 2 σ_I² = 16.")
      .field("adapt_sigma", &T::adapt_sigma,
             "Whether σ_r is scaled to residuals that are much smaller.")
      .field("min_sigma_intensity", &T::min_sigma_intensity,
             "What it is scaled to at most, σ_I in grey levels, > 0.")
      .field("sigma_mode", &T::sigma_mode, "SigmaMode.")
      .field("loss", &T::loss, "Robust law of r / σ_r.")
      .field("gradient", &T::gradient, "GradientMode.")
      .field("affine", &T::affine, "AffineOptions.")
      .field("depth", &T::depth, "DepthTermOptions.")
      .field("finest_level", &T::finest_level, "Last level; 0 is the full image.")
      .field("coarsest_level", &T::coarsest_level, "First level.")
      .field("rotation_first", &T::rotation_first,
             "Turn the start on the first level, by intensities alone, before anything else moves.")
      .field("level_iterations", &T::level_iterations,
             "Iterations on level l at most; lm.max_num_iterations where there is none.")
      .field("lm", &T::lm, "LmOptions, threads among them.")
      .field("acceptance", &T::acceptance, "AcceptanceOptions.")
      .finish();
  using K = KeyframeOptions;
  OptionsBinder<K>(m, "KeyframeOptions", "Which pixels of a keyframe become points.",
                   [](const K& k) { k.validate(); })
      .field("min_gradient", &K::min_gradient, "|∇I| at least, grey levels per px of the level.")
      .field("max_points", &K::max_points,
             "Budget per level, evenly over the image, strongest first; 0: no limit.")
      .field("spacing", &K::spacing, "Only pixels of a grid this wide, px.")
      .field("block_size", &K::block_size,
             "Side of the blocks taken as correlated by the covariance, px.")
      .finish();
}

// View of an (H, W) float32 array with dense rows; valid while the array lives.
PlaneView<float> plane_of(const py::object& object, const std::string& name) {
  const bool is_plane = py::isinstance<py::array_t<float>>(object) &&
                        py::reinterpret_borrow<py::array>(object).ndim() == 2;
  const ImageView view = is_plane ? view_of_image(object, name) : ImageView{};
  if (!is_plane || view.row_stride % sizeof(float) != 0) {
    throw ShapeError(name + " must be a float32 array of shape (H, W), got " +
                     describe_array(object));
  }
  return {static_cast<const float*>(view.data), view.width, view.height,
          static_cast<std::ptrdiff_t>(view.row_stride / sizeof(float))};
}

std::shared_ptr<Frame> make_frame(const py::object& image,
                                  const PinholeCamera& camera,
                                  const py::object& inverse_depth,
                                  const py::object& variance,
                                  int max_levels) {
  const ImageView view = view_of_image(image);
  const bool with_depth = !inverse_depth.is_none();
  PlaneView<float> D, V;
  if (with_depth) {
    D = plane_of(inverse_depth, "inverse_depth");
    V = plane_of(variance, "variance");
  }
  const py::gil_scoped_release release;
  auto frame = std::make_shared<Frame>(view, camera, max_levels);
  if (with_depth) frame->set_depth(D, V);
  return frame;
}

template <typename T>
py::array_t<T> to_numpy(const Plane<T>& plane) {
  return py::array_t<T>({plane.height(), plane.width()}, plane.data());
}

// (P, 7) float32: u, v, inverse depth, its variance, intensity, gradient; padding left out.
py::array_t<float> points_to_numpy(const Keyframe& keyframe, int level) {
  require_option(level >= 0 && level < keyframe.num_levels(), "level", "a level of the keyframe",
                 level);
  const PointList& points = keyframe.points(level);
  const tracking::PointArrays arrays = points.arrays();
  const int width = keyframe.frame().width(level);
  py::array_t<float> out({static_cast<py::ssize_t>(points.num_points()), py::ssize_t{7}});
  float* row = out.mutable_data();
  for (std::int64_t i = 0; i < points.padded_size(); ++i) {
    const std::int32_t pixel = points.pixels()[static_cast<std::size_t>(i)];
    if (pixel < 0) continue;
    const float values[] = {static_cast<float>(pixel % width),
                            static_cast<float>(pixel / width),
                            arrays.D[i],
                            arrays.V[i],
                            arrays.I[i],
                            arrays.g_u[i],
                            arrays.g_v[i]};
    row = std::copy(values, values + 7, row);
  }
  return out;
}

void bind_frames(py::module_& m) {
  py::class_<Frame, std::shared_ptr<Frame>>(m, "TrackingFrame")
      .def(py::init(&make_frame), py::arg("image"), py::arg("camera"), py::kw_only(),
           py::arg("inverse_depth").none(true), py::arg("variance").none(true),
           py::arg("max_levels"))
      .def_property_readonly("num_levels", &Frame::num_levels)
      .def_property_readonly("has_depth", &Frame::has_depth);
  py::class_<Keyframe, std::shared_ptr<Keyframe>>(m, "TrackingKeyframe")
      .def(py::init([](std::shared_ptr<Frame> frame, const KeyframeOptions& options) {
             return std::make_shared<Keyframe>(std::move(frame), options);
           }),
           py::arg("frame"), py::kw_only(), py::arg("options"))
      .def_property_readonly("num_levels", &Keyframe::num_levels)
      .def_property_readonly("options", [](const Keyframe& self) { return self.options(); })
      .def_property_readonly("camera", [](const Keyframe& self) { return self.frame().camera(0); })
      .def("points", &points_to_numpy, py::arg("level"));
}

// A block of [υ; ω; σ] as the motion has it: σ belongs to SIM3 alone.
py::array_t<double> pose_block(const AlignmentResult& result, const Matrix7& block) {
  if (result.motion == MotionGroup::SIM3) return py::cast(RowMajor<7, 7>(block));
  return py::cast(RowMajor<6, 6>(block.topLeftCorner<6, 6>()));
}

void bind_level_result(py::module_& m) {
  py::class_<LevelResult>(m, "LevelResult", "One level of an alignment, coarse to fine.")
      .def_readonly("level", &LevelResult::level, "0 is the full image.")
      .def_readonly("num_points", &LevelResult::num_points, "Reference points.")
      .def_readonly("num_evaluations", &LevelResult::num_evaluations, "Passes over the points.")
      .def_readonly("depth_weight", &LevelResult::depth_weight,
                    "Factor of the depth term's cost; 0 without depth.")
      .def_readonly("summary", &LevelResult::summary, "Summary: costs, iterations, why it ended.");
}

void bind_maps(py::module_& m) {
  using M = AlignmentMaps;
  py::class_<M>(m, "AlignmentMaps",
                "(H, W) per pixel of the finest level tracked on; NaN where there is no residual.")
      .def_property_readonly(
          "residual", [](const M& s) { return to_numpy(s.residual); },
          "float32: r = I_h − (e^a I_t + b), grey levels.")
      .def_property_readonly(
          "sigma", [](const M& s) { return to_numpy(s.sigma); }, "float32: σ_r, grey levels.")
      .def_property_readonly(
          "normalised_residual", [](const M& s) { return to_numpy(s.normalised_residual); },
          "float32: r / σ_r.")
      .def_property_readonly(
          "weight", [](const M& s) { return to_numpy(s.weight); },
          "float32: ρ′, the robust weight.")
      .def_property_readonly(
          "warped", [](const M& s) { return to_numpy(s.warped); },
          "float32: e^a I_t(p') + b, wherever the keyframe has depth.")
      .def_property_readonly(
          "mask",
          [](const M& s) { return to_numpy(s.mask).attr("astype")("bool").cast<py::array>(); },
          "bool: a point with a residual.");
}

void bind_result(py::module_& m) {
  using R = AlignmentResult;
  py::class_<R>(m, "AlignmentResult", R"(What `align` found.

ξ = [υ; ω], for SIM3 [υ; ω; σ], is the left perturbation T_th ← exp(ξ) T_th; n is 6, for SIM3 7.)")
      .def_property_readonly(
          "T_th", [](const R& r) { return RowMajor<4, 4>(r.T_th); }, "(4, 4): keyframe to target.")
      .def_readonly("status", &R::status, "AlignmentStatus.")
      .def_readonly("reason", &R::reason, "Why, with the number and the limit it broke.")
      .def_property_readonly(
          "ok", [](const R& r) { return r.status == AlignmentStatus::OK; }, "status is OK.")
      .def_property_readonly(
          "covariance", [](const R& r) { return pose_block(r, r.covariance); },
          "(n, n) of ξ: block-wise sandwich, calibrated for residuals that are correlated within "
          "blocks; NaN when there are too few blocks.")
      .def_property_readonly(
          "hessian_covariance", [](const R& r) { return pose_block(r, r.hessian_covariance); },
          "(n, n) of ξ: inverse of `information`, right for independent residuals.")
      .def_property_readonly(
          "information", [](const R& r) { return pose_block(r, r.information); },
          "(n, n): JᵀWJ of ξ, brightness marginalised; zeros where the motion is held.")
      .def_readonly("inflation", &R::inflation,
                    "Mean ratio of covariance to hessian_covariance; -1: unknown.")
      .def_property_readonly(
          "information_eigenvalues",
          [](const R& r) {
            return py::array_t<double>(static_cast<py::ssize_t>(r.information_eigenvalues.size()),
                                       r.information_eigenvalues.data());
          },
          "Ascending, translation in units of the mean depth.")
      .def_property_readonly(
          "weakest_direction",
          [](const R& r) {
            const int n = r.motion == MotionGroup::SIM3 ? 7 : 6;
            return py::array_t<double>(n, r.weakest_direction.data());
          },
          "(n,): unit eigenvector of the smallest eigenvalue.")
      .def_readonly("sigma_scale", &R::sigma_scale, "By which σ_r was scaled (adapt_sigma).")
      .def_readonly("residual_variance", &R::residual_variance,
                    "Σ ρ′ n² / Σ ρ′ of n = r / σ_r: 1 when σ_r is right.")
      .def_readonly("depth_residual_variance", &R::depth_residual_variance,
                    "The same of the depth term; -1 without.")
      .def_readonly("num_points", &R::num_points, "Reference points of the finest level.")
      .def_readonly("overlap", &R::overlap, "Share of them in view.")
      .def_readonly("usage", &R::usage, "The same, points that recede counting less.")
      .def_readonly("good_ratio", &R::good_ratio, "Share of those in view that agree.")
      .def_readonly("agreement", &R::agreement,
                    "Share of points that agree within 3 σ_r beyond what a wrong pose scores by "
                    "chance: 1 all, 0 none.")
      .def_readonly("a", &R::a, "Brightness: r = I_h − (e^a I_t + b).")
      .def_readonly("b", &R::b, "Grey levels.")
      .def_readonly("mean_inverse_depth", &R::mean_inverse_depth, "Of the points, 1/scene unit.")
      .def_readonly("levels", &R::levels, "list[LevelResult], coarse to fine.")
      .def_property_readonly(
          "maps",
          [](const R& r) -> py::object {
            if (r.maps.mask.empty()) return py::none();
            return py::cast(r.maps);
          },
          "AlignmentMaps, or None unless asked for.")
      .def("__repr__", [](const R& r) {
        return "<AlignmentResult: " + to_string(r.status) + ", " + r.reason + ">";
      });
}

// Python threads may share an aligner; its memory is for one call at a time.
struct SharedAligner {
  explicit SharedAligner(const TrackingOptions& options) : aligner(options) {}
  Aligner aligner;
  std::mutex mutex;
};

AlignmentResult align(SharedAligner& self,
                      const Keyframe& keyframe,
                      const Frame& target,
                      const py::object& T_init,
                      double a,
                      double b,
                      bool maps) {
  const F64Array T = batch_from_numpy(T_init, {4, 4}, "T_init");
  if (T.ndim() != 2) throw ShapeError("T_init must be one 4x4 matrix");
  AlignmentStart start;
  start.T_th = Item<Matrix4>::load(T.data());
  start.a = a;
  start.b = b;
  const py::gil_scoped_release release;
  const std::lock_guard<std::mutex> lock(self.mutex);
  return self.aligner.align(keyframe, target, start, maps);
}

}  // namespace

void bind_tracking(py::module_& m) {
  bind_tracking_enums(m);
  bind_tracking_options(m);
  bind_frames(m);
  bind_level_result(m);
  bind_maps(m);
  bind_result(m);
  py::class_<SharedAligner>(m, "Aligner")
      .def(py::init<const TrackingOptions&>(), py::arg("options"))
      .def_property_readonly("options",
                             [](const SharedAligner& self) { return self.aligner.options(); })
      .def("align", &align, py::arg("keyframe"), py::arg("target"), py::kw_only(),
           py::arg("T_init"), py::arg("a"), py::arg("b"), py::arg("maps"));
}

}  // namespace raylign::python
