"""Photometric bundle adjustment: the native engine beside Ceres with analytic Jacobians.

    .venv/bin/python benchmarks/photometric.py --json benchmarks/results/photometric_DATE.json
    .venv/bin/python benchmarks/photometric.py --only scaling --rounds 3
    .venv/bin/python benchmarks/photometric.py --draw benchmarks/results/photometric_DATE.json

One thread, both engines in turn in one process, medians over rounds of eight iterations each.
`exercise` reads the original exercise's data (direct_ba) where they are at hand; all other scenes
are rendered. --json FILE keeps the parts measured now and, of an earlier file, the others; --draw
writes the tables and the figure of docs/benchmarks-photometric.md from such a file.
"""

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import cv2
import matplotlib as mpl
import matplotlib.pyplot as plt
import numpy as np

from harness import machine, plots
from harness.problems import ROOT, SHARED
from raylign.io import read_patch_points, read_poses
from report import BLOCK, machine_line, markdown

DOCUMENT = ROOT / "docs" / "benchmarks-photometric.md"
PICTURE = ROOT / "docs" / "images" / "photometric-scaling.png"
EXERCISE = SHARED / "direct_ba"
EXERCISE_K = (277.34, 291.402, 312.234, 239.777)

# rendered: 4118 points that all 7 images see, as many edges as the exercise has
SIZE = ("--points", "4118", "--images", "7")
VARIANTS = {
    "Huber on the patch": (),
    "Huber on the patch, normal warps": ("--warps",),
    "Student's t per pixel": ("--law", "student_t", "--engines", "native"),
    "Student's t per pixel, normal warps": (
        "--law",
        "student_t",
        "--warps",
        "--engines",
        "native",
    ),
    "inverse depth, Huber on the patch": ("--inverse-depth",),
}
LARGE = ("--points", "100000", "--images", "10", "--rounds", "1", "--iterations", "6")
SCALING_IMAGES = 10
SCALING_POINTS = (100, 300, 1_000, 3_000, 10_000, 30_000, 100_000)
CERES_UP_TO = 30_000  # points; its Jacobian of the next would take 3 GB
PARTS = ("exercise", "rendered", "large", "scaling")


def write_raw(target: Path) -> None:
    """The exercise's scene as photometric_benchmark reads it, with the real image 0."""
    points, patches = read_patch_points(EXERCISE / "points.txt", num_values=16)
    T_cw = read_poses(EXERCISE / "poses.txt").T_cw
    paths = [str(EXERCISE / f"{i}.png") for i in range(len(T_cw))]
    images = [cv2.imread(path, cv2.IMREAD_GRAYSCALE) for path in paths]
    height, width = images[0].shape
    header = (len(T_cw), len(points), width, height, *EXERCISE_K)
    with target.open("wb") as stream:
        stream.write((" ".join(map(str, header)) + "\n").encode())
        for array in (T_cw[:, :3], points, patches, np.stack(images)):
            stream.write(np.ascontiguousarray(array).tobytes())


def run(folder: Path, *flags: str) -> dict:
    output = subprocess.run(
        [folder / "photometric_benchmark", *flags], check=True, capture_output=True, text=True
    )
    return json.loads(output.stdout)


def measure_exercise(folder: Path, rounds: list[str]) -> list[dict]:
    if not EXERCISE.is_dir():
        print("exercise: no data, left out", file=sys.stderr)
        return []
    with tempfile.TemporaryDirectory() as scratch:
        raw = Path(scratch) / "exercise.raw"
        write_raw(raw)
        names = ("Huber on the patch", "Student's t per pixel")
        return [
            {"name": name, **run(folder, *VARIANTS[name], *rounds, "--raw", str(raw))}
            for name in names
        ]


def measure_rendered(folder: Path, rounds: list[str]) -> list[dict]:
    return [
        {"name": name, **run(folder, *SIZE, *flags, *rounds)} for name, flags in VARIANTS.items()
    ]


def measure_large(folder: Path, rounds: list[str]) -> list[dict]:
    laws = ("Huber on the patch", "Student's t per pixel, normal warps")
    return [
        {"name": name, **run(folder, *VARIANTS[name], "--engines", "native", *LARGE, *rounds)}
        for name in laws
    ]


def measure_scaling(folder: Path, rounds: list[str]) -> list[dict]:
    """A process for each size and engine: peak memory is the process's own."""
    rows = []
    for points in SCALING_POINTS:
        size = ("--points", str(points), "--images", str(SCALING_IMAGES))
        few = rounds or ["--rounds", "3"]
        row = run(folder, *size, "--engines", "native", *few)
        if points <= CERES_UP_TO:
            other = run(folder, *size, "--engines", "ceres", *few)
            row["ceres"] = other["ceres"]
            row["ceres_mib"] = other["peak_mib"] - other["scene_mib"]
        rows.append(row)
    return rows


