# Short names for the usual work. The presets of CMakePresets.json do the building, tools/setup/ the rest.
.DEFAULT_GOAL := help
.PHONY: help setup build test host asan fixed arm coverage python demo bench lint target-report clean

PYTHON := .venv/bin/python
CHECK  := $(PYTHON) tools/setup/run_tests.py

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / { printf "make %-9s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: ## install what is missing, make .venv with the command evenspin
	@tools/setup/setup.sh

build: setup ## build the host preset (firmware, simulator, tests; both numerics)
	@cmake --preset host
	@cmake --build --preset host

test: ## everything that must hold before a change goes in; what .ci/run runs
	@tools/setup/setup.sh || { echo "0 passed, 1 failed"; exit 1; }
	@$(CHECK)

host: setup ## C tests, both numerics
	@$(CHECK) host

asan: setup ## C tests under the address and undefined-behaviour sanitizers
	@$(CHECK) asan

fixed: setup ## C tests of a fixed-point-only build
	@$(CHECK) fixed

arm: setup ## compile for Cortex-M4F
	@$(CHECK) arm

coverage: setup ## lines and branches of control/ that its tests reach, with the gate
	@$(CHECK) coverage

python: setup ## lint and tests of the Python package
	@$(CHECK) lint python

demo: setup ## simulate, compare, report: out/demo
	@.venv/bin/evenspin demo --out out/demo

bench: setup ## speed of the simulator on this machine
	@.venv/bin/evenspin benchmark sim

lint: setup ## ruff and the rules of the layers
	@.venv/bin/ruff check .
	@$(PYTHON) tests/architecture/check_layers.py .

target-report: setup ## flash and RAM of every block: build for Cortex-M4F, and TI's map file (MAP=FILE) if there is one
	@$(PYTHON) tests/target/report.py . $(if $(MAP),--map $(MAP))

clean: ## remove build/ and out/; .venv stays
	@rm -rf build out
