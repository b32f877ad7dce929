"""What every source file looks like, and that the version is one."""

import re
import subprocess
import sys
import tomllib
from importlib import metadata
from pathlib import Path

import pytest

import raylign
from raylign import _core

ROOT = Path(__file__).resolve().parents[3]
SPDX = (
    "// SPDX-FileCopyrightText: 2026 The raylign authors\n"
    "// SPDX-License-Identifier: BSD-3-Clause\n"
)
LEFTOVERS = re.compile(
    r"\b(" + "|".join(["TO" + "DO", "FIX" + "ME", "XX" + "X", "HA" + "CK"]) + r")\b"
)
MACHINE_PATHS = re.compile(r"(?<![\w.])/(work|home|root|tmp/build)/")
CODE_FOLDERS = [
    "cpp",
    "python",
    "tests",
    "benchmarks",
    "examples",
    "scripts",
    "cmake",
    "docs",
    ".ci",
]
CODE_SUFFIXES = {".h", ".cpp", ".py", ".pyi", ".sh", ".cmake", ".txt", ".md", ".toml", ".in", ""}


def files(root: Path, folders: list[str], suffixes: set[str]) -> list[Path]:
    found = [p for f in folders for p in sorted((root / f).rglob("*")) if p.suffix in suffixes]
    return [p for p in found if p.is_file() and "__pycache__" not in p.parts]


def test_cpp_file_headers():
    """SPDX lines everywhere; headers guard themselves and include by full path."""
    sources = files(ROOT, ["cpp", "tests", "benchmarks", "examples"], {".h", ".cpp"})
    assert len(sources) > 50
    for path in sources:
        text = path.read_text(encoding="utf-8")
        assert text.startswith(SPDX), path
        if path.suffix == ".h":
            assert "\n#pragma once\n" in text, path
            assert "using namespace" not in text, path
        if path.is_relative_to(ROOT / "cpp" / "raylign"):
            quoted = re.findall(r'^#include "([^"]+)"', text, re.MULTILINE)
            assert all(name.startswith("raylign/") for name in quoted), path


def test_no_leftover_markers():
    """No open ends, and no paths of somebody's machine."""
    sources = files(ROOT, CODE_FOLDERS, CODE_SUFFIXES)
    assert len(sources) > 80
    for path in sources:
        text = path.read_text(encoding="utf-8")
        assert not LEFTOVERS.search(text), path
        assert not MACHINE_PATHS.search(text), path


def test_library_has_no_exits_and_no_output():
    """C++ library code neither prints nor ends the process."""
    forbidden = re.compile(
        r"\bstd::(cout|cerr|clog|puts|printf|abort|exit|terminate)\b|\b(printf|puts|abort|exit)\(|"
        r"\bCHECK(_\w+)?\(|\bassert\("
    )
    for path in files(ROOT, ["cpp/raylign"], {".h", ".cpp"}):
        code = re.sub(r"//[^\n]*", "", path.read_text(encoding="utf-8"))
        match = forbidden.search(code)
        assert match is None, f"{path}: {match.group()}"


@pytest.fixture(scope="module")
def pyproject_version() -> str:
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    return table["project"]["version"]


def test_version_is_the_same_everywhere(pyproject_version: str):
    assert raylign.__version__ == _core.__version__ == pyproject_version
    assert _core.build_info()["raylign"] == pyproject_version
    citation = (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f"\nversion: {pyproject_version}\n" in citation
    changelog = (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")
    assert f"\n## {pyproject_version}" in changelog
    command = [sys.executable, "-c", "from raylign.cli import main; main()", "--version"]
    said = subprocess.run(command, check=True, capture_output=True, text=True).stdout
    assert pyproject_version in said.split()


def test_installed_version(pyproject_version: str):
    try:
        installed = metadata.version("raylign")
    except metadata.PackageNotFoundError:
        pytest.skip("raylign runs from a build folder, not installed")
    assert installed == pyproject_version


def test_clang_format_and_ruff_are_pinned():
    table = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))
    lint = table["project"]["optional-dependencies"]["lint"]
    for tool in ("ruff", "clang-format"):
        assert any(line.startswith(f"{tool}==") for line in lint), tool
