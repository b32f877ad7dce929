"""Print files over 400 lines and functions over 60: a budget, not a gate (exit status 0).

Tables and tests are exempt. C++ functions are found by their formatting: clang-format puts the
closing brace of a function at the column of the line that opened it.
"""

from __future__ import annotations

import ast
import re
from collections.abc import Iterator
from pathlib import Path

ROOT = Path(__file__).resolve().parents[1]
MAX_FILE_LINES = 400
MAX_FUNCTION_LINES = 60
CPP_FUNCTION = re.compile(
    r"^(\s*)(?!(?:namespace|class|struct|enum|if|for|while|switch|else|do|union)\b)\S.*\{$"
)


def cpp_functions(lines: list[str]) -> Iterator[tuple[str, int]]:
    """(first line, length) of each function definition at namespace or class level."""
    start, indent = 0, -1  # indent >= 0 inside a function
    for number, line in enumerate(lines):
        if indent >= 0:
            # An initialiser list opens the body further right than its brace closes it.
            if line.lstrip().startswith("}") and len(line) - len(line.lstrip()) <= indent:
                yield lines[start].strip(), number - start + 1
                indent = -1
        elif (match := CPP_FUNCTION.match(line)) and ("(" in line or ")" in line):
            start, indent = number, len(match.group(1))


def python_functions(source: str) -> Iterator[tuple[str, int]]:
    """(name, length) of each function, its docstring not counted."""
    for node in ast.walk(ast.parse(source)):
        if isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef):
            first = node.body[0]
            docstring = ast.get_docstring(node, clean=False)
            skipped = (first.end_lineno or 0) - first.lineno + 1 if docstring else 0
            yield node.name, (node.end_lineno or 0) - node.lineno + 1 - skipped


def offenders(root: Path = ROOT) -> list[str]:
    """One line of text for each file or function over budget."""
    found = []
    for folder in ("cpp", "python", "scripts", "benchmarks", "examples"):
        for path in sorted((root / folder).rglob("*")):
            if path.suffix not in {".h", ".cpp", ".py"}:
                continue
            source = path.read_text(encoding="utf-8")
            lines = source.splitlines()
            name = path.relative_to(root)
            if len(lines) > MAX_FILE_LINES:
                found.append(f"{name}: {len(lines)} lines")
            functions = python_functions(source) if path.suffix == ".py" else cpp_functions(lines)
            found += [
                f"{name}: {what}: {length} lines"
                for what, length in functions
                if length > MAX_FUNCTION_LINES
            ]
    return found


def main() -> None:
    """Print the offenders."""
    print("\n".join(offenders()) or "sizes: ok")


if __name__ == "__main__":
    main()
