"""Write python/raylign/_core.pyi from the compiled module; with --check say whether it is current.

pybind11 puts a typed signature into each docstring; option classes list their `__fields__`. From
the two comes a stub that general generators cannot write: keyword-only constructors.
`python -m mypy.stubtest raylign._core` (make lint) then compares the stub with the module.
"""

from __future__ import annotations

import argparse
import difflib
import enum
import re
import subprocess
import sys
from collections.abc import Iterator
from pathlib import Path
from typing import Any

from raylign import _core

STUB = Path(__file__).resolve().parents[1] / "python" / "raylign" / "_core.pyi"
HEADER = '''"""Typed surface of the compiled module. scripts/make_stub.py writes it: do not edit."""

import enum
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from typing import Any, ClassVar, Self, SupportsIndex, overload

import numpy as np
from numpy.typing import ArrayLike, NDArray

__version__: str
'''

# pybind11's spelling of a type → ours. Applied in order.
TYPES = [
    (r"raylign\._core\.", ""),
    (r"typing\.Annotated\[numpy\.typing\.NDArray\[([^\]]*)\], \"[^\"]*\"\]", r"numpy.NDArray[\1]"),
    (r"typing\.Annotated\[numpy\.typing\.ArrayLike, [^\]]*\]\"\]", "ArrayLike"),
    (r"typing\.Annotated\[([^\]]*\]), \"FixedSize\(\d+\)\"\]", r"\1"),
    (r"numpy\.typing\.NDArray\[(?!numpy)[^\]]*\]", "NDArray[Any]"),
    (r"numpy\.(?:typing\.)?NDArray", "NDArray"),
    (r"numpy\.ndarray", "NDArray[Any]"),
    (r"numpy\.", "np."),
    (r"typing\.SupportsFloat \| typing\.SupportsIndex", "float"),
    (r"typing\.SupportsInt \| typing\.SupportsIndex", "int"),
    (r"collections\.abc\.|typing\.", ""),
    (r"\b(dict)\b(?!\[)", "dict[str, Any]"),
    (r"\b(list)\b(?!\[)", "list[Any]"),
    (r"\b(tuple)\b(?!\[)", "tuple[Any, ...]"),
    (r"\bCallable\b(?!\[)", "Callable[..., Any]"),
    (r"(= )<(\w+\.\w+): [^>]*>", r"\1\2"),  # default that is an enumerator
]
# What a signature in a docstring cannot say.
ITERATION_CALLBACK = "Callable[[IterationSummary], bool | None] | None"
OVERRIDES = {
    "callback: object": f"callback: {ITERATION_CALLBACK}",
    "**kwargs) -> object": "**changes: Any) -> Self",
}
SPECIAL_METHODS = {
    "__copy__": "def __copy__(self) -> Self: ...",
    "__deepcopy__": "def __deepcopy__(self, memo: dict[Any, Any], /) -> Self: ...",
    "__eq__": "def __eq__(self, other: object, /) -> bool: ...",
    "__reduce__": "def __reduce__(self) -> tuple[Any, ...]: ...",
    "__repr__": "def __repr__(self) -> str: ...",
    "__hash__": "__hash__: ClassVar[None]  # type: ignore[assignment]",
}
FORMAT_ERROR_ATTRIBUTES = ["file: str", "line: int", "field: str", "reason: str"]


def clean_type(text: str) -> str:
    """Our spelling of the types in `text`."""
    for pattern, replacement in TYPES:
        text = re.sub(pattern, replacement, text)
    for old, new in OVERRIDES.items():
        text = text.replace(old, new)
    return text


def signatures(function: Any) -> list[str]:
    """`(arguments) -> type` of each overload, from the docstring."""
    lines = (function.__doc__ or "").splitlines()
    if len(lines) > 2 and lines[1] == "Overloaded function.":
        lines = [m.group(1) for line in lines if (m := re.match(r"\d+\. (.*)", line))]
    else:
        lines = lines[:1]
    return [clean_type(line[line.index("(") :]) for line in lines]


def definitions(name: str, function: Any, *, method: bool) -> Iterator[str]:
    """`def` lines of a function or method with all its overloads."""
    static = isinstance(function, staticmethod)
    found = signatures(function.__func__ if static else function)
    for signature in found:
        if method and not static:
            signature = re.sub(r"^\((self|arg0)(: [^,)]*)?", "(self", signature)
        if len(found) > 1:
            yield "@overload"
        if static:
            yield "@staticmethod"
        yield f"def {name}{signature}: ..."


