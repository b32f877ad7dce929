#!/usr/bin/env bash
# Formats all C++ and Python sources, or with --check only says which files differ (exit status 1).
set -euo pipefail
cd "$(dirname "$0")/.."
if [[ ${1:-} == --check ]]; then
  cpp_options=(--dry-run -Werror)
  python_options=(--check)
else
  cpp_options=(-i)
  python_options=()
fi
find cpp tests benchmarks examples -name '*.h' -print0 -o -name '*.cpp' -print0 |
  xargs -0 -r .venv/bin/clang-format --style=file "${cpp_options[@]}"
.venv/bin/ruff format "${python_options[@]}" .
