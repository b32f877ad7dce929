"""Tracking: accuracy, speed and honesty, and its peers on the same frames. Tables and JSON.

    .venv/bin/python benchmarks/track.py --peers peers/bin/python     # with Open3D
    .venv/bin/python benchmarks/track.py --only sequences speed --repeats 5
    .venv/bin/python benchmarks/track.py --only robustness --cases turn

Peers: cv2.Odometry of the OpenCV 5 wheel, in this process; Open3D in an environment of its own
(peers-tracking.txt). All get the same arrays, one thread each. --json FILE keeps the results of
the parts measured now and, of an earlier file, those of the others; so it does with single
sequences and cases.
"""

import argparse
import json
import sys
from pathlib import Path

from harness import machine
from harness.problems import ROOT
from tracking import accuracy, basin, frames, honesty, pairs, robustness, sequences, speed, tables

PICTURE = ROOT / "docs" / "images" / "tracking-basin.png"
# how often each part repeats what it measures, unless --repeats says otherwise
REPEATS = {
    "sequences": 3,
    "speed": 3,
    "accuracy": 10,
    "basin": 200,
    "map": 6,
    "pairs": 1,
    "honesty": 200,
    "robustness": 3,
}


def parse_arguments(arguments: list[str] | None = None) -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", nargs="+", choices=tuple(REPEATS), default=tuple(REPEATS))
    parser.add_argument("--repeats", type=int, help="rounds, seeds or starts; default: by part")
    parser.add_argument("--json", type=Path, help="default: no file")
    parser.add_argument("--peers", type=Path, help="interpreter with peers-tracking.txt installed")
    parser.add_argument(
        "--sequences", nargs="+", choices=frames.SEQUENCES, default=frames.SEQUENCES
    )
    parser.add_argument("--cases", nargs="+", help="robustness: by part of the name")
    return parser.parse_args(arguments)


def measure(part: str, arguments: argparse.Namespace) -> list | dict:
    repeats = arguments.repeats or REPEATS[part]
    if part == "sequences":
        return sequences.measure(list(arguments.sequences), repeats, arguments.peers)
    if part == "pairs":
        return pairs.measure()
    if part == "robustness":
        return robustness.measure(repeats, arguments.cases)
    if part == "map":
        result = basin.measure_map(repeats)
        basin.draw(result, PICTURE)
        return result
    parts = {"speed": speed, "accuracy": accuracy, "basin": basin, "honesty": honesty}
    return parts[part].measure(repeats)


def table(part: str, result: list | dict) -> str:
    if part == "map":
        lies = sum(panel["ok_but_wrong"] for panel in result["panels"])
        return f"{PICTURE.relative_to(ROOT)}: starts that end wrong with status OK: {lies}"
    return getattr(tables, part)(result)


# what tells the rows of a part that can be measured in pieces apart
ROW_KEYS = {"sequences": ("sequence",), "robustness": ("case", "mode")}


def merge(path: Path, facts: dict, results: dict) -> dict:
    """What was measured now beside what the file has of other parts, each with its machine; of a
    part measured in pieces, rows that were not measured now stay, too."""
    merged = json.loads(path.read_text()) if path.exists() else {}
    for part, result in results.items():
        earlier = merged.get(part, {}).get("result", [])
        merged[part] = {"machine": facts, "result": merge_rows(part, earlier, result)}
    return merged


def merge_rows(part: str, earlier: list | dict, now: list | dict) -> list | dict:
    if part not in ROW_KEYS:
        return now

    def key(row: dict) -> tuple:
        return tuple(row[name] for name in ROW_KEYS[part])

    measured = {key(row) for row in now}
    return [row for row in earlier if key(row) not in measured] + list(now)


def main() -> int:
    arguments = parse_arguments()
    facts = machine.facts()
    print(f"{facts['cpu']}, {facts['num_cpus']} CPUs, raylign {facts['raylign']} {facts['commit']}")
    for part in arguments.only:
        result = measure(part, arguments)
        print(f"\n## {part}\n\n{table(part, result)}", flush=True)
        if arguments.json is not None:
            arguments.json.parent.mkdir(parents=True, exist_ok=True)
            merged = merge(arguments.json, facts, {part: result})
            arguments.json.write_text(json.dumps(merged, indent=1) + "\n")
    return 0


if __name__ == "__main__":
    sys.exit(main())
