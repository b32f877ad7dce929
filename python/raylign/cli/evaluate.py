"""`raylign evaluate`: a trajectory against the truth."""

import json
from pathlib import Path
from typing import Annotated

import numpy as np
import typer
from rich.console import Console
from rich.table import Table

from raylign import trajectory
from raylign._json import jsonable
from raylign.cli._choices import AlignmentChoice, TrajectoryFormat, library_value
from raylign.cli._console import make_console, say
from raylign.cli._files import check_distinct, check_problem_target
from raylign.cli._options import choice_option
from raylign.errors import Error, OptionsError
from raylign.io import open_sequence, read_kitti_poses, read_tum_trajectory
from raylign.io._folders import read_stamps
from raylign.trajectory import Evaluation, Trajectory

AlignOpt = Annotated[
    AlignmentChoice,
    choice_option(AlignmentChoice, "--align", help="What to remove before comparing"),
]
FormatOpt = Annotated[
    TrajectoryFormat, choice_option(TrajectoryFormat, "--format", help="Format of both files")
]


def evaluate(
    estimate: Annotated[Path, typer.Argument(metavar="TRAJ", help="Estimated trajectory.")],
    truth: Annotated[
        Path, typer.Option("--truth", help="True trajectory, or the folder of a sequence with one.")
    ],
    align: AlignOpt = AlignmentChoice.SE3,
    format: FormatOpt = TrajectoryFormat.TUM,
    timestamps: Annotated[
        Path | None,
        typer.Option("--timestamps", help="KITTI's times.txt for both; default: 10 per second."),
    ] = None,
    max_difference_s: Annotated[
        float, typer.Option("--max-difference-s", help="Largest difference of paired stamps, s.")
    ] = 0.02,
    offset_s: Annotated[
        float, typer.Option("--offset-s", help="Added to the estimate's stamps, s.")
    ] = 0.0,
    interpolate: Annotated[
        bool, typer.Option("--interpolate", help="Take the truth at the estimate's times.")
    ] = False,
    short_segments: Annotated[
        bool,
        typer.Option("--short-segments", help="Scale KITTI's segments to 10-80 % of the path."),
    ] = False,
    json_path: Annotated[Path | None, typer.Option("--json", help="File for the numbers.")] = None,
    plot: Annotated[Path | None, typer.Option("--plot", help="Picture to write (.png).")] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Compare a trajectory with the truth: ATE, RPE, KITTI segments, coverage."""
    check_distinct(estimate, [json_path, plot])
    if json_path is not None:
        check_problem_target(json_path, (".json",))
    if plot is not None:
        check_problem_target(plot, (".png",))
    estimated = _read(estimate, format, timestamps)
    true = _read_truth(truth, format, timestamps)
    result = trajectory.evaluate(
        estimated,
        true,
        alignment=library_value(trajectory.Alignment, align),
        max_difference_s=max_difference_s,
        offset_s=offset_s,
        interpolate=interpolate,
        segment_lengths=None if short_segments else trajectory.KITTI_LENGTHS_M,
        segment_step=1 if short_segments else 10,
    )
    console = make_console(quiet=quiet)
    print_evaluation(console, result)
    if json_path is not None:
        text = json.dumps(jsonable(result.to_dict()), indent=2, allow_nan=False)
        json_path.write_text(text + "\n", encoding="utf-8")
        say(console, f"wrote {json_path}")
    if plot is not None:
        from raylign import viz
        from raylign.viz import style

        style.save(viz.plot_trajectory(result, title=estimate.name), plot)
        say(console, f"wrote {plot}")


def print_evaluation(console: Console, result: Evaluation) -> None:
    """Print the pairs, the table of errors, and the segments if there are any."""
    scale = f", scale {result.scale:.6g}" if result.scale != 1.0 else ""
    say(
        console,
        f"{result.num_matched} of {result.num_estimates} poses matched with {result.num_truth} "
        f"true ones; coverage {100.0 * result.coverage:.1f} %; path {result.path_length:.4g} m in "
        f"{result.duration_s:.4g} s; aligned by {result.alignment.value}{scale}",
    )
    table = Table(box=None, pad_edge=False)
    table.add_column("error")
    for name in ("rmse", "mean", "median", "max"):
        table.add_column(name, justify="right")
    rows = (
        ("ATE translation [m]", result.absolute.translation, 1.0),
        ("ATE rotation [deg]", result.absolute.rotation, 180.0 / np.pi),
        ("RPE per frame [m]", result.per_frame.translation, 1.0),
        ("RPE per frame [deg]", result.per_frame.rotation, 180.0 / np.pi),
        ("RPE per second [m]", result.per_second.translation, 1.0),
        ("RPE per second [deg]", result.per_second.rotation, 180.0 / np.pi),
    )
    for name, error, unit in rows:
        if len(error.values):
            numbers = (error.rmse, error.mean, error.median, error.max)
            table.add_row(name, *(f"{unit * number:.6f}" for number in numbers))
    console.print(table)
    if result.segments:
        console.print(_segment_table(result))


def _segment_table(result: Evaluation) -> Table:
    table = Table(box=None, pad_edge=False)
    for name in ("segment [m]", "number", "translation [%]", "rotation [deg/100 m]"):
        table.add_column(name, justify="right")
    for row in result.segments:
        table.add_row(
            f"{row.length:.4g}",
            str(row.num_segments),
            f"{100.0 * row.translation:.4f}",
            f"{np.degrees(100.0 * row.rotation):.4f}",
        )
    return table


def _read(path: Path, format: TrajectoryFormat, timestamps: Path | None) -> Trajectory:
    if format is TrajectoryFormat.KITTI:
        stamps = None if timestamps is None else read_stamps(timestamps)
        return read_kitti_poses(path, timestamps=stamps)
    if timestamps is not None:
        raise OptionsError("--timestamps is for --format kitti: TUM files have their own")
    return read_tum_trajectory(path)


def _read_truth(path: Path, format: TrajectoryFormat, timestamps: Path | None) -> Trajectory:
    if not path.is_dir():
        return _read(path, format, timestamps)
    truth = open_sequence(path).truth
    if truth is None:
        raise Error(f"{path}: the sequence has no true trajectory")
    return truth
