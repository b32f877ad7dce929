"""SO(3), SE(3), Sim(3) and quaternions on NumPy arrays with leading batch dimensions.

Rotation vectors ω are in rad; SE(3) and Sim(3) are 4x4 matrices [sR t; 0 1] (s = 1 for SE(3))
that map points of frame b to frame a, T_ab. Tangents put the translation first: ξ = [υ; ω] and
ξ = [υ; ω; σ] with s = exp(σ). The update is from the left, T ← exp(ξ) T. Quaternions are xyzw,
Hamilton product.

Every function takes real arrays or nested lists (..., n) or (..., n, n) and returns a new
C-ordered float64 array with the same leading dimensions. Exponentials, logarithms and Jacobians
keep full accuracy near ω = 0; logarithms give ‖ω‖ <= π and are stable there. Matrices are not
checked for being rotations: one off by ε gives a result off by O(ε). All release the GIL.

Raises:
    ShapeError: (every function) the trailing dimensions are wrong or the values are not real
        numbers.

Source: Barfoot, State Estimation for Robotics, ch. 7; Strasdat, PhD thesis 2012, §2.4.
"""

import numpy.typing as npt

from raylign import _core
from raylign._typing import F64

__all__ = [
    "quaternion_exp",
    "quaternion_from_matrix",
    "quaternion_log",
    "quaternion_to_matrix",
    "se3_adjoint",
    "se3_exp",
    "se3_hat",
    "se3_inverse",
    "se3_left_jacobian",
    "se3_left_jacobian_inverse",
    "se3_log",
    "se3_right_jacobian",
    "se3_right_jacobian_inverse",
    "se3_vee",
    "sim3_adjoint",
    "sim3_exp",
    "sim3_hat",
    "sim3_inverse",
    "sim3_left_jacobian",
    "sim3_left_jacobian_inverse",
    "sim3_log",
    "sim3_right_jacobian",
    "sim3_right_jacobian_inverse",
    "sim3_vee",
    "so3_adjoint",
    "so3_exp",
    "so3_hat",
    "so3_left_jacobian",
    "so3_left_jacobian_inverse",
    "so3_log",
    "so3_right_jacobian",
    "so3_right_jacobian_inverse",
    "so3_vee",
    "umeyama",
]


def so3_hat(omega: npt.ArrayLike) -> F64:
    """Matrices [ω]× with [ω]× v = ω × v.

    Args:
        omega: (..., 3) rotation vectors, rad.

    Returns:
        (..., 3, 3) matrices of the Lie algebra.
    """
    return _core.so3_hat(omega)


def so3_vee(omega_hat: npt.ArrayLike) -> F64:
    """Inverse of `so3_hat`.

    Args:
        omega_hat: (..., 3, 3) matrices of the Lie algebra.

    Returns:
        (..., 3) rotation vectors, rad.
    """
    return _core.so3_vee(omega_hat)


def so3_exp(omega: npt.ArrayLike) -> F64:
    """Exponential map: R = exp([ω]×), Rodrigues' formula.

    Args:
        omega: (..., 3) rotation vectors, rad.

    Returns:
        (..., 3, 3) rotation matrices.
    """
    return _core.so3_exp(omega)


def so3_log(R: npt.ArrayLike) -> F64:
    """Logarithm with ‖ω‖ <= π; at π either of ω and −ω.

    Args:
        R: (..., 3, 3) rotation matrices.

    Returns:
        (..., 3) rotation vectors, rad.
    """
    return _core.so3_log(R)


def so3_adjoint(R: npt.ArrayLike) -> F64:
    """Adjoint (..., 3, 3) at `R` (..., 3, 3): R exp(ω) R⁻¹ = exp(Ad_R ω); R itself."""
    return _core.so3_adjoint(R)


def so3_left_jacobian(omega: npt.ArrayLike) -> F64:
    """Left Jacobian (..., 3, 3) at `omega` (..., 3): exp(ω + δ) ≈ exp(J_l(ω) δ) exp(ω)."""
    return _core.so3_left_jacobian(omega)


def so3_right_jacobian(omega: npt.ArrayLike) -> F64:
    """Right Jacobian (..., 3, 3) at `omega` (..., 3): exp(ω + δ) ≈ exp(ω) exp(J_r(ω) δ)."""
    return _core.so3_right_jacobian(omega)


