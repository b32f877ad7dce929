"""Figures and reports. Needs matplotlib; nothing is shown, every plot function returns a Figure."""

from raylign.viz.cost import plot_cost
from raylign.viz.point_cloud import plot_point_cloud
from raylign.viz.report import bundle_report
from raylign.viz.residuals import plot_residuals
from raylign.viz.sparsity import plot_sparsity
from raylign.viz.trajectory import plot_trajectory

__all__ = [
    "bundle_report",
    "plot_cost",
    "plot_point_cloud",
    "plot_residuals",
    "plot_sparsity",
    "plot_trajectory",
]
