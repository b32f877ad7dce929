"""Performance guard: each native engine must stay several times faster than Ceres.

    .venv/bin/python benchmarks/guard.py        # exit status 1 where one has become too slow

Ratios of time per iteration, never seconds: both engines solve the same made problem in turns in
one process, so that a slow or busy machine slows both. The bounds lie a third below what is
measured on a loaded machine; they catch an engine that lost its vector code or its layout, not a
few per cent. Not a test: whoever changes a kernel runs it before and after.
"""

import argparse
import statistics
import sys
from pathlib import Path

import raylign
from harness import machine
from photometric import SIZE, run
from raylign.bundle import Backend, BundleOptions, LmOptions

LM = LmOptions(max_num_iterations=8, function_tolerance=0.0, parameter_tolerance=0.0)


def bundle_ms(problem: raylign.BalProblem, backend: Backend) -> float:
    """Milliseconds per Levenberg-Marquardt iteration, Ceres' steps in both engines."""
    parity = backend is Backend.NATIVE
    options = BundleOptions(backend=backend, parity=parity, lm=LM)
    rows = raylign.bundle.adjust(problem, options=options).summary.iterations
    return 1e3 * statistics.median(rows["iteration_time_s"][1:])


def bundle_ratio(kind: str, rounds: int) -> float:
    """Ceres with our analytic functor against the native engine, 50 cameras, one thread."""
    problem = raylign.synthetic.bal(
        kind=kind, num_cameras=50, num_points=10_000, rotation_noise_deg=0.1
    ).problem
    ratios = [
        bundle_ms(problem, Backend.CERES) / bundle_ms(problem, Backend.NATIVE)
        for _ in range(rounds)
    ]
    return statistics.median(ratios)


def photometric_ratio(rounds: int, programs: Path) -> float:
    """Ceres with analytic 16x6 and 16x3 Jacobians against the native engine, 28 826 edges."""
    measured = run(programs, *SIZE, "--rounds", str(rounds))
    return measured["ceres"]["iteration_ms"] / measured["native"]["iteration_ms"]


LEAST = {  # a third below what is measured on a loaded machine
    "bundle adjustment of a street": 6.0,
    "bundle adjustment of an orbit": 6.0,
    "photometric bundle adjustment": 7.0,
}


def measure(rounds: int, programs: Path) -> dict[str, float]:
    """How many times as fast as Ceres each native engine is, by the names of LEAST."""
    ratios = (
        bundle_ratio("street", rounds),
        bundle_ratio("orbit", rounds),
        photometric_ratio(rounds, programs),
    )
    return dict(zip(LEAST, ratios, strict=True))


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rounds", type=int, default=5)
    ratios = measure(parser.parse_args().rounds, machine.build_programs())
    for name, least in LEAST.items():
        verdict = "ok" if ratios[name] >= least else "TOO SLOW"
        print(f"{name}: {ratios[name]:.1f} times as fast as Ceres, at least {least:g}: {verdict}")
    return 0 if all(ratios[name] >= least for name, least in LEAST.items()) else 1


if __name__ == "__main__":
    sys.exit(main())
