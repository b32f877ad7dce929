// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <Eigen/Core>
#include <cstdint>
#include <random>
#include <string_view>

namespace raylign::test {

/// Random numbers of one test case: a stream is named, so that adding a test changes no other test.
class NamedRng {
 public:
  explicit NamedRng(std::uint64_t seed) : engine_(seed) {}

  double uniform(double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(engine_);
  }
  double normal(double sigma = 1.0) {
    return std::normal_distribution<double>(0.0, sigma)(engine_);
  }
  int integer(int low, int high) {  // both ends included
    return std::uniform_int_distribution<int>(low, high)(engine_);
  }
  template <int N>
  Eigen::Matrix<double, N, 1> normal_vector(double sigma = 1.0) {
    Eigen::Matrix<double, N, 1> v;
    for (int i = 0; i < N; ++i) v[i] = normal(sigma);
    return v;
  }
  template <int N>
  Eigen::Matrix<double, N, 1> unit_vector() {
    return normal_vector<N>().normalized();
  }
  std::mt19937_64& engine() { return engine_; }

 private:
  std::mt19937_64 engine_;
};

/// Stream of (name, index): FNV-1a of the name, mixed with the index.
inline NamedRng make_rng(std::string_view name, std::uint64_t index = 0) {
  std::uint64_t hash = 0xcbf29ce484222325ULL;
  for (const char c : name) hash = (hash ^ static_cast<unsigned char>(c)) * 0x100000001b3ULL;
  return NamedRng(hash ^ (index * 0x9e3779b97f4a7c15ULL));
}

}  // namespace raylign::test
