"""Figures and reports. Needs matplotlib; nothing is shown, every plot function returns a Figure."""

from raylign.viz.cost import plot_cost
from raylign.viz.photometric import (
    plot_images,
    plot_law,
    plot_patches,
    plot_points_by_error,
    plot_rounds,
)
from raylign.viz.photometric_report import photometric_report
from raylign.viz.point_cloud import plot_point_cloud
from raylign.viz.report import bundle_report
from raylign.viz.residuals import plot_residuals
from raylign.viz.sparsity import plot_sparsity
from raylign.viz.track_report import track_report
from raylign.viz.tracking import plot_alignment, plot_normalised_residuals, plot_path, plot_run
from raylign.viz.trajectory import plot_trajectory

__all__ = [
    "bundle_report",
    "photometric_report",
    "plot_alignment",
    "plot_cost",
    "plot_images",
    "plot_law",
    "plot_normalised_residuals",
    "plot_patches",
    "plot_path",
    "plot_point_cloud",
    "plot_points_by_error",
    "plot_residuals",
    "plot_rounds",
    "plot_run",
    "plot_sparsity",
    "plot_trajectory",
    "track_report",
]