def property_type(value: property) -> str:
    """Type that the getter returns."""
    return signatures(value.fget)[0].rpartition("-> ")[2]


def properties(cls: type) -> Iterator[str]:
    """Attribute lines of a class, writable ones as annotations."""
    for name, value in vars(cls).items():
        if isinstance(value, property):
            if value.fset is not None:
                yield f"{name}: {property_type(value)}"
            else:
                yield "@property"
                yield f"def {name}(self) -> {property_type(value)}: ..."


def class_attributes(cls: type) -> Iterator[str]:
    """Constants of the class: `__fields__` of records and cameras, numbers."""
    for name, value in vars(cls).items():
        if name == "__fields__":
            yield "__fields__: ClassVar[tuple[str, ...]]"
        elif isinstance(value, int):
            yield f"{name}: ClassVar[int]"


def record_methods(cls: Any) -> Iterator[str]:
    """Constructor and replace() of an options class: every field, keywords only."""
    types = {name: property_type(vars(cls)[name]) for name in cls.__fields__}
    for name, type_ in types.items():
        value_class = getattr(_core, type_, None)
        if isinstance(value_class, enum.EnumType) or hasattr(value_class, "parse"):
            types[name] = f"{type_} | str"  # or the text that the command line takes
    arguments = ", ".join(f"{name}: {type_} = ..." for name, type_ in types.items())
    yield f"def __init__(self, *, {arguments}) -> None: ..."
    yield f"def replace(self, *, {arguments}) -> Self: ..."


def methods(cls: type, skip: set[str]) -> Iterator[str]:
    """Everything callable of a class that is not in `skip`."""
    for name, value in vars(cls).items():
        if name in skip or name.startswith("_pybind11"):
            continue
        if name in SPECIAL_METHODS:
            yield SPECIAL_METHODS[name]
        elif type(value).__name__ in (
            "instancemethod",
            "staticmethod",
            "builtin_function_or_method",
        ):
            yield from definitions(name, value, method=True)


def class_stub(cls: Any) -> str:
    """Stub of one class."""
    if issubclass(cls, enum.Enum):
        body = [f"{member.name} = {member.value!r}" for member in cls]
        base = "(enum.Enum)"
    elif issubclass(cls, Exception):
        body = FORMAT_ERROR_ATTRIBUTES if cls is _core.FormatError else []
        base = f"({', '.join(b.__name__ for b in cls.__bases__)})"
    else:
        record = hasattr(cls, "to_dict") and hasattr(cls, "__fields__")
        body = [*class_attributes(cls), *properties(cls), *(record_methods(cls) if record else ())]
        body += methods(cls, skip={"__init__", "replace"} if record else set())
        base = ""
    lines = "\n".join(f"    {line}" for line in body) or "    ..."
    return f"class {cls.__name__}{base}:\n{lines}\n"


def stub() -> str:
    """The whole stub, unformatted."""
    parts = [HEADER]
    for name, value in vars(_core).items():
        if isinstance(value, type):
            parts.append(class_stub(value))
        elif callable(value) and not name.startswith("__"):
            parts += definitions(name, value, method=False)
    return "\n".join(parts) + "\n"


def formatted(text: str) -> str:
    """`text` as `ruff format` leaves it, without unused imports."""
    ruff = Path(sys.executable).with_name("ruff")
    for command in (
        ["check", "--quiet", "--select", "F401,I", "--fix-only"],
        ["format", "--quiet"],
    ):
        text = subprocess.run(
            [ruff, *command, "--stdin-filename", STUB, "-"],
            input=text,
            capture_output=True,
            text=True,
            check=True,
        ).stdout
    return text


def main() -> int:
    """Write or check; exit status 1 when --check finds a difference."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--check", action="store_true")
    wanted = formatted(stub())
    if not parser.parse_args().check:
        STUB.write_text(wanted, encoding="utf-8")
        return 0
    present = STUB.read_text(encoding="utf-8") if STUB.exists() else ""
    if present != wanted:
        difference = difflib.unified_diff(
            present.splitlines(), wanted.splitlines(), "_core.pyi", "compiled module", lineterm=""
        )
        print("\n".join(difference), "\nrun: .venv/bin/python scripts/make_stub.py")
        return 1
    print("stub: current")
    return 0


if __name__ == "__main__":
    sys.exit(main())
