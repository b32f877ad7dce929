"""`raylign track`: the path of an RGB-D camera through a sequence."""

import contextlib
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console
from rich.progress import BarColumn, MofNCompleteColumn, Progress, TextColumn, TimeElapsedColumn

from raylign import io, odometry
from raylign.cli import _options as opt
from raylign.cli._console import make_console, say
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import check_report_target
from raylign.errors import Error, OptionsError
from raylign.odometry import OdometryOptions, OdometryResult, OdometryRun, OdometryStatus
from raylign.robust import Loss
from raylign.trajectory import Evaluation, evaluate

_DEFAULT = OdometryOptions()


@dataclass(frozen=True)
class Selection:
    """Which frames of a sequence are tracked."""

    start: int
    stop: int | None
    step: int


def track(
    sequence: Annotated[Path, typer.Argument(help="Folder of the sequence.")],
    output: Annotated[
        Path, typer.Option("--output", "-o", help="Folder for trajectory, log and report.")
    ],
    format: Annotated[
        str, typer.Option("--format", help="tum, icl_nuim, seven_scenes, euroc, stereo, folder.")
    ] = "auto",
    start: Annotated[int, typer.Option(min=0, help="First frame.")] = 0,
    stop: Annotated[int | None, typer.Option(min=1, help="Frame after the last one.")] = None,
    step: Annotated[int, typer.Option(min=1, help="Take every step-th frame.")] = 1,
    time_offset: Annotated[
        float | None,
        typer.Option(help="Depth stamp - image stamp, s; default: estimated where stamps differ."),
    ] = None,
    depth_scale: Annotated[
        float | None, typer.Option(help="Units per m of the depth images; default: the format's.")
    ] = None,
    photometric: Annotated[
        bool, typer.Option("--photometric", help="Without the depth residual.")
    ] = False,
    loss: opt.LossOpt = "huber:1.5",
    max_points: Annotated[
        int, typer.Option(min=0, help="Budget of points per level; 0: no limit.")
    ] = _DEFAULT.keyframe.max_points,
    num_threads: opt.NumThreadsOpt = _DEFAULT.tracking.lm.num_threads,
    report: Annotated[bool, typer.Option(help="Draw the report.")] = True,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Track an RGB-D sequence by direct image alignment.

    Writes trajectory.txt (TUM format), keyframes.ply (coloured points), frames.jsonl (one line per
    frame), summary.json and, with a report, pictures and index.html into the output folder. Where
    the sequence has a truth, the errors too. Ctrl-C keeps what is there.
    """
    check_report_target(output)
    console = make_console(quiet=quiet)
    options = make_options(photometric, loss, max_points, num_threads)
    source = open_frames(sequence, format, time_offset, depth_scale, Selection(start, stop, step))
    say_source(console, source)
    output.mkdir(parents=True, exist_ok=True)
    run = follow(source, options, output, console)
    if len(run.trajectory) == 0:
        raise Error(f"no frame of {source.name} was tracked: {run.results[-1].reason}")
    errors = compare(run, source)
    write_outputs(run, source, errors, options, output, report, console)
    say_result(console, run, errors)
    say(console, f"wrote {output}")
    if run.was_interrupted:
        say(console, "stopped by Ctrl-C: the frames so far are kept", style="yellow")
        raise typer.Exit(EXIT_INTERRUPTED)


def make_options(
    photometric: bool, loss: str, max_points: int, num_threads: int
) -> OdometryOptions:
    """The defaults with what the command line changes."""
    tracking = _DEFAULT.tracking
    return _DEFAULT.replace(
        tracking=tracking.replace(
            loss=Loss.parse(loss),
            depth=tracking.depth.replace(enabled=not photometric),
            lm=tracking.lm.replace(num_threads=num_threads),
        ),
        keyframe=_DEFAULT.keyframe.replace(max_points=max_points),
    )


def open_frames(
    folder: Path,
    format: str,
    time_offset: float | None,
    depth_scale: float | None,
    selection: Selection,
) -> io.RgbdSequence:
    """Open a sequence and cut it.

    Raises:
        FormatError: it is no sequence of that format.
        OptionsError: no frame is selected, or there is no depth.
    """
    given = {"time_offset_s": time_offset, "depth_scale": depth_scale}
    reader_options = {name: value for name, value in given.items() if value is not None}
    try:
        source = io.open_sequence(folder, format=format, **reader_options)
    except TypeError:
        names = " and ".join(
            "--" + name.removesuffix("_s").replace("_", "-") for name in reader_options
        )
        raise OptionsError(f"{folder}: {names} is not for this format") from None
    chosen = source[selection.start : selection.stop : selection.step]
    if len(chosen) == 0:
        raise OptionsError(f"{source.name} has {len(source)} frames: none is selected")
    if not chosen.has_depth:
        raise OptionsError(f"{source.name} has no depth images, which track needs")
    return chosen


def say_source(console: Console, source: io.RgbdSequence) -> None:
    """Print what was opened, and what its reader assumed."""
    say(console, f"{source.name} ({source.format}): {len(source)} frames, {source.camera}")
    for notice in source.report.notices:
        say(console, f"note: {notice}", style="yellow")


class Display:
    """Callback of a run: the log file, and a bar with frame, rate, status and keyframes."""

    def __init__(self, log: io.JsonLinesWriter, num_frames: int) -> None:
        self._log = log
        self._num_frames = num_frames
        self._bar: Progress | None = None
        self._task: Any = None
        self._num_keyframes = 0

    @contextlib.contextmanager
    def running(self, console: Console) -> Iterator["Display"]:
        """Show the bar on terminals."""
        columns = (
            TextColumn("[bold]tracking"),
            BarColumn(),
            MofNCompleteColumn(),
            TextColumn("{task.fields[rate]}"),
            TextColumn("{task.fields[status]}"),
            TextColumn("{task.fields[keyframes]} keyframes"),
            TimeElapsedColumn(),
        )
        disable = not console.is_terminal
        with Progress(*columns, console=console, transient=True, disable=disable) as bar:
            self._bar = bar
            self._task = bar.add_task(
                "track", total=self._num_frames, rate="", status="", keyframes=0
            )
            yield self

    def __call__(self, result: OdometryResult) -> None:
        """Log one frame and move the bar."""
        self._log.write(row(result))
        self._num_keyframes += result.is_keyframe
        if self._bar is None:
            return
        speed = self._bar.tasks[0].speed
        self._bar.update(
            self._task,
            advance=1,
            rate="" if speed is None else f"{speed:.0f} frames/s",
            status=result.status.name.lower(),
            keyframes=self._num_keyframes,
        )


def row(result: OdometryResult) -> dict[str, Any]:
    """One line of frames.jsonl."""
    alignment = result.alignment
    return {
        "frame": result.frame,
        "timestamp": result.timestamp,
        "status": result.status,
        "reason": result.reason,
        "T_wc": result.T_wc,
        "keyframe": result.keyframe,
        "is_keyframe": result.is_keyframe,
        "num_alignments": result.num_alignments,
        "readout_s": result.readout_s,
        "alignment_status": alignment.status,
        "num_points": alignment.num_points,
        "overlap": alignment.overlap,
        "usage": alignment.usage,
        "good_ratio": alignment.good_ratio,
        "agreement": alignment.agreement,
        "residual_variance": alignment.residual_variance,
        "depth_residual_variance": alignment.depth_residual_variance,
        "a": alignment.a,
        "b": alignment.b,
        "information_eigenvalues": alignment.information_eigenvalues,
        "covariance": alignment.covariance,
        "evaluations": {level.level: level.num_evaluations for level in alignment.levels},
    }


def follow(
    source: io.RgbdSequence, options: OdometryOptions, output: Path, console: Console
) -> OdometryRun:
    """Run the odometry, one log line per frame."""
    with io.JsonLinesWriter(output / "frames.jsonl") as log:
        display = Display(log, len(source))
        with display.running(console):
            return odometry.run(source, source.camera, options=options, callback=display)


def compare(run: OdometryRun, source: io.RgbdSequence) -> Evaluation | None:
    """Errors against the truth; None where there is none to compare with."""
    if source.truth is None or len(run.trajectory) < 3:
        return None
    try:
        return evaluate(run.trajectory, source.truth, interpolate=True)
    except Error:
        return None  # a path that determines no alignment, or a truth of another time


def write_outputs(
    run: OdometryRun,
    source: io.RgbdSequence,
    errors: Evaluation | None,
    options: OdometryOptions,
    output: Path,
    report: bool,
    console: Console,
) -> None:
    """Everything but the log, which is there already; the trajectory first."""
    io.write_tum_trajectory(run.trajectory, output / "trajectory.txt")
    from raylign.viz import track_report  # matplotlib: only now

    with console.status("writing"):
        track_report(run, source, output, errors=errors, options=options, pictures=report)


def say_result(console: Console, run: OdometryRun, errors: Evaluation | None) -> None:
    """Print the summary of a run."""
    num_tracked = len(run.results) - run.num_lost
    milliseconds = 1e3 * run.times_s
    median, p95 = np.percentile(milliseconds, [50, 95])
    say(
        console,
        f"{num_tracked} of {len(run.results)} frames tracked, {len(run.keyframes)} keyframes, "
        f"{median:.2f} ms per frame (95 %: {p95:.2f})",
        style=None if run.num_lost == 0 else "yellow",
    )
    for result in run.results:
        if result.status is OdometryStatus.LOST:
            say(console, f"first lost at frame {result.frame}: {result.reason}", style="yellow")
            break
    if errors is not None:
        say(
            console,
            f"against the truth: ATE {1e3 * errors.absolute.translation.rmse:.2f} mm, RPE "
            f"{1e3 * errors.per_frame.translation.rmse:.2f} mm and "
            f"{np.degrees(errors.per_frame.rotation.rmse):.3f} deg per frame (RMS)",
        )
