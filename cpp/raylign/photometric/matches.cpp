// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/matches.h"

#include <cstdio>

#include "raylign/photometric/judge.h"

namespace raylign::photometric {
namespace {

// Calibrated on 300 results of rendered rooms (2 to 7 images, 120 to 760 points, four patterns,
// noise 2 to 16, starts 3 to 56 px off), the exercise and 7-Scenes with starts up to 150 px off:
// the worst image of a right result shows 0.56 to 1.0 of the confirmed points (0.50 at noise 16),
// of a wrong one 0 to 0.50. Of wrong images of two, a third of the edges are matched at most; of
// wrong images that matched 30 edges before, four fifths at most still do.
constexpr double kUnexplained = 0.35;
constexpr double kShown = 0.53;
constexpr double kHalf = 0.5;
constexpr double kConfirmed = 0.15;
constexpr double kKept = 0.85;
constexpr std::int64_t kEdgesThatTell = 8;
constexpr std::int64_t kEdgesToKeep = 30;

// What the non-host edges of one point show, in its order of edges.
struct PointMatch {
  std::vector<bool> comparable_before, comparable_after, matched_before, matched_after;
  int num_comparable = 0;  // after
  int num_matched = 0;
};

PointMatch match_point(const Setting& setting,
                       const Views& before,
                       const Views& after,
                       std::int64_t p) {
  PointMatch point;
  for (std::int64_t e = before.scene.starts[p]; e < before.scene.starts[p + 1]; ++e) {
    const bool counts = !setting.is_host(p, before.scene.edges[e].image);
    const bool was = counts && is_comparable(before, p, e);
    const bool is = counts && is_comparable(after, p, e);
    point.comparable_before.push_back(was);
    point.comparable_after.push_back(is);
    point.matched_before.push_back(was && is_matched(before, p, e));
    point.matched_after.push_back(is && is_matched(after, p, e));
    point.num_comparable += is ? 1 : 0;
    point.num_matched += point.matched_after.back() ? 1 : 0;
  }
  return point;
}

void add_edge(const PointMatch& point, std::size_t k, ImageMatch& match) {
  if (!point.comparable_before[k] && !point.comparable_after[k]) return;
  const bool after = point.matched_after[k];
  ++match.num_edges;
  match.num_before += point.matched_before[k] ? 1 : 0;
  match.num_after += after ? 1 : 0;
  match.num_kept += point.matched_before[k] && after ? 1 : 0;
  const int others = point.num_comparable - 1;
  if (!point.comparable_after[k] || others == 0) return;
  ++match.num_tellable;
  if (2 * (point.num_matched - (after ? 1 : 0)) <= others) return;
  ++match.num_confirmed;
  match.num_shown += after ? 1 : 0;
}

bool reaches(std::int64_t part, double share, std::int64_t whole) {
  return static_cast<double>(part) >= share * static_cast<double>(whole);
}

}  // namespace

bool is_comparable(const Views& views, std::int64_t p, std::int64_t e) {
  const PointStatus point = views.points[p];
  const EdgeStatus edge = views.edges[e];
  return point != PointStatus::OUT_OF_VIEW && point != PointStatus::LOW_TEXTURE &&
         (edge == EdgeStatus::OK || edge == EdgeStatus::MISMATCH || edge == EdgeStatus::NOT_USED);
}

bool is_matched(const Views& views, std::int64_t p, std::int64_t e) {
  return match_of(views.scene, p, views.scene.edges[e]).unexplained < kUnexplained;
}

bool ImageMatch::is_right() const {
  if (num_edges < kEdgesThatTell || reaches(num_after, kHalf, num_edges)) return true;
  if (num_before >= kEdgesToKeep && reaches(num_kept, kKept, num_before)) return true;
  return num_confirmed >= kEdgesThatTell && reaches(num_confirmed, kConfirmed, num_tellable) &&
         reaches(num_shown, kShown, num_confirmed);
}

std::string ImageMatch::text() const {
  char text[240];
  std::snprintf(text, sizeof(text),
                "shows %lld of the %lld patches that most other images show, and %lld of all %lld "
                "in its view (%lld before)",
                static_cast<long long>(num_shown), static_cast<long long>(num_confirmed),
                static_cast<long long>(num_after), static_cast<long long>(num_edges),
                static_cast<long long>(num_before));
  return text;
}

std::vector<ImageMatch> compare_matches(const Setting& setting,
                                        const Views& before,
                                        const Views& after,
                                        const std::vector<bool>& points) {
  std::vector<ImageMatch> matches(static_cast<std::size_t>(setting.problem.num_images()));
  for (std::int64_t p = 0; p < setting.num_points(); ++p) {
    if (!points[p]) continue;
    const PointMatch point = match_point(setting, before, after, p);
    for (std::size_t k = 0; k < point.matched_after.size(); ++k) {
      const std::int64_t e = before.scene.starts[p] + static_cast<std::int64_t>(k);
      add_edge(point, k, matches[before.scene.edges[e].image]);
    }
  }
  return matches;
}

}  // namespace raylign::photometric
