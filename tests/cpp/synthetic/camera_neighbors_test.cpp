// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/synthetic/camera_neighbors.h"

#include <gtest/gtest.h>

#include <set>

namespace raylign {
namespace {

TEST(CameraNeighbors, FindsEveryCameraThatLooksTheSameWay) {
  for (const int num_cameras : {2, 3, 10, 150, 900}) {
    SyntheticBalOptions options;
    options.kind = SyntheticBalKind::ORBIT;
    options.num_cameras = num_cameras;
    options.num_points = 4 * num_cameras;
    const auto scene = make_bal_scene(options);
    const CameraNeighbors neighbors(*scene, options.max_distance);
    NeighborList list;
    neighbors.query(1, list);
    std::set<int> found;
    for (std::size_t i = 0; i < list.size(); ++i) found.insert(list[i]);
    EXPECT_EQ(found.size(), list.size());
    for (int i = 0; i < num_cameras; ++i) {
      const double cosine = scene->cameras()[i].R_cw.row(2).dot(scene->cameras()[1].R_cw.row(2));
      if (std::abs(cosine + 0.1) < 1e-3) continue;
      EXPECT_EQ(found.count(i) == 1, i != 1 && cosine > -0.1) << i << " of " << num_cameras;
    }
  }
}

TEST(CameraNeighbors, ReadingFurtherDoesNotChangeTheOrder) {
  SyntheticBalOptions options;
  options.num_cameras = 700;
  const auto scene = make_bal_scene(options);
  const CameraNeighbors neighbors(*scene, options.max_distance);
  NeighborList by_step;
  NeighborList at_once;
  neighbors.query(350, by_step);
  neighbors.query(350, at_once);
  ASSERT_GT(at_once.size(), 100u);
  at_once[at_once.size() - 1];
  for (std::size_t i = 0; i < at_once.size(); ++i) ASSERT_EQ(by_step[i], at_once[i]) << i;
}

}  // namespace
}  // namespace raylign
