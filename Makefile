# Short names for everyday work. The presets of CMakePresets.json do the building, tools/setup/ the rest.
.DEFAULT_GOAL := help
.PHONY: flash help setup build wheel test test-searches quick host asan storage-campaign fixed arm coverage python demo bench soak motors stability combinations scope-fps lint tidy format target-report blind blind-logs faults single-faults motion fuzz-logs balance wrong-maps clean simulators gap-cases foreign-logs prove mutate replay-day figures speeds circle

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

QUICK_S := 35

quick: setup ## lint, and the tests that a change touches, nearest first: about a minute (SINCE=REVISION compares with that)
	@$(PYTHON) tools/setup/quick.py --seconds $(QUICK_S) $(if $(SINCE),--since $(SINCE))

host: setup ## C tests, both numerics
	@$(CHECK) host

storage-campaign: build ## saves with power cuts, into stuck cells, and loads from unsteady ones, the whole count
	EVENSPIN_CAMPAIGN=1 ctest --preset host -R 'test_(store$$|memory_)' --verbose

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

wheel: setup ## dist/evenspin-*.whl: the package for `pip install` elsewhere, with the compiled libraries
	@$(PYTHON) -m pip --disable-pip-version-check wheel --quiet . --no-deps --no-build-isolation \
		--config-settings=build-dir=build/py --wheel-dir dist
	@ls dist/*.whl

demo: setup ## simulate, compare, report: out/demo
	@.venv/bin/evenspin demo --out out/demo

bench: setup ## speed of the simulator on this machine
	@.venv/bin/evenspin benchmark sim

SOAK_S := 600

soak: setup ## 10 minutes of 8 signals at 1 kHz over a 625000 baud link of a virtual drive; SOAK_S=60 is shorter
	@export XDG_RUNTIME_DIR=$$(mktemp -d); .venv/bin/evenspin drive --pty --baud 625000 & drive=$$!; \
	trap 'kill $$drive; rm -rf "$$XDG_RUNTIME_DIR"' EXIT; sleep 3; .venv/bin/evenspin bench soak --speed 30 --seconds $(SOAK_S)

STABILITY_CASES ?= 200
STABILITY_SEED  ?= 1

MOTORS      ?= 30
MOTORS_SEED ?= 0

motors: setup ## random machines behind the virtual drive, commissioned and tuned: right, and stable with every method? Writes docs/motors.md (30: 5 min of processor time)
	@rm -f out/motors.jsonl
	@OPENBLAS_NUM_THREADS=1 $(PYTHON) tools/tests/motors_campaign.py $(MOTORS) $(MOTORS_SEED) --log out/motors.jsonl --page docs/motors.md

stability: setup ## random drives: does the simulated firmware do what `design rc` says? (200 cases: 5 min)
	@$(PYTHON) tools/tests/stability_campaign.py $(STABILITY_CASES) $(STABILITY_SEED)

combinations: setup ## every pair of methods in the simulator: works, or is refused; writes docs/combinations.md (1 min)
	@.venv/bin/evenspin combinations --page docs/combinations.md

figures: setup ## every figure of the three papers with ours, theirs and the verdict; writes docs/reference/*-figures.md (1 min)
	@for paper in guo2024 tang2020 yeh2024; do .venv/bin/evenspin reproduce $$paper --page docs/reference/$$paper-figures.md || exit 1; done

speeds: setup ## angle-based observer from 50 to 2500 r/min in both builds; writes docs/reference/tang2020-speeds.md (3 min)
	@.venv/bin/evenspin reproduce tang2020 --sweep --page docs/reference/tang2020-speeds.md

scope-fps: setup ## frames per second of the scope's page in headless Chromium, 8 signals at 1 kHz
	@$(PYTHON) tools/tests/scope/measure_fps.py

lint: setup ## format and lint of C and Python, types of Python, layers of both, words; the step of the same name in `make test`
	@$(CHECK) lint

tidy: setup ## clang-tidy through all states of every function, not only the first 40000 as in `make lint` (1 min)
	@$(CHECK) tidy

format: setup ## bring C and Python into the format that `make lint` checks
	@.venv/bin/ruff format -q .
	@git ls-files '*.c' '*.h' | xargs .venv/bin/clang-format -i

target-report: setup ## flash and RAM of every block: build for Cortex-M4F, and TI's map file (MAP=FILE) if there is one
	@$(PYTHON) tests/target/report.py . $(if $(MAP),--map $(MAP))

flash: ## load the newest build/c2000/**/*.out into the LaunchPad by DSLite (docs/flashing.md); FILE=x.out names another
	@$(if $(wildcard $(PYTHON)),$(PYTHON),python3) tools/setup/flash.py $(FILE)

