"""The systems: how each is started on a problem, in a process of its own."""

import json
import os
import subprocess
import sys
import tempfile
from dataclasses import dataclass
from pathlib import Path

import raylign
from harness import colmap_model, judge
from harness.problems import CACHE, Spec, cached, find_file

WORKERS = Path(__file__).resolve().parents[1] / "workers"
STARTUP_S = 240.0  # reading, building and writing of the slowest system on the largest problem
CERES_SOLVERS = ("dense_schur", "sparse_schur", "iterative_schur", "iterative_explicit")
# Cameras up to which a solve ends while somebody waits: a dense factor of 9 · 600 unknowns takes
# seconds, beyond minutes, and so does an iteration of GTSAM beyond 250.
LIMITS = {"dense": 600, "gtsam": 250}


@dataclass(frozen=True)
class System:
    """One line of a table. `solver` is what the worker takes, `threads` how many it may use."""

    family: str
    solver: str
    threads: int

    @property
    def name(self) -> str:
        return f"{self.family} {self.solver.split(':')[-1]}"

    @property
    def key(self) -> str:
        return f"{self.name} x{self.threads}"

    def is_default(self) -> bool:
        """Part of `make bench`: every linear solver on one thread, the best ones on two."""
        if "explicit" in self.solver:
            return False
        if self.threads == 1:
            return True
        best = {"autodiff": CERES_SOLVERS[:2], "gtsam": ("multifrontal",)}
        return self.solver.split(":")[-1] in best.get(self.family, ("auto",))

    def suits(self, spec: Spec) -> bool:
        """Whether a solve ends while somebody waits."""
        return all(spec.num_cameras <= limit for word, limit in LIMITS.items() if word in self.key)


@dataclass(frozen=True)
class Tools:
    """What the workers need: the C++ program's folder, the interpreter with the peers' wheels."""

    programs: Path
    peers: Path | None


def native_solvers() -> list[str]:
    """Every linear solver of the native engine, whatever it has learnt since."""
    unwanted = (
        raylign.bundle.LinearSolverType.DENSE_NORMAL_CHOLESKY
    )  # the one without a Schur complement
    return [kind.name.lower() for kind in raylign.bundle.LinearSolverType if kind != unwanted]


def all_systems(tools: Tools) -> list[System]:
    """In the order of the tables: ours, then Ceres, then the wheels."""
    found = [System("native", "native:auto", threads) for threads in (1, 2)]
    found += [System("native", "native:parity", 1)]
    found += [System("native", f"native:{s}", 1) for s in native_solvers() if s != "auto"]
    found += [System("native", "native:iterative_schur", 2)]
    for threads in (1, 2):
        found += [System("analytic", f"ceres:{s}", threads) for s in CERES_SOLVERS]
        found += [System("autodiff", s, threads) for s in CERES_SOLVERS]
    if tools.peers is not None:
        found += [System("pycolmap", "auto", threads) for threads in (1, 2)]
        found += [System("gtsam", s, t) for t in (1, 2) for s in ("schur", "multifrontal")]
    return found


def colmap_folder(problem: str) -> Path:
    path = find_file(problem)
    assert path is not None
    return cached(
        f"{problem}.colmap",
        lambda folder: colmap_model.write_model(judge.read_problem(path), folder),
    )


def command(system: System, tools: Tools, problem: str) -> list[str]:
    path = find_file(problem)
    if system.family == "autodiff":
        return [str(tools.programs / "ceres_autodiff"), str(path)]
    if system.family == "pycolmap":
        path = colmap_folder(problem)
    worker = "raylign" if system.family in ("native", "analytic") else system.family
    interpreter = sys.executable if worker == "raylign" else str(tools.peers)
    return [interpreter, str(WORKERS / f"{worker}_worker.py"), str(path)]


def environment(system: System) -> dict[str, str]:
    """BLAS and OpenMP take the threads they are given, no more."""
    threads = str(system.threads)
    names = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS")
    return {**os.environ, **dict.fromkeys(names, threads)}


def pin(threads: int):
    """Run on that many processors only: some peers have thread pools nobody can size."""
    processors = sorted(os.sched_getaffinity(0))[:threads]
    return lambda: os.sched_setaffinity(0, processors)


def run(system: System, tools: Tools, spec: Spec, loaded: judge.Problem) -> dict:
    """One solve: what the worker says, and the judge's cost of what it left. `error` on failure."""
    record = {"system": system.key, "name": system.name, "threads": system.threads}
    with tempfile.TemporaryDirectory(dir=CACHE) as folder:
        parameters = Path(folder) / "parameters"
        try:
            record |= solve(system, tools, spec, parameters)
            record["judged_cost"] = judge.cost(loaded, *judge.read_parameters(parameters, loaded))
        except subprocess.TimeoutExpired as error:
            record["error"] = f"killed after {error.timeout:.0f} s, far over its time limit"
        except subprocess.CalledProcessError as error:
            last_line = (error.stderr.strip().splitlines() or ["no message"])[-1]
            record["error"] = f"exit status {error.returncode}: {last_line}"
        except (
            OSError,
            ValueError,
            IndexError,
        ) as error:  # no such program, no JSON, no parameters
            record["error"] = f"{type(error).__name__}: {error}"
    return record


def solve(system: System, tools: Tools, spec: Spec, parameters: Path) -> dict:
    """The worker's JSON line; its parameters are written to `parameters`."""
    arguments = {
        "--solver": system.solver,
        "--threads": system.threads,
        "--max-iterations": spec.max_iterations,
        "--function-tolerance": spec.function_tolerance,
        "--time-limit": spec.time_limit_s,
        "--parameters": parameters,
    }
    flags = [str(word) for pair in arguments.items() for word in pair]
    process = subprocess.run(
        [*command(system, tools, spec.name), *flags],
        capture_output=True,
        check=True,
        text=True,
        timeout=2.0 * spec.time_limit_s + STARTUP_S,
        env=environment(system),
        preexec_fn=pin(system.threads),
    )
    return dict(json.loads(process.stdout.splitlines()[-1]))
