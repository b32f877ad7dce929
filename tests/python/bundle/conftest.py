"""Fixtures of the tests of raylign.bundle: every test runs with each engine in turn."""

import numpy as np
import pytest

from bundle_cases import BACKENDS
from raylign import bundle
from raylign.bundle import BundleOptions


@pytest.fixture(params=BACKENDS, ids=lambda b: b.name)
def backend(request):
    return request.param


@pytest.fixture
def adjust(backend):
    """raylign.bundle.adjust with each engine in turn."""

    def run(problem, *, options=None, **keywords):
        options = (options or BundleOptions()).replace(backend=backend)
        return bundle.adjust(problem, options=options, **keywords)

    return run


@pytest.fixture
def perturbed(tiny_problem):
    rng = np.random.default_rng(3)
    tiny_problem.points[:] += rng.normal(0.0, 0.05, tiny_problem.points.shape)
    tiny_problem.cameras[:, :6] += rng.normal(0.0, 0.01, (4, 6))
    return tiny_problem
