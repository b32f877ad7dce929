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
#include <vector>

#include "raylign/base/blas_threads.h"
#include "raylign/base/stopwatch.h"
#include "raylign/bundle/native/camera_ordering.h"
#include "raylign/bundle/native/dense_cholesky.h"
#include "raylign/bundle/native/reprojection_problem.h"
#include "raylign/bundle/native/schur_system.h"
#include "raylign/bundle/native/supernodal_cholesky.h"
#include "raylign/bundle/native/two_level.h"
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
    print_solvers(damped, columns);
    native_.solve(kLambda);
    const double try_s = best([&] { native_.try_step(); });
    // J again, F δ; then each point once more with its H, for the step of its own
    row("try_step", try_s, 24 + landmarks_ * (24 + 72 + 48 + 24), 350);
    row("iteration", linearize_s + damp_s + form_s + solve_s_ + try_s, 0, 0);
    std::printf("{\"stage\": \"products\", \"ns_per_product\": %.2f}\n",
                1e9 * form_s / n_ / products);
  }

 private:
  static constexpr double kLambda = 1e-4;
  static constexpr double kMaxFlops = 1e11;  // of a factor: more take minutes

  static BundleOptions make_options(const Arguments& arguments) {
    BundleOptions options;
    options.pose_parametrization = arguments.pose;
    options.lm.num_threads = arguments.threads;
    return options;
  }

  // What solves S δ = b: each way to factor it, and what conjugate gradients repeat.
  void print_solvers(const DampedProblem& damped, double columns) {
    const SchurPattern& pattern = system_.pattern();
    const double blocks = static_cast<double>(pattern.num_blocks());
    const double cameras = pattern.num_cameras();
    const SolverContext context{layout_, native_.cameras(), native_.pool()};
    solve_s_ = 1e30;
    if (columns * columns * columns / 3 <= kMaxFlops) {
      DenseCholesky dense(native_.cameras(), native_.pool());
      factor_row("dense_factor", dense, columns * columns * 4, columns * columns * columns / 3);
    }
    const SparseOrdering order = order_cameras(pattern);
    if (order.flops <= kMaxFlops) {
      SupernodalCholesky sparse(native_.cameras(), pattern, order.cameras, native_.pool());
      factor_row("sparse_factor", sparse, 8 * order.nonzeros, order.flops);
    }
    std::vector<double> x(system_.rhs()), y(x.size());
    ExplicitProduct product(context, pattern);
    product.prepare(system_, damped);
    const double product_s = best([&] { product.multiply(x.data(), y.data()); });
    row("product_with_S", product_s, blocks * sizeof(Block) / n_, blocks * 4 * 81 / n_);
    MatrixFreeProduct matrix_free(context);
    matrix_free.prepare(system_, damped);
    const double free_s = best([&] { matrix_free.multiply(x.data(), y.data()); });
    row("matrix_free_product", free_s, 24 + landmarks_ * (48 + 24), 300);
    BlockJacobi jacobi(native_.cameras(), Preconditioner::SCHUR_JACOBI);
    preconditioner_rows("schur_jacobi", jacobi, damped, cameras * 9 * 81, cameras * 2 * 81);
    TwoLevel two_level(context, pattern);
    const double coarse = 7.0 * two_level.num_clusters();
    preconditioner_rows("two_level", two_level, damped,
                        blocks * 2 * (81 + 49) * 7 + coarse * coarse * coarse / 3,
                        cameras * 2 * (81 + 126) + 2 * coarse * coarse);
  }

  void factor_row(const char* stage, SchurFactor& factor, double bytes, double flops) {
    std::vector<double> x(native_.cameras().num_columns(), 1.0);
    const double seconds = best([&] {
      factor.factor(system_);
      factor.solve(x.data());
    });
    row(stage, seconds, bytes / n_, flops / n_);
    solve_s_ = std::min(solve_s_, seconds);
  }

  void preconditioner_rows(const std::string& name,
                           SchurPreconditioner& M,
                           const DampedProblem& damped,
                           double prepare_flops,
                           double apply_flops) {
    const double bytes = static_cast<double>(system_.rhs().size()) * 8 / n_;
    std::vector<double> z(system_.rhs().size());
    const double prepare_s = best([&] { M.prepare(system_, damped); });
    row((name + "_prepare").c_str(), prepare_s, bytes, prepare_flops / n_);
    const double apply_s = best([&] { M.apply(system_.rhs().data(), z.data()); });
    row((name + "_apply").c_str(), apply_s, bytes, apply_flops / n_);
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
  double solve_s_ = 0.0;  // of the faster factor
};

}  // namespace
}  // namespace raylign::native

int main(int argc, char** argv) {
  const raylign::native::Arguments arguments = raylign::native::parse(argc, argv);
  const raylign::ScopedSingleThreadedBlas single_threaded_blas;
  raylign::native::Stages(raylign::read_bal(arguments.file), arguments).print();
  return 0;
}
