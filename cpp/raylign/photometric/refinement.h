// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

#include "raylign/base/stopwatch.h"
#include "raylign/patch/patch_solve_options.h"
#include "raylign/photometric/frozen.h"
#include "raylign/photometric/noise_law.h"
#include "raylign/photometric/views.h"
#include "raylign/solver/summary.h"

namespace raylign::photometric {

/// The law that a round takes its residuals for.
struct RoundLaw {
  NoiseLaw noise;
  Loss loss;
  double unit = 1.0;  ///< cost per nat, grey²
};
RoundLaw estimate_law(const Setting& setting, const Views& views, const std::vector<bool>& active);

/// What all solves of one call share: the user's callback, the clock, and what has been done.
class Progress {
 public:
  Progress(const PhotometricOptions& options,
           const Stopwatch& clock,
           const IterationCallback& callback,
           const InterruptCheck& interrupted)
      : options_(options), clock_(clock), callback_(callback), interrupted_(interrupted) {}

  /// Whether the user or the time limit has asked for the end.
  bool is_over() const { return is_over_; }
  /// Asks, between solves: an interrupt and the time limit end everything.
  bool asks_to_stop();
  double seconds_left() const;
  /// Runs one solve. Its rows are appended to summary(), numbered through; row 0 of the first
  /// only.
  Summary solve(PatchScene& scene, const PatchConstraints& constraints, PatchSolveOptions options);
  const Summary& summary() const { return summary_; }

 private:
  void append(const Summary& part);

  const PhotometricOptions& options_;
  const Stopwatch& clock_;
  const IterationCallback& callback_;
  const InterruptCheck& interrupted_;
  Summary summary_;
  bool is_over_ = false;
};

/// Coarse to fine, round by round.
class Refinement {
 public:
  /// @param base   what may move, without priors
  /// @param start  what the priors are centred on
  Refinement(const Setting& setting, const PatchConstraints& base, const PhotometricState& start)
      : setting_(setting), base_(base), start_(start) {}

  struct Plan {
    int num_levels = 1;
    int max_num_rounds = 1;
    const RoundLaw* law = nullptr;  ///< null: estimated
  };
  /// Refines `state`, with the edges of the points in `active`. Points that are not solved for move
  /// with their host's camera and points. `progress` null: a solve in the background of another.
  void run(const Plan& plan,
           const std::vector<bool>& active,
           Progress* progress,
           PhotometricState& state);

  /// A solve of the OK edges of `active`, under the law of the last round.
  FrozenProblem make_solve(const Views& views, const std::vector<bool>& active) const;

  void set_law(const RoundLaw& law) { law_ = law; }
  const std::vector<PhotometricRound>& rounds() const { return rounds_; }
  const RoundLaw& law() const { return law_; }                            ///< of the last round
  const std::vector<std::string>& messages() const { return messages_; }  ///< for the user

 private:
  bool is_worth_solving(int level, const std::vector<bool>& active, const PhotometricState& state);
  double run_round(int level,
                   const std::vector<bool>& active,
                   bool estimate,
                   bool is_loose,
                   Progress* progress,
                   PhotometricState& state);
  void adopt(const PatchScene& scene, const PatchConstraints& held, PhotometricState& state) const;
  void carry_along(const PhotometricState& old,
                   const PatchScene& scene,
                   const PatchConstraints& held,
                   PhotometricState& state) const;

  const Setting& setting_;
  const PatchConstraints& base_;
  const PhotometricState& start_;
  std::vector<PhotometricRound> rounds_;
  std::vector<std::string> messages_;
  RoundLaw law_;
};

}  // namespace raylign::photometric
