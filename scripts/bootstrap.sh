#!/usr/bin/env bash
# Sets up what a make target needs, in three steps that each do nothing when nothing is missing:
#   system   Debian packages of .ci/apt.txt (needs root or sudo only when one is missing)
#   venv     .venv with the build requirements, raylign's dependencies and the extras asked for
#   install  raylign itself, built by CMake in build/release and installed into .venv
#
# usage: scripts/bootstrap.sh [--tests] [STEP]
#   STEP     run up to and including this step (default: install)
#   --tests  build the C++ tests too, in the same CMake build
# environment:
#   PYTHON          interpreter for .venv (>= 3.11, with venv, ensurepip and headers)
#   RAYLIGN_WERROR  ON makes compiler warnings errors (as .ci/run does)
set -euo pipefail
cd "$(dirname "$0")/.."
readonly VENV=.venv
readonly BUILD=build/release
readonly STAMP=$VENV/.raylign-installed
readonly REQUIREMENTS_STAMP=$VENV/.raylign-requirements

say() { printf '== %s\n' "$*" >&2; }
fail() {
  printf 'bootstrap: %s\n' "$*" >&2
  exit 1
}

missing_packages() {
  local package
  while read -r package; do
    case "$package" in '' | '#'*) continue ;; esac
    # shellcheck disable=SC2016  # ${Status} belongs to dpkg-query
    dpkg-query -W -f='${Status}' "$package" 2>/dev/null | grep -q 'ok installed' || echo "$package"
  done <.ci/apt.txt
}

ensure_system() {
  if ! command -v dpkg-query >/dev/null; then
    say "not a Debian system: assuming that the libraries of .ci/apt.txt are there"
    return
  fi
  local missing
  mapfile -t missing < <(missing_packages)
  if ((${#missing[@]} == 0)); then return; fi
  local as_root=()
  if ((EUID != 0)); then
    command -v sudo >/dev/null ||
      fail "missing packages and neither root nor sudo; ask an administrator to run:
  apt-get install --no-install-recommends ${missing[*]}"
    as_root=(sudo)
  fi
  say "installing Debian packages: ${missing[*]}"
  "${as_root[@]}" apt-get update -qq
  "${as_root[@]}" env DEBIAN_FRONTEND=noninteractive \
    apt-get install -y -qq --no-install-recommends "${missing[@]}" >&2
}

# True when $1 is a Python that can make a virtual environment and compile extensions.
usable_python() {
  "$1" - 2>/dev/null <<'PY'
import pathlib, sys, sysconfig
import ensurepip, venv
headers = pathlib.Path(sysconfig.get_path("include"), "Python.h")
sys.exit(0 if sys.version_info >= (3, 11) and headers.is_file() else 1)
PY
}

choose_python() {
  local candidate
  for candidate in ${PYTHON:-python3 python3.13 python3.12 python3.11 /usr/bin/python3}; do
    if command -v "$candidate" >/dev/null && usable_python "$candidate"; then
      command -v "$candidate"
      return
    fi
  done
  fail "no usable Python among '${PYTHON:-python3 python3.13 python3.12 python3.11 /usr/bin/python3}': \
need >= 3.11 with the modules venv and ensurepip and the file Python.h \
(Debian: python3-venv and python3-dev); set PYTHON to choose one"
}

ensure_venv() {
  if ! usable_python "$VENV/bin/python"; then
    local python
    python=$(choose_python)
    say "creating $VENV with $python"
    "$python" -m venv --clear "$VENV"
  fi
  local wanted
  wanted=$(cat pyproject.toml; "$VENV/bin/python" -V)
  if [[ -f $REQUIREMENTS_STAMP && $(<"$REQUIREMENTS_STAMP") == "$wanted" ]]; then return; fi
  local requirements
  mapfile -t requirements < <("$VENV/bin/python" - <<'PY'
import tomllib
table = tomllib.load(open("pyproject.toml", "rb"))
extras = table["project"]["optional-dependencies"]
for group in (table["build-system"]["requires"], table["project"]["dependencies"], extras["test"], extras["lint"]):
    print(*group, sep="\n")
PY
  )
  say "installing into $VENV: ${requirements[*]}"
  "$VENV/bin/python" -m pip install --quiet --disable-pip-version-check "${requirements[@]}"
  printf '%s\n' "$wanted" >"$REQUIREMENTS_STAMP"
}

# True when nothing that goes into the build or the wheel is newer than the last installation, and
# that installation had the tests if they are wanted now.
up_to_date() {
  [[ -f $STAMP ]] || return 1
  if [[ $tests == ON && $(<"$STAMP") != tests=ON ]]; then return 1; fi
  "$VENV/bin/python" -c 'import raylign' 2>/dev/null || return 1
  local sources=(CMakeLists.txt pyproject.toml README.md cmake cpp python)
  if [[ -d data ]]; then sources+=(data); fi
  if [[ $tests == ON ]]; then
    [[ -f $BUILD/CTestTestfile.cmake ]] || return 1
    sources+=(tests/cpp tests/package)
  fi
  [[ -z $(find "${sources[@]}" -name __pycache__ -prune -o -newer "$STAMP" -print -quit) ]]
}

ensure_install() {
  if up_to_date; then return; fi
  say "building raylign in $BUILD (tests: $tests) and installing it into $VENV; the first time takes minutes"
  local started
  started=$(mktemp)  # its time is before any file is read: an edit during the build is not missed
  CMAKE_BUILD_PARALLEL_LEVEL=${CMAKE_BUILD_PARALLEL_LEVEL:-$(nproc)} \
    "$VENV/bin/python" -m pip install --quiet --disable-pip-version-check --no-build-isolation \
    --no-deps --force-reinstall --config-settings=build-dir="$BUILD" \
    --config-settings=cmake.define.RAYLIGN_BUILD_TESTS="$tests" \
    --config-settings=cmake.define.RAYLIGN_WERROR="${RAYLIGN_WERROR:-OFF}" .
  printf 'tests=%s\n' "$tests" >"$STAMP"
  touch -r "$started" "$STAMP"
  rm -f "$started"
}

tests=OFF
step=install
for argument in "$@"; do
  case "$argument" in
    --tests) tests=ON ;;
    system | venv | install) step=$argument ;;
    *) fail "unknown argument '$argument'; usage: scripts/bootstrap.sh [--tests] [system|venv|install]" ;;
  esac
done
ensure_system
if [[ $step != system ]]; then ensure_venv; fi
if [[ $step == install ]]; then ensure_install; fi
