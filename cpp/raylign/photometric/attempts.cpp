// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/attempts.h"

#include <algorithm>
#include <utility>

#include "raylign/photometric/acceptance.h"
#include "raylign/photometric/rescue.h"

namespace raylign::photometric {
namespace {

constexpr int kMaxPasses = 4;
constexpr double kWorthAnother = 0.05;   // of the edges, that a pass has put right
constexpr double kMostAreMatched = 0.9;  // the rest are points that nothing puts right

double share_of_matched(const Attempt& attempt) {
  std::int64_t edges = 1;
  std::int64_t matched = 0;
  for (const ImageMatch& match : attempt.matches) {
    edges += match.num_edges;
    matched += match.num_after;
  }
  return static_cast<double>(matched) / static_cast<double>(edges);
}

std::vector<bool> wrong_images(const Attempt& attempt) {
  std::vector<bool> wrong;
  for (const ImageMatch& match : attempt.matches) wrong.push_back(!match.is_right());
  return wrong;
}

std::string text_of(const std::vector<std::int32_t>& found) {
  std::string text;
  for (const std::int32_t i : found) text += (text.empty() ? "" : ", ") + std::to_string(i);
  return "lost images found by the points of the others: " + text;
}

}  // namespace

Attempts::Attempts(const Setting& setting,
                   const PatchConstraints& base,
                   const PhotometricState& start,
                   const std::vector<bool>& active,
                   Progress& progress,
                   Refinement& refinement)
    : setting_(setting),
      base_(base),
      start_(start),
      active_(active),
      progress_(progress),
      refinement_(refinement),
      before_(find_views(setting, start, 0)) {}

Attempt Attempts::run(int num_levels) {
  Attempt best = refine(start_, num_levels);
  const bool stored = setting_.problem.has_patches();
  if (setting_.options.num_levels > 0 || stored) return best;
  best = with_found_images(std::move(best));
  const int most = setting_.prepared.num_levels;
  if (num_lost(best) > 0 && most > num_levels && !progress_.is_over()) {
    messages_.push_back("solved again with " + std::to_string(most) + " levels");
    Attempt other = with_found_images(refine(start_, most));
    if (num_lost(other) < num_lost(best)) best = std::move(other);
  }
  refinement_.set_law(best.law);
  return best;
}

Attempt Attempts::refine(PhotometricState from, int num_levels) {
  Attempt attempt;
  attempt.state = std::move(from);
  attempt.num_levels = num_levels;
  Refinement::Plan plan;
  plan.num_levels = num_levels;
  plan.max_num_rounds = setting_.options.max_num_rounds;
  refinement_.run(plan, active_, &progress_, attempt.state);
  attempt.law = refinement_.law();
  attempt.matches =
      compare_matches(setting_, before_, find_views(setting_, attempt.state, 0), active_);
  return attempt;
}

// Looks for lost images, and refines once more; again while that puts points right.
Attempt Attempts::with_found_images(Attempt attempt) {
  for (int pass = 0; pass < kMaxPasses && !progress_.asks_to_stop(); ++pass) {
    PhotometricState state = attempt.state;
    const std::vector<std::int32_t> found =
        find_lost_images(setting_, base_, start_, wrong_images(attempt), progress_, state);
    if (found.empty() && pass == 0) return attempt;
    Attempt next = refine(std::move(state), attempt.num_levels);
    const double gain = share_of_matched(next) - share_of_matched(attempt);
    const bool is_better =
        num_lost(next) < num_lost(attempt) || (num_lost(next) == num_lost(attempt) && gain > 0.0);
    if (!is_better) return attempt;
    if (!found.empty()) messages_.push_back(text_of(found));
    attempt = std::move(next);
    if (gain < kWorthAnother || share_of_matched(attempt) > kMostAreMatched) return attempt;
  }
  return attempt;
}

int Attempts::num_lost(const Attempt& attempt) const {
  const std::vector<bool> lost = lost_images(attempt.matches, start_, attempt.state);
  return static_cast<int>(std::count(lost.begin(), lost.end(), true));
}

}  // namespace raylign::photometric
