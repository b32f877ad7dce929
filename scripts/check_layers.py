"""Check the layer rule: who may include and link whom.

The rule is the table of docs/conventions.md (section "Layers") and nothing else. A module may
include the headers of the modules in its row and of theirs (the transitive closure), and its CMake
target links exactly its row. Third-party headers appear only where the second table allows them.
"""

from __future__ import annotations

import re
import sys
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]', re.MULTILINE)
TABLE_ROW = re.compile(r"^\| `([\w.]+)` \|(.*)\|$", re.MULTILINE)
ADD_MODULE = re.compile(r"raylign_add_module\((\w+)(.*?)\)", re.DOTALL)
SOURCE_SUFFIXES = {".h", ".cpp"}


def section(document: str, title: str) -> str:
    """Text of one `## title` section of a Markdown document."""
    match = re.search(
        rf"^## {re.escape(title)}\n(.*?)(?=^## |\Z)", document, re.DOTALL | re.MULTILINE
    )
    if match is None:
        raise SystemExit(f"docs/conventions.md has no section '## {title}'")
    return match.group(1)


def read_table(document: str, title: str) -> dict[str, set[str]]:
    """Rows `| `name` | `a` `b` |` of a section as name → {a, b}."""
    rows = TABLE_ROW.findall(section(document, title))
    return {name: set(re.findall(r"`([\w./*]+)`", cell)) for name, cell in rows}


def closure(layers: dict[str, set[str]], module: str) -> set[str]:
    """`module` and everything it may include, directly or not."""
    seen: set[str] = set()
    todo = [module]
    while todo:
        current = todo.pop()
        if current not in seen:
            seen.add(current)
            todo.extend(layers[current])
    return seen


def find_cycle(layers: dict[str, set[str]]) -> list[str]:
    """Modules that can reach themselves through others."""
    return [m for m in layers if any(m in closure(layers, dependency) for dependency in layers[m])]


def check_includes(
    root: Path, layers: dict[str, set[str]], third_party: dict[str, set[str]]
) -> list[str]:
    """Messages for every include that the tables do not allow."""
    errors = []
    for path in sorted((root / "cpp" / "raylign").rglob("*")):
        if path.suffix not in SOURCE_SUFFIXES:
            continue
        name = path.relative_to(root / "cpp" / "raylign").as_posix()
        module = name.split("/")[0]
        if module not in layers:
            errors.append(f"cpp/raylign/{name}: folder '{module}' has no row in the layer table")
            continue
        allowed = closure(layers, module)
        for included in INCLUDE.findall(path.read_text(encoding="utf-8")):
            message = check_include(name, module, included, allowed, third_party)
            if message:
                errors.append(f"cpp/raylign/{name}: {message}")
    return errors


def check_include(
    name: str, module: str, included: str, allowed: set[str], third_party: dict[str, set[str]]
) -> str:
    """Why this one include is wrong, or an empty string."""
    if included.startswith("raylign/"):
        target = included.split("/")[1]
        return "" if target in allowed else f"may not include {included}"
    for prefix, places in third_party.items():
        if included == prefix or included.startswith(f"{prefix}/"):
            suffix = Path(name).suffix
            if not places & {module, f"{module}/*{suffix}"}:
                return f"may not include <{included}>: only {', '.join(sorted(places))} may"
    return ""


def check_links(root: Path, layers: dict[str, set[str]]) -> list[str]:
    """Messages for every CMake target whose links are not exactly its row."""
    errors = []
    seen = set()
    for path in sorted((root / "cpp" / "raylign").glob("*/CMakeLists.txt")):
        for module, arguments in ADD_MODULE.findall(path.read_text(encoding="utf-8")):
            seen.add(module)
            linked = set(re.findall(r"\braylign_(\w+)", arguments))
            row = layers.get(module, set())
            if linked != row:
                name = path.relative_to(root)
                errors.append(f"{name}: links {sorted(linked)}, the table says {sorted(row)}")
    errors += [
        f"docs/conventions.md: no target for module '{m}'" for m in sorted(set(layers) - seen)
    ]
    return errors


def check(root: Path = ROOT) -> list[str]:
    """All violations under `root`."""
    document = (root / "docs" / "conventions.md").read_text(encoding="utf-8")
    layers = read_table(document, "Layers")
    unknown = set().union(*layers.values()) - set(layers)
    if unknown:
        return [f"docs/conventions.md: layer table names unknown modules {sorted(unknown)}"]
    cycle = find_cycle(layers)
    if cycle:
        return [f"docs/conventions.md: the layer table has a cycle through {cycle}"]
    third_party = read_table(document, "Third-party headers")
    return check_includes(root, layers, third_party) + check_links(root, layers)


def main() -> int:
    """Print violations; exit status 1 when there are any."""
    errors = check()
    for error in errors:
        print(error)
    if not errors:
        print("layers: ok")
    return 1 if errors else 0


if __name__ == "__main__":
    sys.exit(main())
