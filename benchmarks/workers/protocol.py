"""What every worker speaks: one problem, one solver, one process; one JSON line on stdout.

The fields (times in s, memory in bytes):

    parse_s        file to the system's own containers
    build_s        containers to the solver's problem object, when that is a step of its own
    preprocess_s   inside the solve, before the first linearisation
    solve_s        the whole call, preprocessing included
    trace          [[seconds since the call, cost], ...], row 0 is the start
    baseline_bytes resident memory after the imports
    peak_bytes     largest resident memory until the solve was over
    parameters are written to --parameters as doubles: nine per camera (BAL), then three per point

Only the standard library and NumPy: the interpreter may be a peer's own.
"""

import argparse
import json
import sys
from pathlib import Path

import numpy as np


def status_bytes(field: str) -> int:
    """A line of /proc/self/status in bytes: VmRSS now, VmHWM its maximum in this process.

    getrusage would do neither: its maximum starts with what the parent held when it forked.
    """
    for line in Path("/proc/self/status").read_text().splitlines():
        if line.startswith(field + ":"):
            return 1024 * int(line.split()[1])
    raise LookupError(field)


def parse_arguments(solvers: tuple[str, ...]) -> argparse.Namespace:
    parser = argparse.ArgumentParser(description="A benchmark worker; started by benchmarks/run.py")
    parser.add_argument("problem", type=Path)
    parser.add_argument("--solver", choices=solvers, required=True)
    parser.add_argument("--threads", type=int, required=True)
    parser.add_argument("--max-iterations", type=int, required=True)
    parser.add_argument("--function-tolerance", type=float, required=True)
    parser.add_argument("--time-limit", type=float, required=True)
    parser.add_argument("--parameters", type=Path, required=True)
    return parser.parse_args()


def report(arguments: argparse.Namespace, parameters: list[np.ndarray], **fields: object) -> None:
    """Write the parameters and print the JSON line."""
    with arguments.parameters.open("wb") as file:
        for block in parameters:
            np.ascontiguousarray(block, dtype=np.float64).tofile(file)
    json.dump(fields, sys.stdout)
    sys.stdout.write("\n")
