// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>
#include <pybind11/numpy.h>

#include <memory>
#include <optional>
#include <string>
#include <utility>

#include "bindings.h"
#include "options_binder.h"
#include "raylign/io/bal.h"
#include "raylign/synthetic/bal.h"
#include "raylign/synthetic/write_bal.h"

namespace raylign::python {
namespace {

namespace py = pybind11;
using O = SyntheticBalOptions;

void bind_options(py::module_& m) {
  py::native_enum<SyntheticBalKind>(m, "BalKind", "enum.Enum",
                                    "What a synthetic BAL problem photographs, and how.")
      .value("STREET", SyntheticBalKind::STREET,
             "A car with a camera rig drives laps through a city: facades, trees, loop closures.")
      .value("ORBIT", SyntheticBalKind::ORBIT,
             "A photo collection: rings of cameras around a domed rotunda on a plaza.")
      .finalize();
  OptionsBinder<O>(
      m, "BalOptions",
      "Options of `raylign.synthetic.bal`. Scene units are metres; all follows from `seed`.",
      [](const O& options) { options.validate(); })
      .field("kind", &O::kind, "BalKind: STREET or ORBIT.")
      .field("num_cameras", &O::num_cameras, "Cameras, >= 2.")
      .field("num_points", &O::num_points, "Points, >= 4 * num_cameras.")
      .field("num_observations", &O::num_observations,
             "Exact total, >= 2 * num_points; 0: by mean_track_length.")
      .field("mean_track_length", &O::mean_track_length,
             "Observations per point, >= 2, with a heavy (Lomax) tail; less if too few cameras see "
             "it.")
      .field("seed", &O::seed,
             "Unsigned 64-bit; the same seed gives the same bits on every machine.")
      .field("num_laps", &O::num_laps, "STREET: times the loop is driven, >= 1.")
      .field("views_per_stop", &O::views_per_stop,
             "STREET: cameras of the rig, 45 deg apart (360 deg / n above 8), >= 1.")
      .field("stop_spacing", &O::stop_spacing,
             "STREET: metres between stops, > 0; more when the loop is short.")
      .field("loop_closure_fraction", &O::loop_closure_fraction,
             "STREET: fraction of points that are matched across laps, in [0, 1].")
      .field("max_distance", &O::max_distance, "Farthest matched facade, tree or ground in m, > 0.")
      .field("image_width", &O::image_width, "Pixels, >= 16; observations have |u| <= width / 2.")
      .field("image_height", &O::image_height,
             "Pixels, >= 16; observations have |v| <= height / 2.")
      .field("focal", &O::focal, "Mean focal length in px, > 0.")
      .field("focal_sigma", &O::focal_sigma, "Its relative spread over the cameras, in [0, 0.3].")
      .field("k1", &O::k1, "Mean radial distortion, r^2 term; must stay invertible in the image.")
      .field("k1_sigma", &O::k1_sigma, "Its spread over the cameras, >= 0.")
      .field("k2", &O::k2, "Mean radial distortion, r^4 term.")
      .field("k2_sigma", &O::k2_sigma, "Its spread over the cameras, >= 0.")
      .field("far_fraction", &O::far_fraction,
             "Fraction of points near infinity, in [0, 1]: depth log-uniform up to far_factor.")
      .field("far_factor", &O::far_factor,
             "Largest depth in baselines (distance of neighbouring cameras), in [100, 1e9].")
      .field("pixel_noise", &O::pixel_noise, "Sigma of each image coordinate in px, >= 0.")
      .field("outlier_fraction", &O::outlier_fraction,
             "Fraction of observations replaced by a uniform pixel, in [0, 0.999].")
      .field("rotation_noise_deg", &O::rotation_noise_deg,
             "Start: sigma of each rotation-vector component in degrees, in [0, 90].")
      .field("translation_noise", &O::translation_noise,
             "Start: sigma of each centre coordinate over the typical viewing distance, >= 0.")
      .field("point_noise", &O::point_noise,
             "Start: sigma of each point coordinate over the distance of its camera, >= 0.")
      .field("focal_noise", &O::focal_noise,
             "Start: relative sigma of the focal lengths, in [0, 0.3].")
      .field("distortion_noise", &O::distortion_noise, "Start: relative sigma of k1 and k2, >= 0.")
      .finish();
}

// A callback that returns None goes on; only False stops.
ProgressCallback make_progress(const py::object& progress) {
  if (progress.is_none()) return nullptr;
  return [&progress](std::int64_t done, std::int64_t total) {
    const py::gil_scoped_acquire gil;
    return !progress(done, total).is(py::bool_(false));
  };
}

py::array_t<bool> to_mask(const Rows<std::uint8_t, 1>& rows) {
  py::array_t<bool> mask(rows.size());
  for (Eigen::Index i = 0; i < rows.size(); ++i) mask.mutable_data()[i] = rows[i] != 0;
  return mask;
}

std::unique_ptr<BalWriter> open_writer(const SyntheticBalStream& stream, const std::string& path) {
  return std::make_unique<BalWriter>(open_byte_sink(path), stream.options().num_cameras,
                                     stream.options().num_points, stream.num_observations());
}

py::tuple write_to_path(const O& options,
                        const std::string& path,
                        const std::optional<std::string>& truth_path,
                        const py::object& progress) {
  const ProgressCallback report = make_progress(progress);
  py::gil_scoped_release release;
  SyntheticBalStream stream(options);
  const auto problem = open_writer(stream, path);
  const auto truth = truth_path ? open_writer(stream, *truth_path) : nullptr;
  write_synthetic_bal(stream, *problem, truth.get(), report);
  problem->finish();
  if (truth) truth->finish();
  py::gil_scoped_acquire acquire;
  return py::make_tuple(options.num_cameras, options.num_points, stream.num_observations());
}

}  // namespace

void bind_synthetic(py::module_& m) {
  bind_options(m);
  m.def(
      "synthetic_bal",
      [](const O& options) {
        SyntheticBal bal;
        {
          const py::gil_scoped_release release;
          bal = synthetic_bal(options);
        }
        return py::make_tuple(std::move(bal.problem), std::move(bal.truth),
                              to_mask(bal.inlier_mask));
      },
      py::arg("options"), "(problem, truth, inlier_mask) of a synthetic BAL problem.");
  m.def(
      "write_synthetic_bal", &write_to_path, py::arg("options"), py::arg("path"), py::kw_only(),
      py::arg("truth_path"), py::arg("progress"),
      "Write a synthetic BAL file in bounded memory; (num_cameras, num_points, num_observations).");
}

}  // namespace raylign::python
