// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What each stage of an iteration of the native engine takes on a problem: one JSON line per stage
// with the best of the repeats, and the bytes and flops that the stage cannot do without. What the
// machine can do: reference_loops.
//
//   native_stages FILE [--repeats 20] [--threads 1] [--pose se3|quaternion|angle_axis]
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <string>

#include "raylign/base/blas_threads.h"
#include "raylign/base/stopwatch.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/bundle/native/schur_system.h"
#include "raylign/io/bal.h"
#include "raylign/parametrization/constants.h"

namespace raylign::native {
namespace {

struct Arguments {
  std::string file;
  int repeats = 20;
  int threads = 1;
  PoseParametrization pose = PoseParametrization::ANGLE_AXIS;
};

Arguments parse(int argc, char** argv) {
  Arguments arguments;
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const std::string value = i + 1 < argc ? argv[i + 1] : "";
    if (word == "--repeats") {
      arguments.repeats = std::atoi(argv[++i]);
    } else if (word == "--threads") {
      arguments.threads = std::atoi(argv[++i]);
    } else if (word == "--pose") {
      for (const auto pose : {PoseParametrization::SE3, PoseParametrization::QUATERNION}) {
        if (to_string(pose) == value) arguments.pose = pose;
      }
      ++i;
    } else {
      arguments.file = word;
    }
  }
  return arguments;
}

template <typename Run>
double best_seconds(int repeats, const Run& run) {
  double best = 1e30;
  for (int i = 0; i < repeats; ++i) {
    const Stopwatch watch;
    run();
    best = std::min(best, watch.seconds());
  }
  return best;
}

class Stages {
 public:
  Stages(const BalProblem& problem, const Arguments& arguments)
      : arguments_(arguments),
        options_(make_options(arguments)),
        held_(resolve_constants(problem, {})),
        native_(problem, held_, options_),
        layout_(native_.layout()),
        system_({layout_, native_.cameras(), native_.pool()},
                SchurPattern(layout_, moving_cameras(native_.cameras()))),
        n_(static_cast<double>(layout_.num_observations())),
        landmarks_(static_cast<double>(layout_.num_landmarks()) / n_) {
    preprocess_s_ =
        best_seconds(3, [&] { const ReprojectionProblem again(problem, held_, options_); });
  }

  void print() {
    const SchurPattern& pattern = system_.pattern();
    const ProductPlan& plan = system_.plan();
    const double products = static_cast<double>(pattern.num_pairs) / n_;
    const double visits = static_cast<double>(plan.visits.size()) / n_;
    const double blocks = static_cast<double>(pattern.num_blocks()) / n_;
    const double columns = native_.cameras().num_columns();
    std::printf(
        "{\"file\": \"%s\", \"observations\": %.0f, \"landmarks\": %.0f, \"cameras\": %d, "
        "\"products_per_observation\": %.3f, \"blocks\": %.0f, \"products_per_visit\": %.2f, "
        "\"preprocess_ns_per_observation\": %.1f}\n",
        std::filesystem::path(arguments_.file).filename().c_str(), n_, landmarks_ * n_,
        layout_.num_cameras, products, blocks * n_, products / std::max(visits, 1e-9),
        1e9 * preprocess_s_ / n_);
    // uv, camera and place of an observation, X of a landmark; H and g. J stays in registers, F and
    // r in the cache. Flops: projection, J, H, and U, g with all of their 9 × 9.
    const double linearize_s = best([&] { native_.linearize(); });
    row("linearize", linearize_s, 24 + landmarks_ * (24 + 72), 150 + 4 * (81 + 9));
    // camera and product list; W, g, X; each visited block read and written. Flops: J again, Z
    const double damp_s = best([&] { native_.damped(kLambda); });
    row("damp", damp_s, landmarks_ * (48 + 24 + 48), landmarks_ * 40);
    const DampedProblem damped = native_.damped(kLambda);
    const double form_s = best([&] { system_.form(damped); });
    row("form_schur", form_s,
        4 + 4 * products + visits * (12 + 2 * sizeof(Block)) + landmarks_ * (48 + 24 + 24 + 8),
        230 + 486 * products + blocks * 4 * 729);
    const double solve_s = best([&] { native_.solve(kLambda); }) - form_s - damp_s;
    row("factor_and_solve", solve_s, columns * columns * 4 / n_,
        columns * columns * columns / 3 / n_);
    const double try_s = best([&] { native_.try_step(); });
    // J again, F δ; then each point once more with its H, for the step of its own
    row("try_step", try_s, 24 + landmarks_ * (24 + 72 + 48 + 24), 350);
    row("iteration", linearize_s + damp_s + form_s + solve_s + try_s, 0, 0);
    std::printf("{\"stage\": \"products\", \"ns_per_product\": %.2f}\n",
                1e9 * form_s / n_ / products);
  }

 private:
  static constexpr double kLambda = 1e-4;

  static BundleOptions make_options(const Arguments& arguments) {
    BundleOptions options;
    options.pose_parametrization = arguments.pose;
    options.linear_solver.type = LinearSolverType::DENSE_SCHUR;
    options.lm.num_threads = arguments.threads;
    return options;
  }

  template <typename Run>
  double best(const Run& run) const {
    return best_seconds(arguments_.repeats, run);
  }

  void row(const char* stage, double seconds, double bytes, double flops) const {
    const double ns = 1e9 * seconds / n_;
    std::printf(
        "{\"stage\": \"%s\", \"threads\": %d, \"seconds\": %.6f, \"ns_per_observation\": %.2f, "
        "\"bytes_per_observation\": %.1f, \"flops_per_observation\": %.1f, \"gb_per_s\": %.2f, "
        "\"gflop_per_s\": %.2f}\n",
        stage, arguments_.threads, seconds, ns, bytes, flops, bytes / ns, flops / ns);
  }

  Arguments arguments_;
  BundleOptions options_;
  Constants held_;
  ReprojectionProblem native_;
  const Layout& layout_;
  SchurSystem system_;
  double n_;
  double landmarks_;  // per observation
  double preprocess_s_ = 0.0;
};

}  // namespace
}  // namespace raylign::native

int main(int argc, char** argv) {
  const raylign::native::Arguments arguments = raylign::native::parse(argc, argv);
  const raylign::ScopedSingleThreadedBlas single_threaded_blas;
  raylign::native::Stages(raylign::read_bal(arguments.file), arguments).print();
  return 0;
}
