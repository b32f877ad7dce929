// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
// What this machine gives one and two threads, right now: a loop bound by memory (the triad of
// McCalpin's STREAM) and a loop bound by arithmetic (independent multiply-adds in registers).
// Prints one JSON line. A speed-up of two threads means something only beside these.
//
//   reference_loops [--repeats 5]
#include <algorithm>
#include <chrono>
#include <cstdio>
#include <cstdlib>
#include <cstring>
#include <functional>
#include <thread>
#include <vector>

namespace {

constexpr std::size_t kTriadLength = std::size_t{1} << 25;  // 3 x 256 MiB: beyond any cache
constexpr int kLanes = 64;                                  // enough chains to hide the latency
constexpr long kMultiplyAdds = 1L << 26;                    // per lane group

double seconds(const std::function<void()>& work) {
  const auto start = std::chrono::steady_clock::now();
  work();
  return std::chrono::duration<double>(std::chrono::steady_clock::now() - start).count();
}

/// Runs work(0) … work(threads − 1) at once.
void in_parallel(int threads, const std::function<void(int)>& work) {
  std::vector<std::thread> pool;
  for (int i = 1; i < threads; ++i) pool.emplace_back(work, i);
  work(0);
  for (std::thread& thread : pool) thread.join();
}

struct Triad {
  std::vector<double> a = std::vector<double>(kTriadLength, 1.0);
  std::vector<double> b = std::vector<double>(kTriadLength, 2.0);
  std::vector<double> c = std::vector<double>(kTriadLength, 3.0);

  void run(int part, int parts) {
    const std::size_t first = kTriadLength * part / parts;
    const std::size_t last = kTriadLength * (part + 1) / parts;
    double* out = a.data();
    const double *x = b.data(), *y = c.data();
    for (std::size_t i = first; i < last; ++i) out[i] = x[i] + 1.5 * y[i];
  }
};

/// `count` rounds of kLanes multiply-adds; the sum keeps the compiler honest.
__attribute__((target_clones("default", "arch=x86-64-v3", "arch=x86-64-v4"))) double multiply_add(
    long count) {
  double lane[kLanes];
  for (int i = 0; i < kLanes; ++i) lane[i] = 1e-3 * i;
  for (long k = 0; k < count; ++k) {
    for (int i = 0; i < kLanes; ++i) lane[i] = lane[i] * 0.999999 + 1e-9;
  }
  double sum = 0.0;
  for (const double value : lane) sum += value;
  return sum;
}

volatile double sink;

}  // namespace

int main(int argc, char** argv) {
  const int repeats = argc > 2 && std::strcmp(argv[1], "--repeats") == 0 ? std::atoi(argv[2]) : 5;
  Triad triad;
  const long rounds = kMultiplyAdds / kLanes * 16;
  double bandwidth[3] = {}, flops[3] = {};  // best of the repeats, by number of threads
  for (int repeat = 0; repeat < repeats; ++repeat) {
    for (const int threads : {1, 2}) {
      const double memory_s =
          seconds([&] { in_parallel(threads, [&](int i) { triad.run(i, threads); }); });
      bandwidth[threads] = std::max(bandwidth[threads], 24e-9 * kTriadLength / memory_s);
      const double compute_s =
          seconds([&] { in_parallel(threads, [&](int) { sink = multiply_add(rounds); }); });
      flops[threads] = std::max(flops[threads], 2e-9 * kLanes * rounds * threads / compute_s);
    }
  }
  std::printf(
      "{\"triad_gb_per_s\": [%.2f, %.2f], \"multiply_add_gflop_per_s\": [%.2f, %.2f], "
      "\"triad_scaling\": %.3f, \"multiply_add_scaling\": %.3f}\n",
      bandwidth[1], bandwidth[2], flops[1], flops[2], bandwidth[2] / bandwidth[1],
      flops[2] / flops[1]);
  return 0;
}
