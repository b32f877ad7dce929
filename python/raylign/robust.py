"""Robust laws ρ(s) of the squared residual norm s = ‖r‖², as Ceres: cost = ½ Σ ρ(‖r‖²).

All have ρ(0) = 0 and ρ'(0) = 1, so that near zero each is plain least squares.

    >>> loss = Loss(type=LossType.HUBER, scale=1.0)
    >>> loss == Loss.parse("huber:1.0")
    True
    >>> rho, d_rho, d2_rho = loss.evaluate([0.25, 4.0])
    >>> rho.tolist(), d_rho.tolist()
    ([0.25, 3.0], [1.0, 0.5])

`Loss.parse` reads type[:scale[:degrees_of_freedom]], the text of the command line's `--loss`,
and raises OptionsError for everything else.

Source: Hartley & Zisserman 2004, appendix A6.8; Black & Rangarajan 1996 (Geman-McClure); Lange
et al. 1989 (Student's t).
"""

from raylign._core import Loss, LossType

__all__ = ["Loss", "LossType"]
