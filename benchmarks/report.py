"""Write the tables of the documentation and its figures from a results file.

    .venv/bin/python benchmarks/report.py benchmarks/results/2026-11-23.json

Whatever stands between `<!-- begin NAME -->` and `<!-- end NAME -->` in README.md and
docs/benchmarks*.md is replaced by the text NAME; prose around it is written by hand.
"""

import argparse
import functools
import json
import re
import statistics
from collections.abc import Callable
from pathlib import Path

from harness import contest as contests
from harness import micro, plots, series, tables
from harness.problems import ROOT

DOCUMENTS = [
    ROOT / name for name in ("README.md", "docs/benchmarks.md", "docs/benchmarks-roofline.md")
]
README_PROBLEMS = (
    "ladybug-49-front",
    "trafalgar-21",
    "street-250-65000",
    "orbit-1000-300000",
    "street-1778-1000000",
    "orbit-1778-1000000",
)
IMAGES = ROOT / "docs" / "images"
BLOCK = re.compile(r"(<!-- begin (\S+) -->\n).*?(<!-- end \2 -->)", re.DOTALL)


def markdown(header: list[str], rows: list[list[str]]) -> str:
    lines = ["| " + " | ".join(header) + " |", "|---|" + "---:|" * (len(header) - 1)]
    return "\n".join([*lines, *("| " + " | ".join(row) + " |" for row in rows)])


def has_peers(contest: dict, threads: int) -> bool:
    return any(series.rows_of(contest, family, threads) for family in series.PEERS)


def headline_table(held: list[dict], threads: int) -> str:
    """Time to 0.1 % above the best cost, and ratios of each peer's best variant to ours."""
    held = [c for c in held if has_peers(c, threads) and series.native(c, threads) is not None]
    families = [f for f in series.PEERS if any(series.rows_of(c, f, threads) for c in held)]
    if not held:
        return "No peer was run on so many threads."
    header = ["problem", "raylign native, s", *(series.label(held, f) for f in families)]
    rows = [
        [
            contest["problem"],
            tables.seconds(series.native(contest, threads)["times_to"][-1]),
            *(headline_cell(contest, family, threads) for family in families),
        ]
        for contest in held
    ]
    return with_star(markdown(header, rows))


def with_star(table: str) -> str:
    """The table, and what its stars mean where it has one."""
    return table + (STAR if "\\*" in table else "")


def readme_table(held: list[dict]) -> str:
    """Seconds of the native engine, and how many times longer each peer's best variant takes."""
    chosen = [c for c in held if c["problem"] in README_PROBLEMS and has_peers(c, 1)]
    families = [f for f in series.PEERS if any(series.rows_of(c, f, 1) for c in chosen)]
    header = ["", "native, s", "MB", *(series.label(held, family) for family in families)]
    rows = []
    for contest in chosen:
        ours = series.native(contest, 1)
        if ours is None:
            continue
        name = contest["problem"].split("-")[0]
        size = f"{contest['num_cameras']} cameras, {contest['num_observations']} observations"
        row = [f"{name}, {size}", tables.seconds(ours["times_to"][-1])]
        row.append(f"{ours['memory_bytes'] / 1e6:.0f}")
        for family in families:
            found = series.compare(contest, family, 1)
            if found is None:
                why = series.why_never(contest, family, 1)
                row.append("" if why == series.NOT_RUN else why)
            else:
                row.append(tables.times(found.time) + " ×" + "\\*" * found.counts_otherwise)
        rows.append(row)
    return with_star(markdown(header, rows))


STAR = "\n\n\\* by its own cost, without what lies behind a camera; never by the judge's."


def headline_cell(contest: dict, family: str, threads: int) -> str:
    """`time / iteration / memory` of the best variant, or why there is none."""
    found = series.compare(contest, family, threads)
    if found is None:
        return series.why_never(contest, family, threads)
    ratios = (found.time, found.iteration, found.memory)
    star = "\\*" if found.counts_otherwise else ""
    return " / ".join(tables.times(value) or "–" for value in ratios) + star


def contest_sections(held: list[dict]) -> str:
    """Every contest with a peer: a heading, what the problem is, all systems."""
    return "\n\n".join(
        f"### {contest['problem']}\n\n{tables.facts(contest)}\n\n{tables.markdown_table(contest)}"
        for contest in held
        if len({series.family_of(row) for row in contest["rows"]}) > 1
    )


