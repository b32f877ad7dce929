"""What a number was measured on, and the programs built to measure it."""

import os
import platform
import subprocess
from datetime import UTC, datetime
from pathlib import Path

import numpy as np

import raylign
from harness.problems import ROOT

BUILD = ROOT / "build" / "bench"
PROGRAMS = (
    "bal_benchmark",
    "ceres_autodiff",
    "native_stages",
    "photometric_benchmark",
    "reference_loops",
)


def build_programs() -> Path:
    """Configure and build the C++ benchmark programs; return their folder."""
    flags = [
        "-DRAYLIGN_BUILD_BENCHMARKS=ON",
        "-DRAYLIGN_BUILD_TESTS=OFF",
        "-DCMAKE_BUILD_TYPE=Release",
    ]
    quiet = {"check": True, "stdout": subprocess.DEVNULL}
    subprocess.run(["cmake", "-S", ROOT, "-B", BUILD, "-G", "Ninja", *flags], **quiet)
    subprocess.run(["cmake", "--build", BUILD, "--target", *PROGRAMS], **quiet)
    return BUILD / "benchmarks" / "micro"


def facts() -> dict:
    cpu = next(
        (
            line.split(":")[1].strip()
            for line in Path("/proc/cpuinfo").read_text().splitlines()
            if "model name" in line
        ),
        platform.processor(),
    )
    commit = subprocess.run(
        ["git", "rev-parse", "--short", "HEAD"], cwd=ROOT, capture_output=True, text=True
    )
    return {
        "cpu": cpu,
        "num_cpus": os.cpu_count(),
        "memory_gib": round(os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES") / 2**30, 1),
        "system": platform.platform(),
        "python": platform.python_version(),
        "numpy": np.__version__,
        "raylign": raylign.__version__,
        "commit": commit.stdout.strip() or "unknown",
        "date": datetime.now(UTC).isoformat(timespec="seconds"),
    }
