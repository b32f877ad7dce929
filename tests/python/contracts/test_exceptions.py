"""The exception tree: one base, three kinds, each also the built-in that people catch."""

import copy
import pickle

import pytest

import raylign
from raylign import _core, errors

KINDS = ["OptionsError", "ShapeError", "FormatError"]


def test_exception_tree():
    assert issubclass(raylign.Error, RuntimeError)
    assert not issubclass(raylign.Error, ValueError)
    for name in KINDS:
        kind = getattr(raylign, name)
        assert issubclass(kind, raylign.Error)
        assert issubclass(kind, ValueError)
        assert kind is getattr(errors, name) is getattr(_core, name)


@pytest.mark.parametrize("name", ["Error", *KINDS])
def test_exceptions_say_where_they_live_and_pickle(name: str):
    kind = getattr(raylign, name)
    assert f"{kind.__module__}.{kind.__qualname__}" == f"raylign.errors.{name}"
    assert kind.__doc__
    error = kind("what happened")
    for clone in (pickle.loads(pickle.dumps(error)), copy.copy(error)):
        assert type(clone) is kind
        assert clone.args == error.args
