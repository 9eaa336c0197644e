# Set-up and the two jobs: `make size` (the main job) and `make test`. Needs Python >= 3.11 and pip.
PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: help size size-all reproduce test check lint types imports pytest slow modes mutants bench clean
CASES := $(basename $(notdir $(wildcard scripts/cases/*.yaml)))

help:
	@echo "make size   torque and actuator sizing table of the antenna mechanism, into out/"
	@echo "make size-all   the tables of all cases in scripts/cases"
	@echo "make reproduce  every number that the four papers print, into out/reproduction"
	@echo "make test   lint, types, import direction, generated files, tests"
	@echo "make check  the committed URDFs, descriptions and trajectories are what the scripts write"
	@echo "make slow   100,000 random poses of every group of mechanisms against closed forms, hours"
	@echo "make modes  inverse kinematics of 20,000 random poses against the closed form"
	@echo "make mutants  does some test fail when the code is wrong? 300 changes, an hour or two"
	@echo "make bench  speed against placo, a plain loop and MuJoCo (installs placo beside)"
	@echo "make clean  remove .venv and out/"

$(VENV)/bin/python:
	@$(PYTHON) -c 'import sys; sys.exit("pinmech needs Python 3.11 or newer, this is " + sys.version.split()[0] + "; try: make PYTHON=python3.11 ...") if sys.version_info < (3, 11) else None'
	$(PYTHON) -m venv $(VENV)

# The stamps say what is installed: a second run does not install again.
$(VENV)/.run: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[all]'
	@touch $@

$(VENV)/.test: pyproject.toml | $(VENV)/bin/python
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -e '.[test]'
	@touch $@ $(VENV)/.run

size: $(VENV)/.run
	$(BIN)/pinmech size scripts/cases/antenna_relay.yaml --out out/antenna_relay

size-all: $(addprefix size-,$(CASES))

size-%: $(VENV)/.run
	$(BIN)/pinmech size scripts/cases/$*.yaml --out out/$*

reproduce: $(VENV)/.run
	$(BIN)/python scripts/reproduce_papers.py --out out/reproduction

test: lint types imports check pytest

lint: $(VENV)/.test
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/.test
	$(BIN)/mypy

imports: $(VENV)/.test
	$(BIN)/lint-imports

check: $(VENV)/.test
	$(BIN)/python scripts/make_designs.py --check
	$(BIN)/python scripts/make_relay_trajectory.py --check
	$(BIN)/python scripts/make_sun_trajectory.py --check

# Two processes: more cores help less than their start costs. COV adds options, as CI does.
pytest: $(VENV)/.test
	OMP_NUM_THREADS=1 OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist worksteal $(COV)

slow: $(VENV)/.test
	$(BIN)/python -m pytest -m slow

modes: $(VENV)/.test
	$(BIN)/python tests/slow/check_modes.py

mutants: $(VENV)/.test
	$(BIN)/python scripts/mutate.py --out out/mutants.md

bench: $(VENV)/.test
	$(BIN)/python scripts/bench_kinematics.py

clean:
	rm -rf $(VENV) out
