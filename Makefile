# Short names for the usual work. The presets of CMakePresets.json do the building, tools/setup/ the rest.
.DEFAULT_GOAL := help
.PHONY: help setup build test host asan fixed arm coverage python demo bench soak scope-fps lint target-report blind balance clean

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

SOAK_S := 600

soak: setup ## 10 minutes of 8 signals at 1 kHz over a 625000 baud link of a virtual drive; SOAK_S=60 is shorter
	@export XDG_RUNTIME_DIR=$$(mktemp -d); .venv/bin/evenspin drive --pty --baud 625000 & drive=$$!; \
	trap 'kill $$drive; rm -rf "$$XDG_RUNTIME_DIR"' EXIT; sleep 3; .venv/bin/evenspin bench soak --speed 30 --seconds $(SOAK_S)

scope-fps: setup ## frames per second of the scope's page in headless Chromium, 8 signals at 1 kHz
	@$(PYTHON) tools/tests/scope/measure_fps.py

lint: setup ## ruff and the rules of the layers
	@.venv/bin/ruff check .
	@$(PYTHON) tests/architecture/check_layers.py .

target-report: setup ## flash and RAM of every block: build for Cortex-M4F, and TI's map file (MAP=FILE) if there is one
	@$(PYTHON) tests/target/report.py . $(if $(MAP),--map $(MAP))

BLIND_CASES ?= 120
BLIND_SEED  ?= 1
BLIND       := out/blind-$(BLIND_SEED)

blind: setup ## hidden effects from another simulator: make, solve, score, write docs/blind.md (120 cases: 40 min)
	@rm -rf $(BLIND)
	@.venv/bin/evenspin gap blind make --count $(BLIND_CASES) --seed $(BLIND_SEED) --out $(BLIND)/cases --truth $(BLIND)/truth.json
	-@.venv/bin/evenspin gap batch $(BLIND)/cases --out $(BLIND)/verdicts
	@.venv/bin/evenspin gap blind score --truth $(BLIND)/truth.json --results $(BLIND)/verdicts --markdown docs/blind.md

BALANCE_FIRST ?= 500
BALANCE_COUNT ?= 40

balance: setup ## torque balance of logs drawn at random: wrong names, intervals that hold the truth (40 logs: 3 min)
	@$(PYTHON) tools/tests/gap/balance/numpy_campaign.py $(BALANCE_FIRST) $(BALANCE_COUNT)

clean: ## remove build/ and out/; .venv stays
	@rm -rf build out
