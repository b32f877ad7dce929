// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// Photometric bundle adjustment, the native engine beside Ceres with analytic 16-row Jacobians, on
// one scene: JSON on stdout, times in ms, medians over the rounds, engines in turn.
//
//   photometric_benchmark [--points 4118] [--images 7] [--size 640x480] [--raw FILE]
//                         [--law patch_huber|student_t] [--warps] [--inverse-depth] [--leaving
//                         zero]
//                         [--rounds 7] [--iterations 8] [--threads 1] [--engines native,ceres]
//
// --raw: the scene of a file as benchmarks/photometric.py writes it, instead of a rendered one.
#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <map>
#include <stdexcept>
#include <string>
#include <vector>

#include "raylign/base/blas_threads.h"
#include "raylign/base/stopwatch.h"
#include "raylign/ceres_backend/patch_solver.h"
#include "raylign/photometric/native/patch_problem.h"
#include "raylign/photometric/native/solve.h"
#include "support/patch_scenes.h"

namespace raylign {
namespace {

struct Arguments {
  test::PatchSceneOptions scene;
  std::string raw;
  std::string law = "patch_huber";
  std::string engines = "native,ceres";
  bool warps = false;
  bool zero = false;
  int rounds = 7;
  int iterations = 8;
  int threads = 1;
};

Arguments parse(int argc, char** argv) {
  Arguments out;
  out.scene.num_points = 4118;
  out.scene.num_images = 7;
  out.scene.width = 640;
  out.scene.height = 480;
  std::map<std::string, int*> numbers = {{"--points", &out.scene.num_points},
                                         {"--images", &out.scene.num_images},
                                         {"--rounds", &out.rounds},
                                         {"--iterations", &out.iterations},
                                         {"--threads", &out.threads}};
  std::map<std::string, std::string*> words = {
      {"--raw", &out.raw}, {"--law", &out.law}, {"--engines", &out.engines}};
  std::map<std::string, bool*> flags = {{"--warps", &out.warps},
                                        {"--inverse-depth", &out.scene.inverse_depth}};
  for (int i = 1; i < argc; ++i) {
    const std::string word = argv[i];
    const bool has_value = i + 1 < argc;
    if (flags.count(word) != 0) {
      *flags[word] = true;
    } else if (numbers.count(word) != 0 && has_value) {
      *numbers[word] = std::atoi(argv[++i]);
    } else if (words.count(word) != 0 && has_value) {
      *words[word] = argv[++i];
    } else if (word == "--leaving" && has_value) {
      out.zero = std::string(argv[++i]) == "zero";
    } else if (word == "--size" && has_value &&
               std::sscanf(argv[++i], "%dx%d", &out.scene.width, &out.scene.height) == 2) {
      continue;
    } else {
      throw std::runtime_error("unknown argument " + word);
    }
  }
  return out;
}

template <typename T>
std::vector<T> read_array(std::istream& in, std::size_t count) {
  std::vector<T> values(count);
  in.read(reinterpret_cast<char*>(values.data()), static_cast<std::streamsize>(count * sizeof(T)));
  if (!in) throw std::runtime_error("the raw scene ends too early");
  return values;
}

// A text line `M N w h fx fy cx cy`, then R_cw | t_cw (M, 3, 4) and points (N, 3) float64, patches
// (N, 16) float32, images (M, h, w) uint8. Every image is a candidate for every point.
PatchScene read_raw(const std::string& path) {
  std::ifstream in(path, std::ios::binary);
  std::size_t M = 0, N = 0;
  int w = 0, h = 0;
  PatchScene scene;
  scene.intrinsics.resize(1, 4);
  in >> M >> N >> w >> h;
  for (int k = 0; k < 4; ++k) in >> scene.intrinsics(0, k);
  in.get();
  const std::vector<double> poses = read_array<double>(in, 12 * M);
  const std::vector<double> points = read_array<double>(in, 3 * N);
  scene.pattern = PatchPattern::square(4);
  scene.patches = read_array<float>(in, 16 * N);
  for (std::size_t i = 0; i < M; ++i) {
    const Eigen::Map<const RowMajor<3, 4>> T(&poses[12 * i]);
    scene.poses.push_back({quaternion_from_matrix(T.leftCols<3>()), T.col(3)});
    const auto size = static_cast<std::size_t>(w) * static_cast<std::size_t>(h);
    const std::vector<std::uint8_t> grey = read_array<std::uint8_t>(in, size);
    const ImageView view = {grey.data(), PixelType::UINT8, w, h, 1, static_cast<std::size_t>(w)};
    scene.images.push_back(
        std::make_shared<PatchImage>(ImagePyramid(view, {1, 1}), scene.interpolation));
  }
  scene.brightness.setZero(static_cast<Eigen::Index>(M), 2);
  scene.points = Eigen::Map<const Rows<double, 3>>(points.data(), static_cast<Eigen::Index>(N), 3);
  scene.host_uv.setZero(static_cast<Eigen::Index>(N), 2);
  scene.hosts.assign(N, -1);
  scene.starts = {0};
  for (std::size_t p = 0; p < N; ++p) {
    for (std::size_t i = 0; i < M; ++i) scene.edges.emplace_back().image = static_cast<int>(i);
    scene.starts.push_back(scene.num_edges());
  }
  return scene;
}

PatchScene make_scene(const Arguments& arguments) {
  if (!arguments.raw.empty()) return read_raw(arguments.raw);
  test::PatchSceneOptions options = arguments.scene;
  options.hosted = options.inverse_depth;
  options.min_views = options.num_images;
  options.brightness = true;
  options.sigma = 2.0;
  PatchScene scene = test::patch_case(options).start;
  if (!arguments.warps) {  // the exercise's model
    for (PatchEdge& edge : scene.edges) edge.A = {1.0f, 0.0f, 0.0f, 1.0f};
  }
  return scene;
}

PatchSolveOptions make_options(const Arguments& arguments) {
  PatchSolveOptions options;
  options.loss = {LossType::HUBER, 36.0, 5.0};  // 5.13 σ of the exercise's σ = 7
  options.scope = LossScope::PATCH;
  if (arguments.law == "student_t") {
    options.loss = {LossType::STUDENT_T, 4.75, 5.0};
    options.scope = LossScope::PIXEL;
  }
  options.leaving = arguments.zero ? LeavingRule::ZERO : LeavingRule::KEEP_COST;
  options.lm.max_num_iterations = arguments.iterations;
  options.lm.function_tolerance = 0.0;  // all iterations asked for
  options.lm.parameter_tolerance = 0.0;
  options.lm.gradient_tolerance = 0.0;
  options.lm.num_threads = arguments.threads;
  return options;
}

double median(std::vector<double> values) {
  if (values.empty()) return -1.0;
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

template <typename F>
double milliseconds(const F& f) {
  const Stopwatch watch;
  f();
  return 1e3 * watch.seconds();
}

// kB of a line of /proc/self/status.
double status_mib(const std::string& key) {
  std::ifstream in("/proc/self/status");
  std::string word;
  double kb = 0.0;
  while (in >> word) {
    if (word == key + ":" && in >> kb) return kb / 1024.0;
  }
  return -1.0;
}

struct Measured {
  std::vector<double> iteration, set_up;
  std::vector<double> linearize, solve, trial;  // per call
  Summary last;
};

// One solve from the start: accepted iterations by the rows that both engines keep.
template <typename Solve>
void measure_solve(const PatchScene& start, const Solve& solve, Measured& out) {
  PatchScene scene = start;
  out.last = solve(scene);
  out.set_up.push_back(1e3 * out.last.preprocessor_time_s);
  for (const IterationSummary& row : out.last.iterations) {
    if (row.step_is_accepted) out.iteration.push_back(1e3 * row.iteration_time_s);
  }
}

// The stages by themselves, at the start.
void measure_stages(const PatchScene& start,
                    const PatchConstraints& held,
                    const PatchSolveOptions& options,
                    Measured& out) {
  const ScopedSingleThreadedBlas single_threaded_blas;
  native::PatchProblem problem(start, held, options);
  for (int i = 0; i < 15; ++i) {
    out.linearize.push_back(milliseconds([&] { problem.linearize(); }));
    out.solve.push_back(milliseconds([&] { problem.solve(options.lm.initial_lambda); }));
    out.trial.push_back(milliseconds([&] { problem.try_step(); }));
  }
}

// Ceres adds its stages up; divided by how often each ran.
void measure_ceres_stages(Measured& out) {
  const auto rows = static_cast<double>(out.last.iterations.size());
  const double steps = rows - 1.0;
  out.linearize.push_back(1e3 * out.last.jacobian_time_s / (1.0 + out.last.num_accepted));
  out.solve.push_back(1e3 * out.last.linear_solver_time_s / steps);
  out.trial.push_back(1e3 * out.last.residual_time_s / steps);
}

void print(const char* engine, const Measured& m) {
  const auto best = [](const std::vector<double>& v) {
    return v.empty() ? -1.0 : *std::min_element(v.begin(), v.end());
  };
  std::printf(
      ", \"%s\": {\"iteration_ms\": %.4f, \"iteration_best_ms\": %.4f, \"linearize_ms\": %.4f, "
      "\"solve_ms\": %.4f, \"trial_ms\": %.4f, \"trial_best_ms\": %.4f, \"set_up_ms\": %.4f, "
      "\"accepted\": %d, \"rejected\": %d, \"initial_cost\": %.9e, \"final_cost\": %.9e}",
      engine, median(m.iteration), best(m.iteration), median(m.linearize), median(m.solve),
      median(m.trial), best(m.trial), median(m.set_up), m.last.num_accepted, m.last.num_rejected,
      m.last.initial_cost, m.last.final_cost);
}

std::int64_t count_seen(const PatchScene& scene) {
  std::int64_t count = 0;
  for (std::int64_t p = 0; p < scene.num_points(); ++p) {
    for (std::int64_t e = scene.starts[p]; e < scene.starts[p + 1]; ++e) {
      count += evaluate_edge(scene, p, scene.edges[e]).is_seen ? 1 : 0;
    }
  }
  return count;
}

void run(const Arguments& arguments) {
  const PatchScene start = make_scene(arguments);
  PatchConstraints held = test::patch_constraints(start, true);
  held.poses.back() = {};  // free scale: what is cheapest for no engine
  const PatchSolveOptions options = make_options(arguments);
  const bool with_native = arguments.engines.find("native") != std::string::npos;
  const bool with_ceres = arguments.engines.find("ceres") != std::string::npos;
  const double scene_mib = status_mib("VmRSS");
  double native_mib = -1.0;
  Measured native, ceres;
  for (int round = 0; round < arguments.rounds; ++round) {
    if (with_native) {
      measure_solve(
          start, [&](PatchScene& s) { return native::solve_patches(s, held, options); }, native);
      measure_stages(start, held, options, native);
      if (round == 0) native_mib = status_mib("VmHWM") - scene_mib;
    }
    if (with_ceres) {
      measure_solve(
          start, [&](PatchScene& s) { return ceres_backend::solve_patches(s, held, options); },
          ceres);
      measure_ceres_stages(ceres);
    }
  }
  std::printf(
      "{\"points\": %lld, \"images\": %lld, \"edges\": %lld, \"seen\": %lld, \"law\": \"%s\", "
      "\"warps\": %s, \"inverse_depth\": %s, \"threads\": %d, \"scene_mib\": %.1f, "
      "\"native_mib\": %.1f, \"peak_mib\": %.1f",
      static_cast<long long>(start.num_points()), static_cast<long long>(start.num_images()),
      static_cast<long long>(start.num_edges()), static_cast<long long>(count_seen(start)),
      arguments.law.c_str(), arguments.warps ? "true" : "false",
      start.inverse_depth ? "true" : "false", arguments.threads, scene_mib, native_mib,
      status_mib("VmHWM"));
  if (with_native) print("native", native);
  if (with_ceres) print("ceres", ceres);
  std::printf("}\n");
}

}  // namespace
}  // namespace raylign

int main(int argc, char** argv) {
  try {
    raylign::run(raylign::parse(argc, argv));
  } catch (const std::exception& error) {
    std::fprintf(stderr, "photometric_benchmark: %s\n", error.what());
    return 1;
  }
  return 0;
}
