// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#include "raylign/bundle/native/conjugate_gradients.h"

#include <algorithm>
#include <cmath>

namespace raylign::native {
namespace {

// The recurrence of r drifts from b − S x; this often it is computed again.
constexpr int kResidualPeriod = 50;

double dot(const std::vector<double>& a, const std::vector<double>& b) {
  double sum = 0.0;
  for (std::size_t k = 0; k < a.size(); ++k) sum += a[k] * b[k];
  return sum;
}

void add_scaled(double factor, const std::vector<double>& x, std::vector<double>& y) {
  for (std::size_t k = 0; k < x.size(); ++k) y[k] += factor * x[k];
}

}  // namespace

ConjugateGradients::ConjugateGradients(std::size_t size) : r_(size), z_(size), p_(size), q_(size) {}

double ConjugateGradients::norm(SchurPreconditioner& M, const std::vector<double>& b) {
  M.apply(b.data(), z_.data());
  return std::sqrt(dot(b, z_));
}

CgResult ConjugateGradients::solve(SchurProduct& S,
                                   SchurPreconditioner& M,
                                   const std::vector<double>& b,
                                   const CgLimits& limits,
                                   const InterruptCheck& interrupted,
                                   std::vector<double>& x) {
  CgResult result;
  std::fill(x.begin(), x.end(), 0.0);
  r_ = b;
  M.apply(r_.data(), z_.data());
  p_ = z_;
  double rho = dot(r_, z_);
  result.solved = rho >= 0.0 && std::isfinite(rho);
  if (!result.solved || rho == 0.0) return result;
  const double rho_limit = limits.residual_tolerance * limits.residual_tolerance * rho;
  double Q = 0.0;  // ½ xᵀSx − bᵀx
  while (result.iterations < limits.max_num_iterations) {
    if (interrupted && interrupted()) {
      result.interrupted = true;
      return result;
    }
    S.multiply(p_.data(), q_.data());
    ++result.iterations;
    const double curvature = dot(p_, q_);
    if (!(curvature > 0.0) || !std::isfinite(curvature)) {  // what there is so far is a step
      result.solved = result.iterations > 1;
      return result;
    }
    const double alpha = rho / curvature;
    add_scaled(alpha, p_, x);
    if (result.iterations % kResidualPeriod == 0) {
      S.multiply(x.data(), q_.data());
      for (std::size_t k = 0; k < r_.size(); ++k) r_[k] = b[k] - q_[k];
    } else {
      add_scaled(-alpha, q_, r_);
    }
    const double gain = 0.5 * alpha * rho;
    Q -= gain;
    if (result.iterations * gain <= limits.model_tolerance * -Q) return result;
    M.apply(r_.data(), z_.data());
    const double next_rho = dot(r_, z_);
    if (!(next_rho > rho_limit)) return result;
    const double beta = next_rho / rho;
    rho = next_rho;
    for (std::size_t k = 0; k < p_.size(); ++k) p_[k] = z_[k] + beta * p_[k];
  }
  return result;
}

}  // namespace raylign::native
