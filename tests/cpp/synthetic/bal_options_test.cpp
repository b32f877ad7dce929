// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/bal_options.h"

#include <gtest/gtest.h>

#include <functional>
#include <limits>
#include <string>

#include "raylign/base/error.h"
#include "raylign/synthetic/bal.h"

namespace raylign {
namespace {

struct BadOption {
  std::string field;
  std::function<void(SyntheticBalOptions&)> set;
};

class BadOptions : public testing::TestWithParam<BadOption> {};

TEST_P(BadOptions, AreRefusedByName) {
  SyntheticBalOptions options;
  EXPECT_NO_THROW(options.validate());
  GetParam().set(options);
  try {
    options.validate();
    FAIL() << "accepted";
  } catch (const OptionsError& error) {
    EXPECT_NE(std::string(error.what()).find("BalOptions." + GetParam().field), std::string::npos)
        << error.what();
  }
  EXPECT_THROW(synthetic_bal(options), OptionsError);
}

using O = SyntheticBalOptions;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

INSTANTIATE_TEST_SUITE_P(
    EachField,
    BadOptions,
    testing::Values(BadOption{"num_cameras", [](O& o) { o.num_cameras = 1; }},
                    BadOption{"num_points", [](O& o) { o.num_points = 399; }},
                    BadOption{"num_points", [](O& o) { o.num_points = 1LL << 31; }},
                    BadOption{"num_observations", [](O& o) { o.num_observations = 19999; }},
                    BadOption{"num_observations", [](O& o) { o.num_observations = 1LL << 40; }},
                    BadOption{"mean_track_length", [](O& o) { o.mean_track_length = 1.9; }},
                    BadOption{"mean_track_length", [](O& o) { o.mean_track_length = kNan; }},
                    BadOption{"num_laps", [](O& o) { o.num_laps = 0; }},
                    BadOption{"views_per_stop", [](O& o) { o.views_per_stop = 0; }},
                    BadOption{"stop_spacing", [](O& o) { o.stop_spacing = 0.0; }},
                    BadOption{"loop_closure_fraction", [](O& o) { o.loop_closure_fraction = 1.1; }},
                    BadOption{"max_distance", [](O& o) { o.max_distance = kNan; }},
                    BadOption{"image_width", [](O& o) { o.image_width = 0; }},
                    BadOption{"image_height", [](O& o) { o.image_height = -480; }},
                    BadOption{"focal", [](O& o) { o.focal = -1.0; }},
                    BadOption{"focal_sigma", [](O& o) { o.focal_sigma = 0.5; }},
                    BadOption{"k1", [](O& o) { o.k1 = -0.6; }},  // folds the image
                    BadOption{"k1_sigma", [](O& o) { o.k1_sigma = -0.1; }},
                    BadOption{"k2_sigma", [](O& o) { o.k2_sigma = kNan; }},
                    BadOption{"far_fraction", [](O& o) { o.far_fraction = -0.1; }},
                    BadOption{"far_factor", [](O& o) { o.far_factor = 1.0; }},
                    BadOption{"pixel_noise", [](O& o) { o.pixel_noise = -0.5; }},
                    BadOption{"outlier_fraction", [](O& o) { o.outlier_fraction = 1.0; }},
                    BadOption{"rotation_noise_deg", [](O& o) { o.rotation_noise_deg = 91.0; }},
                    BadOption{"translation_noise", [](O& o) { o.translation_noise = -1.0; }},
                    BadOption{"point_noise", [](O& o) { o.point_noise = kNan; }},
                    BadOption{"focal_noise", [](O& o) { o.focal_noise = 0.4; }},
                    BadOption{"distortion_noise", [](O& o) { o.distortion_noise = -0.1; }}));

TEST(SyntheticBalOptions, MoreObservationsThanTheSceneShowsAreRefused) {
  SyntheticBalOptions options;
  options.num_cameras = 40;
  options.num_points = 400;
  options.num_observations = 16000;  // every point in every picture
  EXPECT_THROW(synthetic_bal(options), OptionsError);
}

}  // namespace
}  // namespace raylign