def native_table(held: list[dict]) -> str:
    header = ["problem", "observations", "linear solver", "preprocess, ns/obs"]
    header += ["iteration, ns/obs", "two threads", "B/obs", "final cost to best"]
    rows = []
    for contest in held:
        one, two = (series.native(contest, threads) for threads in (1, 2))
        if one is None:
            continue
        n = contest["num_observations"]
        rate = "ns_per_observation_and_iteration"
        rows.append(
            [
                contest["problem"],
                str(n),
                one["linear_solver"].split(":")[0],
                f"{1e9 * one['preprocess_s'] / n:.0f}",
                f"{one[rate]:.0f}",
                "" if two is None else f"{one[rate] / two[rate]:.2f}x",
                f"{one['memory_bytes_per_observation']:.0f}",
                f"{one['excess']:+.0e}",
            ]
        )
    return markdown(header, rows)


def growth_table(held: list[dict]) -> str:
    header = ["scene", "threads", "from", "to", "time per iteration grows as"]
    rows = []
    for kind, name in plots.KINDS.items():
        for threads in (1, 2):
            pairs = series.seconds_per_iteration(held, kind, threads)
            pairs = pairs[pairs[:, 0] >= 30_000]
            if len(pairs) >= 2:
                exponent = f"N^{series.growth_exponent(pairs):.2f}"
                ends = [f"{pairs[0, 0]:.0f}", f"{pairs[-1, 0]:.0f}"]
                rows.append([name, str(threads), *ends, exponent])
    return markdown(header, rows)


def jacobians_table(groups: list[dict]) -> str:
    """Residuals and Jacobians through Ceres, ns per observation, medians."""
    header = [
        "problem",
        "Ceres autodiff",
        "raylign `se3`",
        "ratio",
        "raylign `angle_axis`",
        "ratio",
    ]
    columns = (("ceres_autodiff", "angle_axis"), ("raylign_ceres", "se3"))
    columns += (("raylign_ceres", "angle_axis"),)
    rows = []
    for group in groups:
        row = [group["problem"].split(".")[0]]
        for system, pose in columns:
            numbers = micro.values(group["rows"], system, pose, "jacobian_ns_per_observation")
            row.append(f"{statistics.median(numbers):.0f}")
            if system == "raylign_ceres":
                row.append(f"{group['ratios'][pose]:.2f}")
        rows.append(row)
    return markdown(header, rows)


def reading_table(rows: list[dict]) -> str:
    header = ["problem", "MB of text", "read, MB/s", "write, MB/s"]
    return markdown(
        header,
        [
            [row["problem"].split(".")[0], f"{row['megabytes']:.1f}"]
            + [f"{row['megabytes_per_s'][way]:.0f}" for way in ("read", "write")]
            for row in rows
        ],
    )


def reference_table(loops: dict) -> str:
    header = ["loop", "1 thread", "2 threads", "gain"]
    memory, arithmetic = loops["triad_gb_per_s"], loops["multiply_add_gflop_per_s"]
    rows = [
        ["triad `a = b + s c`, 0.8 GB", *(f"{v:.1f} GB/s" for v in memory)],
        ["multiply-add in registers", *(f"{v:.0f} GFLOP/s" for v in arithmetic)],
    ]
    gains = (loops["triad_scaling"], loops["multiply_add_scaling"])
    return markdown(header, [[*r, f"{g:.2f}x"] for r, g in zip(rows, gains, strict=True)])


def roofline_table(runs: list[dict], loops: dict) -> str:
    """Each stage beside the longer of its two bounds: what memory and arithmetic allow."""
    header = ["problem", "threads", "stage", "ns/obs", "B/obs", "flop/obs"]
    header += ["memory bound, ns", "arithmetic bound, ns", "share of the bound"]
    rows = []
    for run in runs:
        threads = run["threads"]
        bandwidth = loops["triad_gb_per_s"][threads - 1]
        arithmetic = loops["multiply_add_gflop_per_s"][threads - 1]
        for stage in run["stages"]:
            if "ns_per_observation" not in stage:
                continue
            ns = stage["ns_per_observation"]
            row = [run["problem"], str(threads), stage["stage"].replace("_", " ")]
            row.append(f"{ns:.1f}" if ns > 0.0 else "–")  # a difference of times, lost in noise
            if stage["bytes_per_observation"] > 0.0 and ns > 0.0:
                memory_ns = stage["bytes_per_observation"] / bandwidth
                flop_ns = stage["flops_per_observation"] / arithmetic
                row += [f"{stage['bytes_per_observation']:.0f}"]
                row += [f"{stage['flops_per_observation']:.0f}"]
                row += [f"{memory_ns:.1f}", f"{flop_ns:.1f}"]
                row += [f"{100.0 * max(memory_ns, flop_ns) / ns:.0f} %"]
            rows.append(row + [""] * (len(header) - len(row)))
    return markdown(header, rows)