def so3_left_jacobian_inverse(omega: npt.ArrayLike) -> F64:
    """Inverse of the left Jacobian (..., 3, 3) at `omega` (..., 3): for ‖ω‖ < 2π."""
    return _core.so3_left_jacobian_inverse(omega)


def so3_right_jacobian_inverse(omega: npt.ArrayLike) -> F64:
    """Inverse of the right Jacobian (..., 3, 3) at `omega` (..., 3): for ‖ω‖ < 2π."""
    return _core.so3_right_jacobian_inverse(omega)


def quaternion_exp(omega: npt.ArrayLike) -> F64:
    """Unit quaternions of rotation vectors: [sin(θ/2) ω/θ; cos(θ/2)].

    Args:
        omega: (..., 3) rotation vectors, rad.

    Returns:
        (..., 4) unit quaternions xyzw.
    """
    return _core.quaternion_exp(omega)


def quaternion_log(q: npt.ArrayLike) -> F64:
    """Rotation vectors with ‖ω‖ <= π; q and −q give the same.

    Args:
        q: (..., 4) quaternions xyzw, not zero, of any norm.

    Returns:
        (..., 3) rotation vectors, rad.
    """
    return _core.quaternion_log(q)


def quaternion_to_matrix(q: npt.ArrayLike) -> F64:
    """Rotation matrices of q / ‖q‖.

    Args:
        q: (..., 4) quaternions xyzw, not zero, of any norm.

    Returns:
        (..., 3, 3) rotation matrices.
    """
    return _core.quaternion_to_matrix(q)


def quaternion_from_matrix(R: npt.ArrayLike) -> F64:
    """Unit quaternions with w >= 0 (Shepperd 1978: no angle is special).

    Args:
        R: (..., 3, 3) rotation matrices.

    Returns:
        (..., 4) unit quaternions xyzw.
    """
    return _core.quaternion_from_matrix(R)


def se3_hat(xi: npt.ArrayLike) -> F64:
    """Matrices [[ω]× υ; 0 0].

    Args:
        xi: (..., 6) tangents [υ; ω].

    Returns:
        (..., 4, 4) matrices of the Lie algebra.
    """
    return _core.se3_hat(xi)


def se3_vee(xi_hat: npt.ArrayLike) -> F64:
    """Inverse of `se3_hat`.

    Args:
        xi_hat: (..., 4, 4) matrices of the Lie algebra.

    Returns:
        (..., 6) tangents [υ; ω].
    """
    return _core.se3_vee(xi_hat)


def se3_exp(xi: npt.ArrayLike) -> F64:
    """Exponential map: [exp(ω) J_l(ω) υ; 0 1].

    Args:
        xi: (..., 6) tangents [υ; ω].

    Returns:
        (..., 4, 4) rigid transforms.
    """
    return _core.se3_exp(xi)


def se3_log(T: npt.ArrayLike) -> F64:
    """Logarithm with ‖ω‖ <= π; at π either of ω and −ω.

    Args:
        T: (..., 4, 4) rigid transforms.

    Returns:
        (..., 6) tangents [υ; ω].
    """
    return _core.se3_log(T)


def se3_inverse(T: npt.ArrayLike) -> F64:
    """Inverse transforms [Rᵀ −Rᵀt; 0 1].

    Args:
        T: (..., 4, 4) rigid transforms.

    Returns:
        (..., 4, 4) rigid transforms.
    """
    return _core.se3_inverse(T)


def se3_adjoint(T: npt.ArrayLike) -> F64:
    """Adjoint (..., 6, 6) at `T` (..., 4, 4): T exp(ξ) T⁻¹ = exp(Ad_T ξ); [R [t]×R; 0 R]."""
    return _core.se3_adjoint(T)


def se3_left_jacobian(xi: npt.ArrayLike) -> F64:
    """Left Jacobian (..., 6, 6) at `xi` (..., 6): exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ)."""
    return _core.se3_left_jacobian(xi)


def se3_right_jacobian(xi: npt.ArrayLike) -> F64:
    """Right Jacobian (..., 6, 6) at `xi` (..., 6): exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ)."""
    return _core.se3_right_jacobian(xi)


def se3_left_jacobian_inverse(xi: npt.ArrayLike) -> F64:
    """Inverse of the left Jacobian (..., 6, 6) at `xi` (..., 6): for ‖ω‖ < 2π."""
    return _core.se3_left_jacobian_inverse(xi)


