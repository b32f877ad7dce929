"""Fixtures shared by all Python tests."""

import os
from pathlib import Path

import pytest

from raylign.scene import BalProblem
from tiny_problem import make_tiny_problem


@pytest.fixture(scope="session")
def shared_data() -> Path:
    """Folder of third-party data, not part of the repository; skips where it is absent."""
    beside_checkout = Path(__file__).resolve().parents[3] / "shared" / "data"
    folder = Path(os.environ.get("RAYLIGN_DATA", beside_checkout))
    if not folder.is_dir():
        pytest.skip(f"third-party data not found: {folder} (set RAYLIGN_DATA)")
    return folder


@pytest.fixture
def tiny_problem() -> BalProblem:
    """A fresh small valid problem: 4 cameras, 20 points, all 80 observations."""
    return make_tiny_problem()