def rendering_table(measured: dict[str, dict[str, float]]) -> str:
    """ms per frame by scene and mode; what noise and depth camera add."""
    scenes = {name: row for name, row in measured.items() if name != "sensor"}
    modes = list(next(iter(scenes.values())))
    rows = [
        [name.replace("_", " "), *(f"{row[mode]:.0f}" for mode in modes)]
        for name, row in scenes.items()
    ]
    sensor = measured["sensor"]
    return markdown(["scene", *modes], rows) + (
        f"\n\nSensor noise adds {sensor['noise']:.1f} ms, the depth camera "
        f"{sensor['depth camera']:.0f} ms."
    )


def guard_line(ratios: dict[str, float]) -> str:
    parts = ", ".join(f"{ratio:.1f} times in {name}" for name, ratio in ratios.items())
    return f"How much faster than Ceres the native engines were when this was measured: {parts}."


def import_line(seconds: dict) -> str:
    return (
        f"`import raylign`: {seconds['raylign']:.2f} s in a fresh interpreter (median of 5, warm), "
        f"of which NumPy {seconds['numpy'] - seconds['python']:.2f} s."
    )


def machine_line(machine: dict, held: list[dict]) -> str:
    """The machine; the commits of the contests where they are not all of one."""
    by_commit: dict[str, list[str]] = {}
    for contest in held:
        for entry in contest.get("measured", []):
            by_commit.setdefault(entry["commit"], []).append(contest["problem"])
    line = (
        f"{machine['cpu']}, {machine['num_cpus']} CPUs, {machine['memory_gib']} GiB, "
        f"{machine['system']}, Python {machine['python']}, raylign {machine['raylign']} at commit "
        f"{machine['commit']}, {machine['date'][:10]}."
    )
    if set(by_commit) - {machine["commit"]}:
        line += " The tables of the contests name theirs."
    return line


def blocks(data: dict, source: Path) -> dict[str, Callable[[], str]]:
    """Name of a block to what makes its text."""
    results = data["results"]
    held = [contests.summarize(contest) for contest in results.get("contests", [])]
    made: dict[str, Callable[[], str]] = {
        "source": lambda: f"`benchmarks/results/{source.name}`",
        "readme": lambda: readme_table(held),
        "machine": lambda: machine_line(data["machine"], held),
        "headline-1": lambda: headline_table(held, 1),
        "headline-2": lambda: headline_table(held, 2),
        "native": lambda: native_table(held),
        "growth": lambda: growth_table(held),
        "contests": lambda: contest_sections(held),
    }
    for name, writer in {
        "jacobians": jacobians_table,
        "reading": reading_table,
        "reference_loops": reference_table,
        "import": import_line,
        "rendering": rendering_table,
        "guard": guard_line,
    }.items():
        if name in results:
            made[name] = functools.partial(writer, results[name])
    if "stages" in results:
        made["roofline"] = functools.partial(
            roofline_table, results["stages"], results["reference_loops"]
        )
    return made


def rewrite(text: str, made: dict[str, Callable[[], str]]) -> str:
    """The document with every known block replaced; unknown ones stay as they are."""

    def replace(match: re.Match[str]) -> str:
        name = match[2]
        return f"{match[1]}{made[name]()}\n{match[3]}" if name in made else match[0]

    return BLOCK.sub(replace, text)


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("results", type=Path)
    source = parser.parse_args().results
    data = json.loads(source.read_text())
    made = blocks(data, source)
    for document in DOCUMENTS:
        document.write_text(rewrite(document.read_text(), made))
    held = [contests.summarize(contest) for contest in data["results"].get("contests", [])]
    for path in plots.save_all(held, IMAGES):
        print(path.relative_to(ROOT))


if __name__ == "__main__":
    main()
