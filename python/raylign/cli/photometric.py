"""`raylign photometric`: refine poses and points from grey values."""

import enum
from pathlib import Path
from typing import Annotated, Any

import numpy as np
import typer
from rich.console import Console

import raylign.photometric as library
from raylign import io
from raylign.bundle import BundleConfig, LmOptions, Termination
from raylign.camera import PinholeCamera, RadtanCamera
from raylign.cli import _choices as choices
from raylign.cli import _options as opt
from raylign.cli._console import make_console, say
from raylign.cli._errors import EXIT_INTERRUPTED
from raylign.cli._files import check_report_target
from raylign.cli._options import choice_option
from raylign.cli._progress import PhotometricDisplay
from raylign.errors import Error, OptionsError
from raylign.photometric import PhotometricOptions, PhotometricResult, Problem

_LM = LmOptions()
_CALIBRATION = "calibration.yaml"
# fx, fy, cx, cy of the exercise's images, which come without a calibration file.
_EXERCISE_CAMERA = (277.34, 291.402, 312.234, 239.777)


class PresetName(enum.StrEnum):
    """raylign.photometric.preset."""

    DEFAULT = "default"
    EXERCISE = "exercise"


class WarpChoice(enum.StrEnum):
    """raylign.photometric.PatchWarp."""

    AUTO = "auto"
    NONE = "none"
    DEPTH = "depth"
    NORMAL = "normal"


class BrightnessChoice(enum.StrEnum):
    """raylign.photometric.BrightnessModel."""

    AFFINE = "affine"
    GAIN = "gain"
    NONE = "none"


class LawChoice(enum.StrEnum):
    """raylign.LossType, those that residuals of grey values can have."""

    STUDENT_T = "student_t"
    HUBER = "huber"
    CAUCHY = "cauchy"
    TRIVIAL = "trivial"


class CovarianceChoice(enum.StrEnum):
    """raylign.photometric.CovarianceScope."""

    NONE = "none"
    POSES = "poses"
    ALL = "all"


def photometric(
    context: typer.Context,
    folder: Annotated[
        Path, typer.Argument(help="Folder with poses.txt (T_cw), points.txt and one image a pose.")
    ],
    output: Annotated[Path, typer.Option("--output", "-o", help="Folder for result and report.")],
    preset: Annotated[
        PresetName, choice_option(PresetName, "--preset", help="Settings to start from")
    ] = PresetName.DEFAULT,
    camera: Annotated[
        str | None,
        typer.Option(
            metavar="FX,FY,CX,CY",
            help="Intrinsics, px. Default: calibration.yaml of the folder; with --preset exercise "
            "and without one, 277.34,291.402,312.234,239.777.",
        ),
    ] = None,
    images: Annotated[
        str | None, typer.Option(help="Folder or pattern of the images. Default: the folder.")
    ] = None,
    row_order: Annotated[
        bool, typer.Option("--row-order", help="Patches in points.txt go by rows, not columns.")
    ] = False,
    pattern: Annotated[str, typer.Option(help="Patch: 4x4, 3x3, 5x5, spread8.")] = "4x4",
    warp: Annotated[
        WarpChoice, choice_option(WarpChoice, "--warp", help="How patches are deformed")
    ] = WarpChoice.AUTO,
    brightness: Annotated[
        BrightnessChoice,
        choice_option(BrightnessChoice, "--brightness", help="What is estimated per image"),
    ] = BrightnessChoice.AFFINE,
    loss: Annotated[
        LawChoice, choice_option(LawChoice, "--loss", help="Law of the residuals")
    ] = LawChoice.STUDENT_T,
    scale: Annotated[
        float, typer.Option(min=0.0, help="Scale of the law, grey levels; 0: estimated.")
    ] = 0.0,
    num_levels: Annotated[
        int, typer.Option(min=0, help="Pyramid levels; 0: as many as the shift needs.")
    ] = 0,
    point: Annotated[
        choices.Point, choice_option(choices.Point, "--point", help="How a point moves")
    ] = choices.Point.XYZ,
    backend: opt.BackendOpt = choices.Backend.NATIVE,
    gauge: Annotated[
        choices.GaugeChoice | None,
        choice_option(choices.GaugeChoice, "--gauge", help="Default two_cameras"),
    ] = None,
    refine_intrinsics: Annotated[
        bool, typer.Option("--refine-intrinsics", help="fx, fy, cx, cy may move.")
    ] = False,
    covariance: Annotated[
        CovarianceChoice, choice_option(CovarianceChoice, "--covariance", help="What to compute")
    ] = CovarianceChoice.POSES,
    force: Annotated[
        bool, typer.Option("--force", help="Write the result even when it is not accepted.")
    ] = False,
    max_num_iterations: opt.MaxIterationsOpt = _LM.max_num_iterations,
    max_num_rounds: Annotated[int, typer.Option(min=1, help="Rounds per level.")] = 6,
    num_threads: opt.NumThreadsOpt = _LM.num_threads,
    report: Annotated[bool, typer.Option(help="Draw the report.")] = True,
    log: Annotated[
        choices.LogStyle | None,
        choice_option(choices.LogStyle, "--log", help="Iterations; default: g2o for the exercise"),
    ] = None,
    quiet: Annotated[bool, typer.Option("--quiet", "-q", help="Print nothing but errors.")] = False,
) -> None:
    """Refine poses and points so that the images agree with the points' patches.

    Writes points.txt and poses.txt, before.ply, after.ply, summary.json and, with a report,
    pictures and index.html into the output folder. points.txt has x y z and the grey values of a
    patch per line; without grey values patches are read from the images. Exit status 1 when points
    that were held out say that the start was better; Ctrl-C keeps the best state.
    """
    check_report_target(output)
    options, config = settings(context, preset)
    problem = read_problem(folder, images, camera, preset, row_order)
    console = make_console(quiet=quiet)
    say(console, f"{folder}: {problem!r}")
    style = log or (
        choices.LogStyle.G2O if preset is PresetName.EXERCISE else choices.LogStyle.TABLE
    )
    display = PhotometricDisplay(console, style)
    with display.running():
        result = library.adjust(problem, config=config, options=options, callback=display)
    finish(result, output, console, name=folder.name, pictures=report)


