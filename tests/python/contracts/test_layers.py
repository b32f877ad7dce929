"""The layer rule holds, and the checker would notice if it did not."""

import ast
import importlib.util
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[3]
PYTHON_LAYERS = {"facade": 1, "io": 2, "datasets": 2, "photometric": 2, "viz": 3, "cli": 4}


def load_script(name: str):
    """A module of scripts/, which is no package."""
    spec = importlib.util.spec_from_file_location(name, ROOT / "scripts" / f"{name}.py")
    module = importlib.util.module_from_spec(spec)
    spec.loader.exec_module(module)
    return module


check_layers = load_script("check_layers")


def test_layer_rule_holds():
    assert check_layers.check() == []


@pytest.fixture
def small_tree(tmp_path: Path) -> Path:
    """base ← geometry, ceres only in geometry: the smallest tree with something to violate."""
    for module, links in (("base", "Eigen3::Eigen"), ("geometry", "raylign_base")):
        folder = tmp_path / "cpp" / "raylign" / module
        folder.mkdir(parents=True)
        (folder / "CMakeLists.txt").write_text(f"raylign_add_module({module} PUBLIC {links})\n")
        (folder / f"{module}.h").write_text("#pragma once\n")
    (tmp_path / "docs").mkdir()
    (tmp_path / "docs" / "conventions.md").write_text(
        "## Layers\n\n| `base` | |\n| `geometry` | `base` |\n\n"
        "## Third-party headers\n\n| `ceres` | `geometry/*.cpp` |\n"
    )
    assert check_layers.check(tmp_path) == []
    return tmp_path


def test_upward_include_is_found(small_tree: Path):
    (small_tree / "cpp/raylign/base/base.h").write_text('#include "raylign/geometry/geometry.h"\n')
    (error,) = check_layers.check(small_tree)
    assert error.startswith("cpp/raylign/base/base.h: may not include raylign/geometry/geometry.h")


def test_third_party_header_out_of_place_is_found(small_tree: Path):
    (small_tree / "cpp/raylign/geometry/geometry.h").write_text("#include <ceres/ceres.h>\n")
    (error,) = check_layers.check(small_tree)
    assert "may not include <ceres/ceres.h>" in error
    (small_tree / "cpp/raylign/geometry/geometry.h").write_text("")
    (small_tree / "cpp/raylign/geometry/geometry.cpp").write_text("#include <ceres/ceres.h>\n")
    assert check_layers.check(small_tree) == []


@pytest.mark.parametrize("links", ["", "raylign_base raylign_geometry"])
def test_link_that_is_not_the_row_is_found(small_tree: Path, links: str):
    file = small_tree / "cpp/raylign/geometry/CMakeLists.txt"
    file.write_text(f"raylign_add_module(geometry PUBLIC {links})\n")
    (error,) = check_layers.check(small_tree)
    assert "the table says ['base']" in error


def test_folder_without_row_and_row_without_folder_are_found(small_tree: Path):
    extra = small_tree / "cpp/raylign/extra"
    extra.mkdir()
    (extra / "extra.h").write_text("")
    document = small_tree / "docs/conventions.md"
    document.write_text(document.read_text().replace("| `base` | |", "| `base` | |\n| `gone` | |"))
    errors = check_layers.check(small_tree)
    assert len(errors) == 2
    assert "folder 'extra' has no row" in errors[0]
    assert "no target for module 'gone'" in errors[1]


def test_cycle_is_found(small_tree: Path):
    document = small_tree / "docs/conventions.md"
    document.write_text(document.read_text().replace("| `base` | |", "| `base` | `geometry` |"))
    assert "cycle" in check_layers.check(small_tree)[0]


def layer_of(module: str) -> int:
    """Layer of `raylign.<first>.<…>`; private helpers and façades are the lowest above _core."""
    first = module.split(".")[1] if "." in module else ""
    return PYTHON_LAYERS.get(first, PYTHON_LAYERS["facade"])


def imported_modules(path: Path) -> set[str]:
    """Modules of raylign that a file imports anywhere, also inside functions."""
    found = set()
    for node in ast.walk(ast.parse(path.read_text(encoding="utf-8"))):
        if isinstance(node, ast.Import):
            found |= {alias.name for alias in node.names}
        elif isinstance(node, ast.ImportFrom) and node.module:
            assert node.level == 0, f"{path}: relative import"
            found |= {f"{node.module}.{alias.name}" for alias in node.names}
    return {name for name in found if name.split(".")[0] == "raylign"}


def test_python_layers_hold():
    """A façade never imports viz or cli; viz never cli. `__init__` may re-export io."""
    errors = []
    for path in sorted((ROOT / "python" / "raylign").rglob("*.py")):
        name = path.relative_to(ROOT / "python").with_suffix("").as_posix().replace("/", ".")
        limit = PYTHON_LAYERS["io"] if name == "raylign.__init__" else layer_of(name)
        errors += [f"{name} imports {m}" for m in imported_modules(path) if layer_of(m) > limit]
    assert errors == []
