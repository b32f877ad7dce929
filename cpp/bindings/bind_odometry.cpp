// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include <pybind11/native_enum.h>

#include "batch.h"
#include "bindings.h"
#include "image.h"
#include "options_binder.h"
#include "raylign/odometry/rgbd_odometry.h"

namespace raylign::python {
namespace {

void bind_options(py::module_& m) {
  OptionsBinder<KeyframeRule> rule(m, "KeyframeRule", "When a tracked frame becomes a keyframe.",
                                   [](const KeyframeRule& value) { value.validate(); });
  rule.field("distance_weight", &KeyframeRule::distance_weight,
             "Of the translation from the keyframe times its mean inverse depth, >= 0.")
      .field("usage_weight", &KeyframeRule::usage_weight,
             "Of the share of the keyframe's points not in view, >= 0.")
      .field("min_good_ratio", &KeyframeRule::min_good_ratio,
             "Below this share of agreeing points a new keyframe is taken, in [0, 1].")
      .field("min_agreement", &KeyframeRule::min_agreement,
             "Below this AlignmentResult.agreement a new keyframe is taken, in [0, 1].");
  rule.finish();

  OptionsBinder<MotionModelOptions> motion(
      m, "MotionModelOptions", "Where the search for a pose begins, and which are not believed.",
      [](const MotionModelOptions& value) { value.validate(); });
  motion
      .field("constant_velocity", &MotionModelOptions::constant_velocity,
             "Begin at the continued motion; False: at the last pose.")
      .field("search_rotation", &MotionModelOptions::search_rotation,
             "Rotations (rad) tried about each axis when the first start fails; 0: none.")
      .field("max_frame_translation", &MotionModelOptions::max_frame_translation,
             "Largest believed step between frames, share of the mean depth, > 0.")
      .field("max_frame_rotation", &MotionModelOptions::max_frame_rotation,
             "Largest believed turn between frames, rad, > 0.");
  motion.finish();

  OptionsBinder<ShutterOptions> shutter(m, "ShutterOptions", "Rolling shutter.",
                                        [](const ShutterOptions& value) { value.validate(); });
  shutter
      .field("estimate_readout", &ShutterOptions::estimate_readout,
             "Whether readout_s is found from the sequence itself.")
      .field("readout_s", &ShutterOptions::readout_s,
             "From the first row to the last, s, or where the estimate begins; 0: global, < 0: "
             "from below.");
  shutter.finish();

  OptionsBinder<OdometryOptions> options(m, "OdometryOptions", "Options of RgbdOdometry.",
                                         [](const OdometryOptions& value) { value.validate(); });
  options.field("tracking", &OdometryOptions::tracking, "TrackingOptions, not SIM3.")
      .field("keyframe", &OdometryOptions::keyframe, "KeyframeOptions: the points.")
      .field("keyframe_rule", &OdometryOptions::keyframe_rule, "KeyframeRule.")
      .field("motion", &OdometryOptions::motion, "MotionModelOptions.")
      .field("shutter", &OdometryOptions::shutter, "ShutterOptions.")
      .field("depth_model", &OdometryOptions::depth_model, "DepthModel of the sensor.")
      .field("depth_scale", &OdometryOptions::depth_scale,
             "Units per m of uint16 depth images, > 0.")
      .field("num_recovery_keyframes", &OdometryOptions::num_recovery_keyframes,
             "Recent keyframes that a lost frame is compared with, >= 1.")
      .field("min_depth_agreement", &OdometryOptions::min_depth_agreement,
             "Share of the points that must land on the frame's own depth where the images leave "
             "doubt, in [0, 1].")
      .field("max_depth_step", &OdometryOptions::max_depth_step,
             "Without the depth term: how far the frame's depth may have the camera elsewhere, "
             "share of the mean depth and rad, > 0.");
  options.finish();
}

void bind_result(py::module_& m) {
  py::native_enum<OdometryStatus>(m, "OdometryStatus", "enum.Enum",
                                  "What is known of a frame's pose.")
      .value("OK", OdometryStatus::OK)
      .value("RECOVERED", OdometryStatus::RECOVERED)
      .value("LOST", OdometryStatus::LOST)
      .value("NO_DEPTH", OdometryStatus::NO_DEPTH)
      .finalize();
  py::class_<OdometryResult>(m, "OdometryResult", "What RgbdOdometry.track says about a frame.")
      .def_readonly("frame", &OdometryResult::frame, "Number of the frame, from 0.")
      .def_readonly("timestamp", &OdometryResult::timestamp, "s, as given.")
      .def_readonly("status", &OdometryResult::status, "OdometryStatus.")
      .def_readonly("reason", &OdometryResult::reason, "Why there is no pose; empty else.")
      .def_property_readonly(
          "T_wc",
          [](const OdometryResult& r) {
            F64Array out(Item<Matrix4>::shape());
            Item<Matrix4>::store(r.T_wc, out.mutable_data());
            return out;
          },
          "Camera to world, (4, 4) float64; NaN when there is no pose.")
      .def_readonly("keyframe", &OdometryResult::keyframe,
                    "Frame number of the keyframe it was aligned with, -1: none.")
      .def_readonly("is_keyframe", &OdometryResult::is_keyframe,
                    "Whether the frames that follow are aligned with this one.")
      .def_readonly("num_alignments", &OdometryResult::num_alignments, "Alignments tried.")
      .def_readonly("readout_s", &OdometryResult::readout_s,
                    "Readout time of the rows (ShutterOptions) as known with this frame, s.")
      .def_readonly("alignment", &OdometryResult::alignment,
                    "AlignmentResult with that keyframe; of the last try when LOST.");
}

OdometryResult track(RgbdOdometry& odometry,
                     const py::object& image,
                     const py::object& depth,
                     double timestamp) {
  const ImageView image_view = view_of_image(image, "image");
  const ImageView depth_view = view_of_image(depth, "depth");
  const py::gil_scoped_release release;
  return odometry.track(image_view, depth_view, timestamp);
}

}  // namespace

void bind_odometry(py::module_& m) {
  bind_options(m);
  bind_result(m);
  py::class_<RgbdOdometry>(m, "RgbdOdometry", "Frame by frame; raylign.odometry documents it.")
      .def(py::init([](const PinholeCamera& camera, const OdometryOptions& options,
                       const py::object& T_wc) {
             const F64Array T = batch_from_numpy(T_wc, Item<Matrix4>::shape(), "T_wc");
             if (T.ndim() != 2) throw ShapeError("T_wc must be (4, 4), got " + describe_array(T));
             return std::make_unique<RgbdOdometry>(camera, options, Item<Matrix4>::load(T.data()));
           }),
           py::arg("camera"), py::kw_only(), py::arg("options"), py::arg("T_wc"))
      .def("track", &track, py::arg("image"), py::arg("depth"), py::kw_only(), py::arg("timestamp"),
           "OdometryResult of the next frame.")
      .def_property_readonly(
          "options", [](const RgbdOdometry& o) { return o.options(); },
          "A copy of the OdometryOptions.");
}

}  // namespace raylign::python