def settings(
    context: typer.Context, preset: PresetName
) -> tuple[PhotometricOptions, BundleConfig | None]:
    """The preset with what the command line gives beside it."""
    options, config = library.preset(preset.value)
    given = {
        name: value
        for name, value in context.params.items()
        if (source := context.get_parameter_source(name)) and source.name == "COMMANDLINE"
    }
    nested: dict[str, dict[str, Any]] = {}
    for name, (part, field) in _FIELDS.items():
        if name in given:
            value = given[name]
            plain = value.value if isinstance(value, enum.Enum) else value
            nested.setdefault(part, {})[field] = plain
    for part, values in nested.items():
        if part:
            options = options.replace(**{part: getattr(options, part).replace(**values)})
    options = options.replace(**nested.get("", {}))
    if given.get("gauge") is not None:
        config = BundleConfig(gauge=given["gauge"].value)
    return options, config


# Option of the command line: where it goes in PhotometricOptions ("" = itself), and its name there.
_FIELDS = {
    "pattern": ("", "pattern"),
    "warp": ("", "warp"),
    "brightness": ("brightness", "model"),
    "loss": ("noise", "loss"),
    "scale": ("noise", "scale"),
    "num_levels": ("", "num_levels"),
    "point": ("", "point_parametrization"),
    "backend": ("", "backend"),
    "refine_intrinsics": ("", "refine_intrinsics"),
    "covariance": ("", "covariance"),
    "force": ("", "force"),
    "max_num_rounds": ("", "max_num_rounds"),
    "max_num_iterations": ("lm", "max_num_iterations"),
    "num_threads": ("lm", "num_threads"),
}


def read_problem(
    folder: Path, images: str | None, camera: str | None, preset: PresetName, row_order: bool
) -> Problem:
    """Read the files of a folder.

    Raises:
        FormatError: a file is missing or damaged.
        OptionsError: nothing says what the camera is.
    """
    if not folder.is_dir():
        raise NotADirectoryError(f"{folder} is not a folder")
    return Problem.from_text(
        folder / "points.txt",
        folder / "poses.txt",
        folder if images is None else images,
        find_camera(folder, camera, preset),
        patch_order="row" if row_order else "column",
    )


def find_camera(folder: Path, text: str | None, preset: PresetName) -> PinholeCamera | RadtanCamera:
    """What the user says, what the folder says, what the exercise says; in this order."""
    if text is not None:
        numbers = _numbers(text)
    elif (folder / _CALIBRATION).exists():
        return io.read_calibration(folder / _CALIBRATION).camera
    elif preset is PresetName.EXERCISE:
        numbers = list(_EXERCISE_CAMERA)
    else:
        raise OptionsError(f"{folder} has no {_CALIBRATION}: give --camera FX,FY,CX,CY")
    if preset is PresetName.EXERCISE:  # which computes pixels in float32
        numbers = [float(np.float32(number)) for number in numbers]
    return PinholeCamera(*numbers)


def _numbers(text: str) -> list[float]:
    try:
        numbers = [float(token) for token in text.split(",")]
    except ValueError:
        numbers = []
    if len(numbers) != 4:
        raise OptionsError(f"--camera must be four numbers FX,FY,CX,CY, got {text!r}")
    return numbers


def finish(
    result: PhotometricResult, output: Path, console: Console, *, name: str, pictures: bool
) -> None:
    """Write everything, the state first; say how it went.

    Raises:
        Error: the solve failed; nothing is written.
        typer.Exit: not accepted, or stopped by the user.
    """
    if not result.summary.is_usable():
        raise Error(f"the solve failed, nothing was written: {result.summary.message}")
    output.mkdir(parents=True, exist_ok=True)
    result.write_text(output / "points.txt", output / "poses.txt")
    from raylign.viz import photometric_report  # matplotlib: only now

    with console.status("writing"):
        photometric_report(
            result, output, title=f"Photometric bundle adjustment of {name}", pictures=pictures
        )
    say(console, result.full_report())
    say(console, f"wrote {output}")
    if result.summary.termination is Termination.USER_STOPPED:
        say(console, "stopped by Ctrl-C: the best state so far is kept", style="yellow")
        raise typer.Exit(EXIT_INTERRUPTED)
    if not result.accepted and not result.options.force:
        raise Error(f"not accepted: {result.reason}; the start was written (--force: the result)")
