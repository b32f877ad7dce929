// SPDX-FileCopyrightText: 2026 The raylign authors
// SPDX-License-Identifier: BSD-3-Clause
#pragma once

#include <string>
#include <vector>

namespace raylign {

/// Robust laws ρ(s) of the squared residual norm s = ‖r‖², all with ρ(0) = 0 and ρ′(0) = 1, so that
/// near zero each is plain least squares. a = scale; x = s / a².
enum class LossType {
  TRIVIAL,        ///< s
  HUBER,          ///< s for s <= a², else 2 a √s − a²
  SOFT_L1,        ///< 2 a² (√(1 + x) − 1)
  CAUCHY,         ///< a² log(1 + x)
  ARCTAN,         ///< a² atan(x)   (Ceres' ArctanLoss takes a² as its argument)
  TUKEY,          ///< a²/3 (1 − (1 − x)³) for x <= 1, else a²/3
  GEMAN_MCCLURE,  ///< s / (1 + x)
  STUDENT_T,  ///< ν a² log(1 + x / ν): negative log-likelihood of Student's t, scaled to ρ′(0) = 1
};

/// ρ and its first two derivatives with respect to s.
struct LossValue {
  double rho;
  double d_rho;
  double d2_rho;
};

/// A robust law with its scale. Value type; evaluate() is pure.
struct Loss {
  LossType type = LossType::TRIVIAL;
  double scale =
      1.0;  ///< a, in units of the residual (px for reprojection); > 0, in [1e-100, 1e100].
  double degrees_of_freedom = 5.0;  ///< ν of STUDENT_T; > 0; unused by the others.

  LossValue evaluate(double squared_norm) const;
  /// Throws OptionsError naming the field, the rule and the value.
  void validate() const;
};

/// "huber", "soft_l1", …: the lower-case enumerator, one name in C++, Python and CLI.
std::string to_string(LossType type);
/// All types in declaration order.
const std::vector<LossType>& all_loss_types();
/// Parses "huber", "huber:1.5", "student_t:1.0:5" (type[:scale[:degrees_of_freedom]]); throws
/// OptionsError.
Loss parse_loss(const std::string& text);

}  // namespace raylign