def se3_right_jacobian_inverse(xi: npt.ArrayLike) -> F64:
    """Inverse of the right Jacobian (..., 6, 6) at `xi` (..., 6): for ‖ω‖ < 2π."""
    return _core.se3_right_jacobian_inverse(xi)


def sim3_hat(xi: npt.ArrayLike) -> F64:
    """Matrices [σI + [ω]× υ; 0 0].

    Args:
        xi: (..., 7) tangents [υ; ω; σ].

    Returns:
        (..., 4, 4) matrices of the Lie algebra.
    """
    return _core.sim3_hat(xi)


def sim3_vee(xi_hat: npt.ArrayLike) -> F64:
    """Inverse of `sim3_hat`.

    Args:
        xi_hat: (..., 4, 4) matrices of the Lie algebra.

    Returns:
        (..., 7) tangents [υ; ω; σ].
    """
    return _core.sim3_vee(xi_hat)


def sim3_exp(xi: npt.ArrayLike) -> F64:
    """Exponential map: [exp(σ) exp(ω) V υ; 0 1], V = ∫₀¹ exp(s (σI + [ω]×)) ds.

    Args:
        xi: (..., 7) tangents [υ; ω; σ].

    Returns:
        (..., 4, 4) similarities.
    """
    return _core.sim3_exp(xi)


def sim3_log(S: npt.ArrayLike) -> F64:
    """Logarithm with ‖ω‖ <= π; at π either of ω and −ω. NaN where det(sR) <= 0.

    Args:
        S: (..., 4, 4) similarities.

    Returns:
        (..., 7) tangents [υ; ω; σ].
    """
    return _core.sim3_log(S)


def sim3_inverse(S: npt.ArrayLike) -> F64:
    """Inverse similarities [Rᵀ/s −Rᵀt/s; 0 1].

    Args:
        S: (..., 4, 4) similarities.

    Returns:
        (..., 4, 4) similarities.
    """
    return _core.sim3_inverse(S)


def sim3_adjoint(S: npt.ArrayLike) -> F64:
    """Adjoint (..., 7, 7) at `S` (..., 4, 4).

    S exp(ξ) S⁻¹ = exp(Ad_S ξ); [sR [t]×R −t; 0 R 0; 0 0 1].
    """
    return _core.sim3_adjoint(S)


def sim3_left_jacobian(xi: npt.ArrayLike) -> F64:
    """Left Jacobian (..., 7, 7) at `xi` (..., 7): exp(ξ + δ) ≈ exp(J_l(ξ) δ) exp(ξ)."""
    return _core.sim3_left_jacobian(xi)


def sim3_right_jacobian(xi: npt.ArrayLike) -> F64:
    """Right Jacobian (..., 7, 7) at `xi` (..., 7): exp(ξ + δ) ≈ exp(ξ) exp(J_r(ξ) δ)."""
    return _core.sim3_right_jacobian(xi)


def sim3_left_jacobian_inverse(xi: npt.ArrayLike) -> F64:
    """Inverse of the left Jacobian (..., 7, 7) at `xi` (..., 7): for ‖ω‖ < 2π."""
    return _core.sim3_left_jacobian_inverse(xi)


def sim3_right_jacobian_inverse(xi: npt.ArrayLike) -> F64:
    """Inverse of the right Jacobian (..., 7, 7) at `xi` (..., 7): for ‖ω‖ < 2π."""
    return _core.sim3_right_jacobian_inverse(xi)


def umeyama(source: F64, target: F64, *, with_scale: bool = True) -> F64:
    """Similarity S = [sR t; 0 1] that minimises Σ_i ‖target_i − S source_i‖².

    Args:
        source: (N, 3) float64, C order, N >= 3, not all on one line.
        target: (N, 3) float64, C order.
        with_scale: False holds s = 1: the best rigid transform.

    Returns:
        (4, 4) S, from the frame of `source` to the frame of `target`.

    Raises:
        ShapeError: shapes or dtypes disagree, or N < 3.
        Error: the points do not determine a rotation, or are not finite.

    Source: Umeyama, PAMI 1991, eqs. (40)-(43).

    Example:
        >>> import numpy as np
        >>> source = np.random.default_rng(0).normal(size=(10, 3))
        >>> S = sim3_exp([1.0, 2.0, 3.0, 0.1, 0.2, 0.3, 0.5])
        >>> target = source @ S[:3, :3].T + S[:3, 3]
        >>> bool(np.allclose(umeyama(source, target), S))
        True
    """
    return _core.umeyama(source, target, with_scale=with_scale)
