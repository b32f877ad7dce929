"""One contract for every options class: the walk finds them, nobody has to list them."""

import ast
import contextlib
import copy
import enum
import math
import os
import pickle
import subprocess
import sys
from pathlib import Path
from typing import Any

import pytest

import raylign
from raylign import _core

ROOT = Path(__file__).resolve().parents[3]
# A class without a meaningful default: what its constructor needs at least.
REQUIRED: dict[str, dict[str, Any]] = {"ConstantCoordinate": {"coordinate": "f"}}


def record_classes() -> list[type]:
    """Everything made by OptionsBinder: options, configs, summaries; not the immutable cameras."""
    classes = [c for c in vars(_core).values() if isinstance(c, type)]
    return [c for c in classes if hasattr(c, "__fields__") and hasattr(c, "to_dict")]


def option_classes() -> list[type]:
    """Records that users fill in; summaries are filled in by solvers and take any value."""
    return [c for c in record_classes() if not c.__name__.endswith(("Summary", "Statistics"))]


def make(cls: type) -> Any:
    return cls(**REQUIRED.get(cls.__name__, {}))


def another(value: Any) -> Any:
    """A valid value of the same kind that is not `value`; NotImplemented when none is known."""
    match value:
        case bool():
            return not value
        case enum.Enum():
            return next((m for m in type(value) if m is not value), NotImplemented)
        case int():
            return value + 1
        case float():
            return 1.0 if math.isinf(value) else value * 0.5 if value else 0.25
        case _ if hasattr(value, "__fields__"):
            return changed(value)
    return NotImplemented


def changed(options: Any) -> Any:
    """`options` with the first field that can be changed changed."""
    for name in options.__fields__:
        value = another(getattr(options, name))
        with contextlib.suppress(raylign.OptionsError):  # two fields may belong together
            if value is not NotImplemented:
                return options.replace(**{name: value})
    raise AssertionError(f"{options!r} has no field that this test can change")


each_record = pytest.mark.parametrize("cls", record_classes(), ids=lambda c: c.__name__)
each_option = pytest.mark.parametrize("cls", option_classes(), ids=lambda c: c.__name__)
EXPECTED = {"LmOptions", "LinearSolverOptions", "BundleOptions", "BundleConfig", "Loss"}


def test_the_walk_finds_the_options():
    assert {c.__name__ for c in option_classes()} >= EXPECTED
    assert {c.__name__ for c in record_classes()} >= EXPECTED | {"Summary", "IterationSummary"}


@each_record
def test_every_options_class_keeps_the_contract(cls: type):
    default, other = make(cls), changed(make(cls))
    assert default == make(cls)
    assert other != default
    assert default != object()
    assert tuple(default.to_dict()) == cls.__fields__
    assert cls(**other.to_dict()) == other
    names = {**vars(_core), "float": float}
    for options in (default, other):
        if cls is not _core.Summary:  # its repr is its one-line report
            assert eval(repr(options), names) == options
        for clone in (
            pickle.loads(pickle.dumps(options)),
            copy.copy(options),
            copy.deepcopy(options),
            options.replace(),
        ):
            assert type(clone) is cls
            assert clone == options
            assert clone is not options
    with pytest.raises(TypeError):
        cls(1)  # keywords only
    with pytest.raises(TypeError, match="no_such_option"):
        cls(no_such_option=1)
    with pytest.raises(TypeError, match="no_such_option"):
        default.replace(no_such_option=1)
    with pytest.raises(TypeError):
        hash(default)  # mutable, so not hashable


@each_record
def test_copies_are_independent(cls: type):
    original = make(cls)
    clone = copy.deepcopy(original)
    for name in cls.__fields__:
        value = another(getattr(clone, name))
        if value is not NotImplemented:
            setattr(clone, name, value)
            assert getattr(clone, name) == value
    assert original == make(cls)


@each_record
def test_fields_are_documented(cls: type):
    assert cls.__doc__
    for name in cls.__fields__:
        assert getattr(cls, name).__doc__, f"{cls.__name__}.{name}"


@each_option
def test_no_float_option_takes_nan(cls: type):
    for name, value in make(cls).to_dict().items():
        if isinstance(value, float):
            with pytest.raises(raylign.OptionsError, match=name):
                make(cls).replace(**{name: math.nan})


@each_record
def test_wrong_types_are_refused(cls: type):
    for name in cls.__fields__:
        with pytest.raises(raylign.OptionsError, match=rf"{cls.__name__}\.{name} must be like"):
            make(cls).replace(**{name: object()})


def stub_classes() -> dict[str, ast.ClassDef]:
    source = (ROOT / "python" / "raylign" / "_core.pyi").read_text(encoding="utf-8")
    return {n.name: n for n in ast.parse(source).body if isinstance(n, ast.ClassDef)}


@each_record
def test_stub_lists_every_option_field(cls: type):
    """The stub names the fields in order, and its constructor takes them as keywords only."""
    node = stub_classes()[cls.__name__]
    annotated = [
        n.target.id
        for n in node.body
        if isinstance(n, ast.AnnAssign) and isinstance(n.target, ast.Name)
    ]
    assert tuple(n for n in annotated if not n.startswith("__")) == cls.__fields__
    (init,) = [n for n in node.body if isinstance(n, ast.FunctionDef) and n.name == "__init__"]
    assert [a.arg for a in init.args.args] == ["self"]
    assert tuple(a.arg for a in init.args.kwonlyargs) == cls.__fields__


@pytest.mark.slow
def test_stub_agrees_with_the_module(tmp_path: Path):
    """mypy.stubtest: every name and kind of argument in the stub is in the module and back."""
    pytest.importorskip("mypy.stubtest")
    parent = Path(raylign.__file__).parents[1]
    search = "" if parent.name == "site-packages" else str(parent)  # mypy looks there by itself
    allowlist = ROOT / "scripts" / "stubtest_allowlist.txt"
    result = subprocess.run(
        [sys.executable, "-m", "mypy.stubtest", "raylign._core", "--allowlist", str(allowlist)],
        capture_output=True,
        text=True,
        check=False,
        cwd=tmp_path,  # no pyproject.toml here: the stub beside the module is the one compared
        env=os.environ | {"MYPYPATH": search, "PYTHONPATH": search},  # also where that was relative
    )
    assert result.returncode == 0, result.stdout
