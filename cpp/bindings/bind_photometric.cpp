// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/eigen.h>
#include <pybind11/native_enum.h>
#include <pybind11/stl.h>

#include <memory>
#include <utility>

#include "bindings.h"
#include "callbacks.h"
#include "image.h"
#include "numpy.h"
#include "raylign/photometric/adjuster.h"
#include "raylign/photometric/cramer_rao.h"
#include "raylign/photometric/frozen.h"

namespace raylign::python {
namespace {

using Problem = PhotometricProblem;
using Result = PhotometricResult;

void bind_status(py::module_& m) {
  py::native_enum<PointStatus>(m, "PointStatus", "enum.Enum", "Why a point is used, or not.")
      .value("OK", PointStatus::OK)
      .value("FEW_VIEWS", PointStatus::FEW_VIEWS)
      .value("OUT_OF_VIEW", PointStatus::OUT_OF_VIEW)
      .value("OCCLUDED", PointStatus::OCCLUDED)
      .value("LOW_TEXTURE", PointStatus::LOW_TEXTURE)
      .value("SATURATED", PointStatus::SATURATED)
      .value("DIVERGED", PointStatus::DIVERGED)
      .value("FIXED", PointStatus::FIXED)
      .finalize();
  py::native_enum<EdgeStatus>(m, "EdgeStatus", "enum.Enum",
                              "Why an image is used for a point, or not.")
      .value("OK", EdgeStatus::OK)
      .value("BEHIND", EdgeStatus::BEHIND)
      .value("OUT_OF_VIEW", EdgeStatus::OUT_OF_VIEW)
      .value("OBLIQUE", EdgeStatus::OBLIQUE)
      .value("SCALE_CHANGE", EdgeStatus::SCALE_CHANGE)
      .value("OCCLUDED", EdgeStatus::OCCLUDED)
      .value("SATURATED", EdgeStatus::SATURATED)
      .value("MISMATCH", EdgeStatus::MISMATCH)
      .value("NOT_USED", EdgeStatus::NOT_USED)
      .finalize();
}

std::vector<std::shared_ptr<const ImagePyramid>> make_pyramids(const py::list& images,
                                                               int max_levels) {
  std::vector<ImageView> views;
  for (std::size_t i = 0; i < images.size(); ++i) {
    views.push_back(view_of_image(images[i], "images[" + std::to_string(i) + "]"));
  }
  const py::gil_scoped_release release;
  std::vector<std::shared_ptr<const ImagePyramid>> pyramids;
  for (const ImageView& view : views) {
    pyramids.push_back(std::make_shared<ImagePyramid>(view, PyramidOptions{max_levels, 16}));
  }
  return pyramids;
}

std::vector<std::shared_ptr<const Plane<std::uint8_t>>> make_masks(const py::list& masks) {
  std::vector<std::shared_ptr<const Plane<std::uint8_t>>> planes;
  for (const auto& item : masks) {
    if (item.is_none()) {
      planes.push_back(nullptr);
      continue;
    }
    const ImageView view = view_of_image(py::reinterpret_borrow<py::object>(item), "mask");
    if (view.type != PixelType::UINT8 || view.channels != 1) {
      throw ShapeError("a mask must be uint8 of shape (H, W), got " + describe_array(item));
    }
    auto plane = std::make_shared<Plane<std::uint8_t>>(view.width, view.height);
    for (int v = 0; v < view.height; ++v) {
      const auto* row = static_cast<const std::uint8_t*>(view.data) + v * view.row_stride;
      std::copy(row, row + view.width, plane->row(v));
    }
    planes.push_back(std::move(plane));
  }
  return planes;
}

// Copies an (N, n) array of exactly dtype T and any n; None: no rows.
template <typename T>
Rows<T, Eigen::Dynamic> wide_rows(const py::object& object, const std::string& name) {
  if (object.is_none()) return {};
  const auto columns =
      py::isinstance<py::array>(object) && py::reinterpret_borrow<py::array>(object).ndim() == 2
          ? py::reinterpret_borrow<py::array>(object).shape(1)
          : py::ssize_t{1};
  return table_from_numpy<Rows<T, Eigen::Dynamic>>(object, name, {columns});
}

template <typename T, int Cols>
void set_rows(Rows<T, Cols>& rows,
              const py::dict& arrays,
              const char* name,
              const std::vector<py::ssize_t>& record) {
  if (arrays.contains(name) && !arrays[name].is_none()) {
    rows = table_from_numpy<Rows<T, Cols>>(py::object(arrays[name]), name, record);
  }
}

// `arrays`: what the façade has checked and converted, by the names of the members.
std::shared_ptr<Problem> make_problem(const py::list& images,
                                      const py::list& masks,
                                      int max_levels,
                                      const py::dict& arrays) {
  auto problem = std::make_shared<Problem>();
  problem->images = make_pyramids(images, max_levels);
  problem->masks = make_masks(masks);
  set_rows(problem->intrinsics, arrays, "intrinsics", {4});
  set_rows(problem->T_cw, arrays, "T_cw", {4, 4});
  set_rows(problem->points, arrays, "points", {3});
  if (arrays.contains("patches")) problem->patches = wide_rows<float>(arrays["patches"], "patches");
  set_rows(problem->hosts, arrays, "hosts", {});
  set_rows(problem->host_uv, arrays, "host_uv", {2});
  set_rows(problem->normals, arrays, "normals", {3});
  set_rows(problem->track_image, arrays, "track_image", {});
  set_rows(problem->track_point, arrays, "track_point", {});
  set_rows(problem->brightness, arrays, "brightness", {2});
  set_rows(problem->pose_covariances, arrays, "pose_covariances", {6, 6});
  set_rows(problem->point_covariances, arrays, "point_covariances", {3, 3});
  set_rows(problem->depth_sigmas, arrays, "depth_sigmas", {});
  return problem;
}

template <typename Scalar, int Cols>
py::array_t<Scalar> matrices(const Rows<Scalar, Cols>& rows, py::ssize_t height) {
  const py::ssize_t width = height == 0 ? 0 : Cols / height;
  return py::array_t<Scalar>({static_cast<py::ssize_t>(rows.rows()), height, width}, rows.data());
}

void bind_problem(py::module_& m) {
  py::class_<Problem, std::shared_ptr<Problem>>(m, "PhotometricProblem")
      .def(py::init(&make_problem), py::kw_only(), py::arg("images"), py::arg("masks"),
           py::arg("max_levels"), py::arg("arrays"))
      .def(
          "validate", [](const Problem& p, int pattern_size) { p.validate(pattern_size); },
          py::kw_only(), py::arg("pattern_size"))
      .def("default_gauge", &default_gauge)
      .def(
          "image",
          [](const py::object& self, std::size_t index) {
            const auto& images = self.cast<const Problem&>().images;
            require_option(index < images.size(), "index", "an image of the problem",
                           static_cast<double>(index));
            return view_of(images[index]->level(0).view(), self);
          },
          py::arg("index"));
}

// The table a member of the result as a copy of shape (rows, Cols), or (rows,).
template <typename T, int Cols>
void def_rows(py::class_<Result>& cls,
              const char* name,
              Rows<T, Cols> Result::* member,
              const char* doc) {
  cls.def_property_readonly(
      name,
      [member](const Result& result) {
        const Rows<T, Cols>& rows = result.*member;
        if constexpr (Cols == 1) return py::array_t<T>(rows.rows(), rows.data());
        return py::array_t<T>({rows.rows(), rows.cols()}, rows.data());
      },
      doc);
}

template <typename Status>
py::array_t<std::uint8_t> statuses(const std::vector<Status>& values) {
  static_assert(sizeof(Status) == 1);
  return py::array_t<std::uint8_t>(static_cast<py::ssize_t>(values.size()),
                                   reinterpret_cast<const std::uint8_t*>(values.data()));
}

void bind_state(py::class_<Result>& cls) {
  cls.def_property_readonly(
      "T_cw", [](const Result& r) { return matrices(r.T_cw, 4); }, "(M, 4, 4) world to camera.");
  def_rows(cls, "points", &Result::points, "(N, 3) world frame.");
  def_rows(cls, "brightness", &Result::brightness, "(M, 2) a, b: e^a I + b matches the patches.");
  def_rows(cls, "intrinsics", &Result::intrinsics, "(1, 4) of all images or (M, 4): fx fy cx cy.");
  cls.def_readonly("accepted", &Result::accepted, "Points held out of the solve became better.");
  cls.def_readonly("reason", &Result::reason, "Why it was accepted or not, with the numbers.");
  cls.def_readonly("num_hold_out", &Result::num_hold_out, "Points of the acceptance test.");
  cls.def_readonly("hold_out_cost_before", &Result::hold_out_cost_before,
                   "Mean robust cost of a held-out point's view, grey².");
  cls.def_readonly("hold_out_cost_after", &Result::hold_out_cost_after, "The same after.");
  cls.def_readonly("messages", &Result::messages, "What the user should know.");
}

void bind_statistics(py::class_<Result>& cls) {
  cls.def_property_readonly(
      "point_status", [](const Result& r) { return statuses(r.point_status); },
      "(N,) uint8, PointStatus.");
  cls.def_property_readonly(
      "edge_status", [](const Result& r) { return statuses(r.edge_status); },
      "(E,) uint8, EdgeStatus, of the last round.");
  def_rows(cls, "edge_image", &Result::edge_image, "(E,) image of each candidate view.");
  def_rows(cls, "edge_point", &Result::edge_point, "(E,) its point.");
  def_rows(cls, "edge_rms_before", &Result::edge_rms_before, "(E,) RMS residual, grey levels.");
  def_rows(cls, "edge_rms_after", &Result::edge_rms_after, "(E,) the same after; NaN: not OK.");
  def_rows(cls, "point_rms_before", &Result::point_rms_before, "(N,) over the point's views.");
  def_rows(cls, "point_rms_after", &Result::point_rms_after, "(N,) the same after.");
  def_rows(cls, "image_rms_before", &Result::image_rms_before, "(M,) over the image's points.");
  def_rows(cls, "image_rms_after", &Result::image_rms_after, "(M,) the same after.");
  def_rows(cls, "shift_px", &Result::shift_px, "(M,) median motion of the projections, px.");
  def_rows(cls, "hosts", &Result::hosts, "(N,) image the patch was read from, −1: stored.");
  def_rows(cls, "host_uv", &Result::host_uv, "(N, 2) px.");
  def_rows(cls, "patches", &Result::patches, "(N, n) grey levels, of level 0.");
  def_rows(cls, "normals", &Result::normals, "(N, 3) as used, host frame; NaN: none.");
  cls.def_readonly("sigma", &Result::sigma, "Of the law of one pixel's residual, grey levels.");
  cls.def_readonly("nu", &Result::nu, "Degrees of freedom of Student's t; −1: another law.");
  cls.def_readonly("threshold", &Result::threshold, "Scale of the loss, grey levels.");
  cls.def_readonly("noise_ratio", &Result::noise_ratio,
                   "Noise of an image's value over that of a patch's; 0: not balanced.");
  cls.def_readonly("presmooth", &Result::presmooth,
                   "σ of the Gaussian that the images were smoothed with, px.");
  cls.def_readonly("gauge", &Result::gauge, "What anchors the result, in words.");
  cls.def_readonly("summary", &Result::summary, "Summary: iterations of all rounds in a row.");
}

void bind_covariances(py::class_<Result>& cls) {
  cls.def_property_readonly(
      "rounds",
      [](const Result& r) {
        return py::array_t<PhotometricRound>(static_cast<py::ssize_t>(r.rounds.size()),
                                             r.rounds.data());
      },
      "Structured array: level, round, num_points, num_edges, sigma, nu, costs, motion in px.");
  cls.def_property_readonly(
      "pose_covariance",
      [](const Result& r) {
        return py::array_t<double, py::array::c_style | py::array::forcecast>(
            py::cast(r.pose_covariance));
      },
      "(6M, 6M) of ξ = [υ; ω] per image, T_cw = exp(ξ) T_estimate; zero where held; (0, 0): none.");
  cls.def_property_readonly(
      "point_covariances", [](const Result& r) { return matrices(r.point_covariances, 3); },
      "(N, 3, 3) world frame, NaN where there is none; (0, 3, 3): not asked for.");
  cls.def_readonly("shared_noise", &Result::shared_noise,
                   "Share of a residual's variance that is the patch's own noise; −1: unknown.");
  cls.def_readonly("covariance_overlap", &Result::covariance_overlap,
                   "Patches that a pixel belongs to on average: above 1, residuals repeat each "
                   "other and covariances are too small by up to this factor.");
  cls.def_readonly("free_directions", &Result::free_directions,
                   "Directions that nothing determines; −1: covariances were not asked for.");
}

void bind_result(py::module_& m) {
  using R = PhotometricRound;
  PYBIND11_NUMPY_DTYPE(R, level, round, num_points, num_edges, sigma, nu, initial_cost, final_cost,
                       num_iterations, max_motion_px);
  py::class_<Result> cls(m, "PhotometricResult", "What `adjust` found, as arrays.");
  bind_state(cls);
  bind_statistics(cls);
  bind_covariances(cls);
}

// Options by value: other Python threads may change theirs while the GIL is released.
Result adjust_problem(const std::shared_ptr<const Problem>& problem,
                      BundleConfig config,
                      PhotometricOptions options,
                      const py::object& callback) {
  const py::gil_scoped_release release;
  const auto ask = [&callback](const IterationSummary& row) { return ask_python(callback, row); };
  return adjust(*problem, config, options, ask, SignalCheck());
}

CramerRaoBound bound_of(const Problem& problem,
                        const BundleConfig& config,
                        const PhotometricOptions& options,
                        const CramerRaoOptions& noise) {
  PhotometricOptions sharp = options;
  sharp.presmooth =
      0.0;  // smoothed pixels have no noise of their own, which the bound takes for granted
  const FrozenProblem frozen = freeze(problem, config, sharp);
  return cramer_rao(frozen.scene, frozen.constraints, noise);
}

void bind_cramer_rao(py::module_& m) {
  using B = CramerRaoBound;
  py::class_<B>(m, "CramerRaoBound", "Smallest covariance that an unbiased estimate can have.")
      .def_property_readonly(
          "pose_covariance",
          [](const B& b) {
            return py::array_t<double, py::array::c_style | py::array::forcecast>(
                py::cast(b.poses));
          },
          "(6M, 6M) of ξ = [υ; ω] per image, T_cw = exp(ξ) T_true; zero where held.")
      .def_property_readonly(
          "center_covariances", [](const B& b) { return matrices(b.centers, 3); },
          "(M, 3, 3) of the cameras' centres, world frame.")
      .def_property_readonly(
          "point_covariances", [](const B& b) { return matrices(b.points, 3); },
          "(N, 3, 3) world frame; NaN where nothing determines a point.")
      .def_readonly("free_directions", &B::free_directions,
                    "Directions that the images leave free; bounds are of the rest.");
  m.def(
      "photometric_cramer_rao",
      [](const std::shared_ptr<const Problem>& problem, BundleConfig config,
         PhotometricOptions options, double sigma, bool is_rounded, bool has_noisy_patches) {
        const py::gil_scoped_release release;
        return bound_of(*problem, config, options, {sigma, is_rounded, has_noisy_patches});
      },
      py::arg("problem"), py::kw_only(), py::arg("config"), py::arg("options"), py::arg("sigma"),
      py::arg("is_rounded"), py::arg("has_noisy_patches"));
}

}  // namespace

void bind_photometric(py::module_& m) {
  bind_status(m);
  bind_problem(m);
  bind_result(m);
  bind_cramer_rao(m);
  m.def("adjust_photometric", &adjust_problem, py::arg("problem"), py::kw_only(), py::arg("config"),
        py::arg("options"), py::arg("callback").none(true));
}

}  // namespace raylign::python
