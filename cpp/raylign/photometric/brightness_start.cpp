// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/photometric/brightness_start.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

namespace raylign::photometric {
namespace {

constexpr std::size_t kMinPixels = 50;
constexpr double kMaxGain = 20.0;

// Grey values that two images show of the same patches; the second may be the stored patches.
struct Pair {
  std::vector<float> x;  // of the image
  std::vector<float> y;  // of the host
};

double quantile(std::vector<float>& values, double q) {
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(q * double(values.size() - 1));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

using Line = std::array<double, 2>;  // y = [0] x + [1]

// The line that takes the quantiles of x to those of y.
Line match_quantiles(Pair pair, BrightnessModel model) {
  const double x = quantile(pair.x, 0.5);
  const double y = quantile(pair.y, 0.5);
  if (model == BrightnessModel::GAIN) {
    return {std::clamp(y / std::max(x, 1.0), 1.0 / kMaxGain, kMaxGain), 0.0};
  }
  const double x_range = quantile(pair.x, 0.9) - quantile(pair.x, 0.1);
  const double y_range = quantile(pair.y, 0.9) - quantile(pair.y, 0.1);
  if (!(x_range >= 1.0 && y_range >= 1.0)) return {1.0, y - x};
  const double gain = std::clamp(y_range / x_range, 1.0 / kMaxGain, kMaxGain);
  return {gain, y - gain * x};
}

// Pairs of images that show the same patches, keyed (image, host).
std::map<std::pair<int, int>, Pair> collect_pairs(const Setting& setting, const Views& views) {
  std::map<std::pair<int, int>, Pair> pairs;
  const PatchScene& scene = views.scene;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      const PatchEdge& edge = scene.edges[e];
      if (setting.is_host(p, edge.image)) continue;
      const EdgeSample sample = evaluate_edge(scene, p, edge);
      if (!sample.is_seen) continue;
      Pair& pair = pairs[{edge.image, scene.hosts[p]}];
      for (int n = 0; n < scene.pattern.size(); ++n) {
        if (!sample.counts(edge, n)) continue;
        pair.x.push_back(static_cast<float>(sample.value[n]));
        pair.y.push_back(scene.patch(p)[n]);
      }
    }
  }
  return pairs;
}

// One image after another, always the one that shares most pixels with those that are done.
class Chain {
 public:
  Chain(std::int64_t num_images, BrightnessModel model)
      : model_(model), lines_(num_images, Line{1.0, 0.0}) {
    done_.assign(num_images, false);
  }

  void run(const std::map<std::pair<int, int>, Pair>& pairs, bool has_stored) {
    if (!has_stored && !done_.empty()) done_[busiest(pairs)] = true;
    while (add_next(pairs)) {
    }
  }

  /// a, b of e^a I + b.
  Rows<double, 2> brightness() const {
    Rows<double, 2> table = Rows<double, 2>::Zero(static_cast<Eigen::Index>(lines_.size()), 2);
    for (std::size_t i = 0; i < lines_.size(); ++i) {
      table.row(static_cast<Eigen::Index>(i)) << std::log(lines_[i][0]), lines_[i][1];
    }
    return table;
  }

  void rebase(std::size_t image) {
    const Line base = lines_[image];
    for (Line& line : lines_) line = {line[0] / base[0], (line[1] - base[1]) / base[0]};
  }

 private:
  bool is_done(int image) const { return image < 0 || done_[image]; }

  int busiest(const std::map<std::pair<int, int>, Pair>& pairs) const {
    std::vector<std::size_t> pixels(done_.size(), 0);
    for (const auto& [key, pair] : pairs) {
      pixels[key.first] += pair.x.size();
      if (key.second >= 0) pixels[key.second] += pair.x.size();
    }
    return static_cast<int>(std::max_element(pixels.begin(), pixels.end()) - pixels.begin());
  }

  // Both directions of a pair of images, in the brightness of the one that is done.
  Pair with_done(const std::map<std::pair<int, int>, Pair>& pairs, int image) const {
    Pair all;
    for (const auto& [key, pair] : pairs) {
      if (key.first == image && is_done(key.second)) append(pair.x, pair.y, key.second, all);
      if (key.second == image && is_done(key.first)) append(pair.y, pair.x, key.first, all);
    }
    return all;
  }

  void append(const std::vector<float>& own,
              const std::vector<float>& other,
              int other_image,
              Pair& all) const {
    const Line line = other_image < 0 ? Line{1.0, 0.0} : lines_[other_image];
    all.x.insert(all.x.end(), own.begin(), own.end());
    for (const float y : other) all.y.push_back(static_cast<float>(line[0] * y + line[1]));
  }

  bool add_next(const std::map<std::pair<int, int>, Pair>& pairs) {
    int best = -1;
    Pair most;
    for (int image = 0; image < static_cast<int>(done_.size()); ++image) {
      if (done_[image]) continue;
      Pair pair = with_done(pairs, image);
      if (pair.x.size() < kMinPixels || pair.x.size() <= most.x.size()) continue;
      best = image;
      most = std::move(pair);
    }
    if (best < 0) return false;
    lines_[best] = match_quantiles(std::move(most), model_);
    done_[best] = true;
    return true;
  }

  BrightnessModel model_;
  std::vector<Line> lines_;
  std::vector<bool> done_;
};

}  // namespace

Rows<double, 2> estimate_brightness(const Setting& setting,
                                    const PhotometricState& state,
                                    int level) {
  const std::int64_t M = setting.problem.num_images();
  if (setting.options.brightness.model == BrightnessModel::NONE) return Rows<double, 2>::Zero(M, 2);
  PhotometricState plain = state;
  plain.brightness.setZero();
  const auto pairs = collect_pairs(setting, find_views(setting, plain, level));
  Chain chain(M, setting.options.brightness.model);
  const bool has_stored = std::any_of(pairs.begin(), pairs.end(),
                                      [](const auto& entry) { return entry.first.second < 0; });
  chain.run(pairs, has_stored);
  if (!has_stored && M > 0) chain.rebase(0);
  return chain.brightness();
}

}  // namespace raylign::photometric
