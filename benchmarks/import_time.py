"""Seconds that `import raylign` takes: median of 5 fresh interpreters after one to warm the caches.

Usage: python benchmarks/import_time.py [--runs 5]. The bare interpreter's own start is measured the
same way and not subtracted: both are printed, and what NumPy alone takes, as JSON.
"""

import argparse
import json
import statistics
import subprocess
import sys
import time


def seconds(code: str, runs: int) -> float:
    """Median wall time of `python -c code`, one warm-up run not counted."""
    times = []
    for _ in range(runs + 1):
        start = time.perf_counter()
        subprocess.run([sys.executable, "-c", code], check=True)
        times.append(time.perf_counter() - start)
    return statistics.median(times[1:])


def measure(runs: int = 5) -> dict[str, float]:
    """Wall times in s of a bare interpreter, of one that imports NumPy, and of one with raylign."""
    statements = {"python": "pass", "numpy": "import numpy", "raylign": "import raylign"}
    return {name: round(seconds(code, runs), 4) for name, code in statements.items()}


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--runs", type=int, default=5)
    print(json.dumps(measure(parser.parse_args().runs)))


if __name__ == "__main__":
    main()
