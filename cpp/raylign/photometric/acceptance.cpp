// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/acceptance.h"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <cstdio>

#include "raylign/geometry/se3.h"
#include "raylign/photometric/constraints.h"

namespace raylign::photometric {
namespace {

constexpr std::int64_t kMinHeldOut = 8;  // points that decide
constexpr int kHoldOutRounds = 2;
constexpr double kMaxPriorDistance = 40.0;  // χ² with 6 degrees of freedom: one in two million

// Mean of ½ρ(r²) over the pixels in `mask`; negative when the edge is not seen.
double edge_cost(
    const PatchScene& scene, std::int64_t p, std::int64_t e, std::uint32_t mask, const Loss& loss) {
  const EdgeSample sample = evaluate_edge(scene, p, scene.edges[e]);
  if (!sample.is_seen) return -1.0;
  double sum = 0.0;
  int count = 0;
  for (int n = 0; n < scene.pattern.size(); ++n) {
    if ((mask >> n & 1u) == 0u) continue;
    sum += 0.5 * loss.evaluate(sample.residual[n] * sample.residual[n]).rho;
    ++count;
  }
  return count > 0 ? sum / count : -1.0;
}

Views refined_alone(const Setting& setting,
                    const PatchConstraints& base,
                    const RoundLaw& law,
                    int num_levels,
                    const std::vector<bool>& held_out,
                    PhotometricState& state) {
  PatchConstraints points_only = base;
  for (std::size_t i = 0; i < points_only.poses.size(); ++i) hold_image(i, points_only);
  std::fill(points_only.intrinsics.begin(), points_only.intrinsics.end(),
            std::array<bool, 4>{true, true, true, true});
  const PhotometricState start = state;
  Refinement refinement(setting, points_only, start);
  Refinement::Plan plan;
  plan.num_levels = num_levels;
  plan.max_num_rounds = kHoldOutRounds;
  plan.law = &law;
  refinement.run(plan, held_out, nullptr, state);
  return find_views(setting, state, 0);
}

// Image whose pose is farther from its prior than the prior allows; −1: none.
std::int64_t image_beyond_prior(const Setting& setting,
                                const PhotometricState& start,
                                const PhotometricState& refined) {
  const auto& covariances = setting.problem.pose_covariances;
  for (Eigen::Index i = 0; i < covariances.rows(); ++i) {
    if (std::isnan(covariances(i, 0))) continue;
    const RowMajor<6, 6> C = Eigen::Map<const RowMajor<6, 6>>(covariances.row(i).data());
    const Vector6 xi = se3_log(refined.poses[i].matrix() * se3_inverse(start.poses[i].matrix()));
    if (!(xi.dot(C.inverse() * xi) <= kMaxPriorDistance)) return i;
  }
  return -1;
}

bool is_finite(const PhotometricState& state) {
  for (const PatchPose& pose : state.poses) {
    if (!pose.q.coeffs().allFinite() || !pose.t.allFinite()) return false;
  }
  return state.points.allFinite() && state.brightness.allFinite() && state.intrinsics.allFinite();
}

std::string text_of(const CostComparison& costs, const char* whose) {
  char text[200];
  std::snprintf(text, sizeof(text),
                "mean robust cost of %lld edges of %lld %s points: %.6g before, %.6g after",
                static_cast<long long>(costs.num_edges), static_cast<long long>(costs.num_points),
                whose, costs.before, costs.after);
  return text;
}

}  // namespace

CostComparison compare_costs(const Setting& setting,
                             const Views& before,
                             const Views& after,
                             const std::vector<bool>& points,
                             const Loss& loss) {
  CostComparison costs;
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    const std::int64_t edges_so_far = costs.num_edges;
    for (std::int64_t e = before.scene.starts[p]; points[p] && e < before.scene.starts[p + 1];
         ++e) {
      const PatchEdge& edge = before.scene.edges[e];
      if (setting.is_host(p, edge.image) || !is_comparable(before, p, e)) continue;
      const std::uint32_t mask = edge.mask & after.scene.edges[e].mask;
      const double cost_before = edge_cost(before.scene, p, e, mask, loss);
      if (cost_before < 0.0) continue;
      const double cost_after =
          is_comparable(after, p, e) ? edge_cost(after.scene, p, e, mask, loss) : -1.0;
      if (cost_after < 0.0) {
        ++costs.num_lost;
        continue;
      }
      costs.before += cost_before;
      costs.after += cost_after;
      ++costs.num_edges;
    }
    if (costs.num_edges > edges_so_far) ++costs.num_points;
  }
  const double n = static_cast<double>(std::max<std::int64_t>(costs.num_edges, 1));
  costs.before /= n;
  costs.after /= n;
  return costs;
}

std::vector<bool> lost_images(const std::vector<ImageMatch>& matches,
                              const PhotometricState& start,
                              const PhotometricState& refined) {
  std::vector<bool> lost;
  for (std::size_t i = 0; i < matches.size(); ++i) {
    lost.push_back(!same_pose(start.poses[i], refined.poses[i]) && !matches[i].is_right());
  }
  return lost;
}

Verdict judge_refinement(const Setting& setting,
                         const PatchConstraints& base,
                         const RoundLaw& law,
                         int num_levels,
                         const std::vector<bool>& held_out,
                         const std::vector<ImageMatch>& matches,
                         const PhotometricState& start,
                         PhotometricState& refined) {
  Verdict verdict;
  if (!is_finite(refined)) {
    verdict.reason = "the refined state is not finite";
    return verdict;
  }
  const std::int64_t far = image_beyond_prior(setting, start, refined);
  PhotometricState start_alone = start;
  const bool has_held_out = std::find(held_out.begin(), held_out.end(), true) != held_out.end();
  const char* whose = "held-out";
  if (has_held_out) {
    const Views at_start = refined_alone(setting, base, law, num_levels, held_out, start_alone);
    const Views at_end = refined_alone(setting, base, law, num_levels, held_out, refined);
    verdict.costs = compare_costs(setting, at_start, at_end, held_out, law.loss);
  }
  if (verdict.costs.num_points < kMinHeldOut) {
    whose = "solved";
    const std::vector<bool> all(setting.num_points(), true);
    verdict.costs = compare_costs(setting, find_views(setting, start, 0),
                                  find_views(setting, refined, 0), all, law.loss);
  }
  const std::vector<bool> is_lost = lost_images(matches, start, refined);
  const auto lost = std::find(is_lost.begin(), is_lost.end(), true) - is_lost.begin();
  verdict.reason = text_of(verdict.costs, whose);
  if (far >= 0) {
    verdict.reason = "image " + std::to_string(far) + " moved farther than its prior allows";
  } else if (lost < static_cast<std::ptrdiff_t>(is_lost.size())) {
    verdict.reason = "image " + std::to_string(lost) + " " + matches[lost].text();
  } else if (verdict.costs.num_lost > verdict.costs.num_edges) {
    verdict.reason = "most edges in view at the start are out of view after: " + verdict.reason;
  } else {
    verdict.accepted = verdict.costs.after < verdict.costs.before;
  }
  return verdict;
}

}  // namespace raylign::photometric
