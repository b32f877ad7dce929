// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/levels.h"

#include <algorithm>
#include <cmath>

namespace raylign::photometric {
namespace {

constexpr double kShiftPerLevel = 1.5;  // px
constexpr int kUnknownShiftLevels = 4;

// Standard deviation of a projection by the priors of its pose and point, px; −1 without any.
double expected_shift(const Setting& setting,
                      const PatchScene& scene,
                      std::int64_t p,
                      const PatchEdge& edge,
                      const EdgeSample& sample) {
  const PhotometricProblem& problem = setting.problem;
  const EdgeMotion motion = edge_motion(scene, p, edge, sample);
  double variance = -1.0;
  const auto add = [&](double trace) { variance = std::max(variance, 0.0) + trace; };
  if (problem.pose_covariances.rows() > 0 && !std::isnan(problem.pose_covariances(edge.image, 0))) {
    const RowMajor<6, 6> C =
        Eigen::Map<const RowMajor<6, 6>>(problem.pose_covariances.row(edge.image).data());
    add((motion.pose * C * motion.pose.transpose()).trace());
  }
  if (scene.inverse_depth) return variance < 0.0 ? -1.0 : std::sqrt(variance);
  if (problem.point_covariances.rows() > 0 && !std::isnan(problem.point_covariances(p, 0))) {
    const RowMajor<3, 3> C =
        Eigen::Map<const RowMajor<3, 3>>(problem.point_covariances.row(p).data());
    add((motion.point * C * motion.point.transpose()).trace());
  }
  return variance < 0.0 ? -1.0 : std::sqrt(variance);
}

double median_expected_shift(const Setting& setting, const PhotometricState& start) {
  if (setting.problem.pose_covariances.rows() == 0 &&
      setting.problem.point_covariances.rows() == 0) {
    return -1.0;
  }
  const Views views = find_views(setting, start, 0);
  std::vector<double> shifts;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    for (std::int64_t e = views.scene.starts[p]; e < views.scene.starts[p + 1]; ++e) {
      const EdgeSample sample = evaluate_edge(views.scene, p, views.scene.edges[e]);
      if (!sample.is_seen) continue;
      const double shift = expected_shift(setting, views.scene, p, views.scene.edges[e], sample);
      if (shift >= 0.0) shifts.push_back(shift);
    }
  }
  if (shifts.empty()) return -1.0;
  const auto middle = shifts.begin() + static_cast<std::ptrdiff_t>(shifts.size() / 2);
  std::nth_element(shifts.begin(), middle, shifts.end());
  return *middle;
}

int wanted_levels(const Setting& setting, double shift) {
  if (setting.options.num_levels > 0) return setting.options.num_levels;
  if (shift < 0.0) return kUnknownShiftLevels;
  int level = 0;
  while (level < 30 && shift / std::ldexp(1.0, level) >= kShiftPerLevel) ++level;
  return level + 1;
}

}  // namespace

LevelPlan plan_levels(const Setting& setting, const PhotometricState& start) {
  LevelPlan plan;
  const auto& hosts = setting.hosts.image;
  const bool stored =
      setting.problem.has_patches() && std::find(hosts.begin(), hosts.end(), -1) != hosts.end();
  const bool asks_for_more = setting.options.num_levels > 1;
  if (stored) {
    if (asks_for_more) {
      plan.messages.push_back(
          "stored patches have no coarser levels: solved on level 0 only, which recovers from "
          "shifts of about 1.5 px");
    }
    return plan;
  }
  if (setting.options.num_levels != 1)
    plan.expected_shift_px = median_expected_shift(setting, start);
  const int wanted = wanted_levels(setting, plan.expected_shift_px);
  plan.num_levels = std::min(wanted, setting.prepared.num_levels);
  if (plan.num_levels < wanted && (asks_for_more || plan.expected_shift_px >= 0.0)) {
    plan.messages.push_back(std::to_string(wanted) +
                            " pyramid levels are wanted, the images have " +
                            std::to_string(plan.num_levels));
  }
  return plan;
}

}  // namespace raylign::photometric
