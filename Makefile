# Front doors of raylign. Each target sets up what it needs (scripts/bootstrap.sh: Debian packages,
# .venv, one CMake build in build/release) and does nothing twice.
PYTHON_BIN := .venv/bin/python
JOBS := $(shell nproc)
BOOTSTRAP := scripts/bootstrap.sh
DEMO_DIR ?= raylign-demo
BENCH_FLAGS ?=

.DEFAULT_GOAL := help
.PHONY: help setup demo test bench lint format stub asan tsan fuzz tidy clean

help:  ## list the targets
	@sed -n 's/^\([a-z]*\):.*  ## /\1\t/p' $(MAKEFILE_LIST) | expand -t 10

setup:  ## install what is missing and raylign itself into .venv
	$(BOOTSTRAP)

demo: setup  ## bundle adjustment from pixels and from grey values, with pictures
	.venv/bin/raylign demo --report $(DEMO_DIR)
	.venv/bin/raylign demo --scene room --report $(DEMO_DIR)/room
	@echo "pictures are in $(abspath $(DEMO_DIR)) and its room/:" && ls $(DEMO_DIR) $(DEMO_DIR)/room

test:  ## C++ and Python tests
	$(BOOTSTRAP) --tests
	ctest --test-dir build/release --output-on-failure -j$(JOBS)
	$(PYTHON_BIN) -m pytest

bench: setup  ## benchmarks; JSON under benchmarks/results (BENCH_FLAGS=--help)
	$(PYTHON_BIN) benchmarks/run.py $(BENCH_FLAGS)

lint:  ## ruff, clang-format, layers, mypy --strict, stubtest
	$(BOOTSTRAP) venv
	scripts/format.sh --check
	$(PYTHON_BIN) -m ruff check .
	$(PYTHON_BIN) scripts/check_layers.py
	$(PYTHON_BIN) scripts/check_size.py
	$(BOOTSTRAP)
	$(PYTHON_BIN) -m mypy
	$(PYTHON_BIN) scripts/make_stub.py --check
	$(PYTHON_BIN) -m mypy.stubtest raylign._core --allowlist scripts/stubtest_allowlist.txt

format:  ## rewrite the sources in the house style
	$(BOOTSTRAP) venv
	scripts/format.sh

stub: setup  ## rewrite python/raylign/_core.pyi after a change of the bindings
	$(PYTHON_BIN) scripts/make_stub.py

asan:  ## the C++ tests under AddressSanitizer and UndefinedBehaviorSanitizer
	$(BOOTSTRAP) system
	cmake -S . -B build/asan -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
	  -DRAYLIGN_SANITIZE=address,undefined -DRAYLIGN_BUILD_TESTS=ON
	cmake --build build/asan -j$(JOBS)
	UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
	  ctest --test-dir build/asan --output-on-failure -j$(JOBS)

# What runs on several threads, and only that: under ThreadSanitizer everything takes ten times longer.
TSAN_TESTS := bundle_jacobian_table bundle_native bundle_solver_matrix bundle_supernodal_cholesky \
  photometric_adjuster photometric_parity solver_blocked_cholesky synthetic_renderer tracking_aligner
tsan:  ## the tests that compare numbers of threads under ThreadSanitizer
	$(BOOTSTRAP) system
	cmake -S . -B build/tsan -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
	  -DRAYLIGN_SANITIZE=thread -DRAYLIGN_BUILD_TESTS=ON
	cmake --build build/tsan -j$(JOBS) --target $(addsuffix _test,$(TSAN_TESTS))
	for test in $(TSAN_TESTS); do \
	  build/tsan/tests/cpp/$${test}_test --gtest_filter='*Thread*' --gtest_brief=1 || exit 1; done

fuzz:  ## 1e5 hostile inputs for the readers, under the sanitizers
	$(BOOTSTRAP) system
	cmake -S . -B build/fuzz -G Ninja -DCMAKE_BUILD_TYPE=RelWithDebInfo \
	  -DRAYLIGN_SANITIZE=address,undefined -DRAYLIGN_BUILD_TESTS=OFF -DRAYLIGN_BUILD_FUZZERS=ON
	cmake --build build/fuzz -j$(JOBS) --target fuzz_bal_reader
	UBSAN_OPTIONS=print_stacktrace=1:halt_on_error=1 \
	  ctest --test-dir build/fuzz --output-on-failure

tidy:  ## clang-tidy over the library (needs Debian's clang-tidy; slow, not part of lint)
	$(BOOTSTRAP) --tests
	run-clang-tidy -p build/release -quiet 'cpp/raylign/.*\.cpp$$'

clean:  ## remove builds and caches; .venv stays
	rm -rf build dist .mypy_cache .ruff_cache .pytest_cache
	rm -f .venv/.raylign-installed