def number(value: float | None, digits: int = 1) -> str:
    return "–" if value is None or value < 0.0 else f"{value:.{digits}f}"


def engine_rows(result: list[dict]) -> str:
    header = ["scene and law", "edges seen", "engine", "iteration", "best", "linearise", "solve"]
    header += ["cost-only trial", "set-up", "Ceres / native"]
    rows = []
    for run_ in result:
        for engine in ("native", "ceres"):
            if engine not in run_:
                continue
            m = run_[engine]
            cells = [run_["name"], str(run_["seen"]), engine]
            keys = ("iteration", "iteration_best", "linearize", "solve", "trial", "set_up")
            cells += [number(m[f"{key}_ms"]) for key in keys]
            both = engine == "native" and "ceres" in run_
            ratio = run_["ceres"]["iteration_ms"] / m["iteration_ms"] if both else None
            rows.append([*cells, f"{ratio:.1f}" if ratio else ""])
    return markdown(header, rows)


def scaling_rows(result: list[dict]) -> str:
    header = [
        "edges",
        "native, ms",
        "ns / edge",
        "native, MiB",
        "B / edge",
        "Ceres, ms",
        "Ceres, MiB",
    ]
    rows = []
    for run_ in result:
        edges = run_["edges"]
        ms = run_["native"]["iteration_ms"]
        ceres = run_.get("ceres")
        rows.append(
            [
                str(edges),
                number(ms, 2),
                number(1e6 * ms / edges, 0),
                number(run_["native_mib"]),
                number(2**20 * run_["native_mib"] / edges, 0),
                number(ceres["iteration_ms"] if ceres else None),
                number(run_.get("ceres_mib")),
            ]
        )
    return markdown(header, rows)


def draw_scaling(result: list[dict]) -> None:
    edges = np.array([r["edges"] for r in result], dtype=float)
    with mpl.rc_context(plots.STYLE):
        figure, panels = plt.subplots(1, 2, figsize=(9.0, 3.8), layout="constrained")
        values = (
            ("ms per LM iteration", lambda r, e: r[e]["iteration_ms"] if e in r else np.nan),
            ("MiB beside the scene", lambda r, e: r.get(f"{e}_mib", np.nan)),
        )
        for panel, (label, value) in zip(panels, values, strict=True):
            for engine, color in (("native", "native"), ("ceres", "analytic")):
                y = np.array([value(r, engine) for r in result], dtype=float)
                panel.loglog(edges, y, "o-", color=plots.COLORS[color], label=engine)
                if engine == "native":
                    panel.loglog(edges, y[-1] * edges / edges[-1], ":", color="0.6", label="linear")
            panel.set_xlabel("edges of 16 pixels")
            panel.set_ylabel(label)
        panels[0].legend()
        figure.savefig(PICTURE, bbox_inches="tight")
        plt.close(figure)


def write_document(data: dict) -> None:
    """Tables between `<!-- begin NAME -->` and `<!-- end NAME -->`, and the figure."""

    def text(name: str) -> str:
        if name.startswith("machine:"):
            return machine_line(data[name.removeprefix("machine:")]["machine"])
        rows = scaling_rows if name == "scaling" else engine_rows
        return rows(data[name]["result"])

    document = DOCUMENT.read_text()
    DOCUMENT.write_text(BLOCK.sub(lambda m: f"{m[1]}{text(m[2])}\n{m[3]}", document))
    draw_scaling(data["scaling"]["result"])


def parse_arguments() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=PARTS, default=PARTS)
    parser.add_argument("--rounds", type=int, help="default: 7, large 1, scaling 3")
    parser.add_argument("--json", type=Path, help="default: no file")
    parser.add_argument("--programs", type=Path, help="folder with photometric_benchmark, built")
    parser.add_argument("--draw", type=Path, help="measure nothing, write the document")
    return parser.parse_args()


def main() -> int:
    arguments = parse_arguments()
    if arguments.draw is not None:
        write_document(json.loads(arguments.draw.read_text()))
        return 0
    folder = arguments.programs or machine.build_programs()
    facts = machine.facts()
    print(machine_line(facts))
    rounds = ["--rounds", str(arguments.rounds)] if arguments.rounds else []
    measures = {
        "exercise": measure_exercise,
        "rendered": measure_rendered,
        "large": measure_large,
        "scaling": measure_scaling,
    }
    for part in arguments.only:
        result = measures[part](folder, rounds)
        rows = scaling_rows if part == "scaling" else engine_rows
        print(f"\n## {part}\n\n{rows(result)}", flush=True)
        if arguments.json is not None and result:
            arguments.json.parent.mkdir(parents=True, exist_ok=True)
            earlier = json.loads(arguments.json.read_text()) if arguments.json.exists() else {}
            merged = earlier | {part: {"machine": facts, "result": result}}
            arguments.json.write_text(json.dumps(merged, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