BLIND_CASES ?= 120
BLIND_SEED  ?= 20261219
BLIND       := out/blind-$(BLIND_SEED)

blind: setup ## hidden effects from another simulator: make, solve, score, write docs/blind.md (120 cases: 50 min)
	@rm -rf $(BLIND)
	@.venv/bin/evenspin gap blind make --count $(BLIND_CASES) --seed $(BLIND_SEED) --out $(BLIND)/cases --truth $(BLIND)/truth.json
	-@.venv/bin/evenspin gap batch $(BLIND)/cases --out $(BLIND)/verdicts
	@.venv/bin/evenspin gap blind score --truth $(BLIND)/truth.json --results $(BLIND)/verdicts --markdown docs/blind.md --force

test-searches: setup ## the searches that are too long for `make test`, whole: cases of two simulators, the circle, the four examples (10 min of processor time)
	@OPENBLAS_NUM_THREADS=1 $(PYTHON) -m pytest -q -m search

gap-cases: setup ## the hard cases of the gap search with all effects to choose from (3 min; with the likely ones in `make test-searches`)
	@EVENSPIN_CAMPAIGN=1 $(PYTHON) -m pytest -q -m "search or not search" tools/tests/blind/test_blind_hard.py

COUNT ?= 60
SEEDS ?= 1
LOGS  := out/blind-logs

blind-logs: setup ## logs of other drives from the same referee: make, run, score, write docs/blind-logs.md (60 logs: 15 min)
	@rm -rf $(LOGS)
	@.venv/bin/evenspin gap blind make-logs --count $(COUNT) --seeds $(SEEDS) --out $(LOGS)/logs --truth $(LOGS)/truth.json
	@.venv/bin/evenspin gap blind run-logs $(LOGS)/logs --truth $(LOGS)/truth.json --out $(LOGS)/verdicts
	@.venv/bin/evenspin gap blind score-logs --truth $(LOGS)/truth.json --results $(LOGS)/verdicts --markdown docs/blind-logs.md --force

FOREIGN := out/foreign-logs

foreign-logs: setup ## causes that no table lists: make, run, score, write docs/foreign-logs.md (60 logs: 20 min)
	@rm -rf $(FOREIGN)
	@.venv/bin/evenspin gap blind make-logs --foreign --count $(COUNT) --seeds $(SEEDS) --out $(FOREIGN)/logs --truth $(FOREIGN)/truth.json
	@.venv/bin/evenspin gap blind run-logs $(FOREIGN)/logs --truth $(FOREIGN)/truth.json --out $(FOREIGN)/verdicts
	@.venv/bin/evenspin gap blind score-foreign --truth $(FOREIGN)/truth.json --results $(FOREIGN)/verdicts --markdown docs/foreign-logs.md --force

SIMULATORS := out/simulators

simulators: setup ## motulator as a third simulator: how far the three are apart, and what `gap` says of its logs; writes docs/simulators.md (30 min)
	@rm -rf $(SIMULATORS)
	@.venv/bin/evenspin gap blind make --simulator motulator --kind single=8,pair=3,none=1 --seed 11 --out $(SIMULATORS)/cases --truth $(SIMULATORS)/truth.json
	-@.venv/bin/evenspin gap batch $(SIMULATORS)/cases --out $(SIMULATORS)/verdicts
	@$(PYTHON) tools/tests/simulators_campaign.py $(SIMULATORS) docs/simulators.md

