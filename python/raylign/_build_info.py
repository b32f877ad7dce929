"""What this installation is made of and what it runs on."""

import os
import platform
import sys
from importlib import metadata
from typing import Any

import numpy as np

from raylign import _core


def build_info() -> dict[str, Any]:
    """Return versions, build flags, BLAS, CPU features and threads; no paths, no host names.

    Example:
        >>> build_info()["raylign"] == _core.__version__
        True
    """
    info: dict[str, Any] = {
        "raylign": _core.__version__,
        "python": platform.python_version(),
        "numpy": np.__version__,
        "opencv_wheel": _opencv_wheel(),
    }
    info.update(_core.build_info())
    info["system"] = platform.system()
    info["machine"] = platform.machine()
    info["cpu"] = _cpu_model()
    info["usable_cpus"] = _usable_cpus()
    return info


def _opencv_wheel() -> str | None:
    # The package's metadata, so that the (slow) import is not needed to name its version.
    for name in ("opencv-python-headless", "opencv-python", "opencv-contrib-python-headless"):
        try:
            return metadata.version(name)
        except metadata.PackageNotFoundError:
            continue
    return None


def _cpu_model() -> str:
    if sys.platform == "linux":
        with open("/proc/cpuinfo", encoding="utf-8") as stream:  # noqa: PTH123
            for line in stream:
                if line.startswith("model name"):
                    return line.partition(":")[2].strip()
    return platform.processor()


def _usable_cpus() -> int:
    affinity = getattr(os, "sched_getaffinity", None)
    return len(affinity(0)) if affinity is not None else (os.cpu_count() or 1)