CIRCLE_COUNT := 60
CIRCLE_SEED  := 1
CIRCLE_FIRST := $(CIRCLE_COUNT)
CIRCLE       := out/circle-$(CIRCLE_SEED)

circle: setup ## blind machines from cause to correction, measured before and after; writes docs/circle.md (60 machines: 50 min of processor time; CIRCLE_FIRST=12: the first of them)
	@CIRCLE_FIRST=$(CIRCLE_FIRST) $(PYTHON) tools/tests/circle_campaign.py $(CIRCLE) $(CIRCLE_COUNT) $(CIRCLE_SEED) docs/circle.md

faults: setup ## outputs and recordings on a disk that fails, and under a kill, at every single step
	@EVENSPIN_EVERY_STEP=1 $(PYTHON) -m pytest -q tools/tests/test_kept_recordings.py tools/tests/test_output_faults.py

prove: ## blocks without undefined behaviour and within their bounds, for all inputs; needs frama-c; writes docs/proofs.md (4 min)
	@python3 tests/prove/prove.py --self-test --page docs/proofs.md

MUTATE_CONTROL := 200
MUTATE_SEED    := 1

mutate: build ## protection, state machine, faults, storage and a sample of control/ broken on purpose: which test notices? Writes docs/mutation.md (40 min of processor time; goes on from out/mutate.log)
	@mkdir -p out; ctest --preset host -L "control|firmware|scenario" > out/mutate-ctest.log || { tail -5 out/mutate-ctest.log; exit 1; }
	@$(PYTHON) tests/mutate/mutate.py build/host "firmware/app/protection.c" "firmware/app/state_machine.c" "firmware/app/faults.c" \
		"firmware/storage/*.c" "control/**/*.c:$(MUTATE_CONTROL)" --seed $(MUTATE_SEED) --log out/mutate.log --page docs/mutation.md

SINGLE_FAULT_MOMENTS := 64

single-faults: setup ## every single fault that can be simulated, at 64 moments of six drives, and bit flips; writes docs/single-faults.md (5 min)
	@$(PYTHON) tools/tests/single_faults.py --moments $(SINGLE_FAULT_MOMENTS)

MOTION_S := 10000

motion: setup ## drives that work, at random, on every model: the checks of the motion must not trip (10000 s of driving: 2 min)
	@$(PYTHON) tools/tests/motion_campaign.py --seconds $(MOTION_S)

DRIVING_S := 86400

replay-day: setup ## a day of random driving with faults, recorded and replayed: not one difference (DRIVING_S=86400: 40 min)
	@$(PYTHON) tools/tests/replay_campaign.py --seconds $(DRIVING_S)

FUZZ_TRIALS ?= 5000
FUZZ_SEED   ?= 1

fuzz-logs: setup ## broken case folders and logs: work that is done, or one line (5000: 25 min; a few are in `make test`)
	@FUZZ_TRIALS=$(FUZZ_TRIALS) FUZZ_SEED=$(FUZZ_SEED) $(PYTHON) -m pytest -q tools/tests/gap/test_gap_fuzzed_logs.py

BALANCE_FIRST ?= 500
BALANCE_COUNT ?= 40

balance: setup ## torque balance of logs drawn at random: wrong names, intervals that hold the truth (40 logs: 3 min)
	@$(PYTHON) tools/tests/balance/numpy_campaign.py $(BALANCE_FIRST) $(BALANCE_COUNT)

WRONG_MAP_DRIVES ?= 8

wrong-maps: setup ## signs, frames and units of logs made wrong one at a time: how many are seen (8 drives: 5 min; some are in `make test`)
	@$(PYTHON) tools/tests/importer/wrong_maps.py $(WRONG_MAP_DRIVES)

clean: ## remove build/ and out/; .venv stays
	@rm -rf build out
