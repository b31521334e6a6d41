# Every target sets up what it needs: a virtual environment in .venv with the versions of requirements.lock.
# Needs: make and Python 3.11, 3.12 or 3.13 (another one by name: `make PYTHON=/path/to/python3.12 setup`).

SHELL := /bin/sh
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.ready
JOBS ?= 2
CONFIG ?= quick_traverse
AGENT ?= runs/latest
EPISODES ?= 200
SEED ?= 100000

.DEFAULT_GOAL := help
.PHONY: help setup lock console train seas test lint format bench docs acceptance clean

help: ## Show this list
	@awk -F ':.*## ' '/^[a-z]+:.*## / { printf "  make %-12s %s\n", $$1, $$2 }' $(MAKEFILE_LIST)

setup: $(STAMP) ## Create .venv and install the locked versions (nothing happens when nothing changed)

$(STAMP): requirements.lock pyproject.toml
	@set -e; python="$$(sh tools/find_python.sh $(PYTHON))"; \
	if [ -x $(BIN)/python ] && [ "$$($(BIN)/python -V 2>&1)" = "$$($$python -V 2>&1)" ]; then :; \
	else echo "creating $(VENV) with $$python"; rm -rf $(VENV); "$$python" -m venv $(VENV); fi
	$(BIN)/python -m pip install --disable-pip-version-check --progress-bar off -q -r requirements.lock
	$(BIN)/python -m pip install --disable-pip-version-check -q --no-deps --no-build-isolation -e .
	@touch $@

console: $(STAMP) ## Drive the claw yourself, on a page in the browser (Ctrl-C ends)
	$(BIN)/ssmash console

train: $(STAMP) ## Train a traverse agent in some minutes (CONFIG=ppo_traverse: like the shipped one), then evaluate it
	$(BIN)/python train.py --config $(CONFIG)
	$(BIN)/python evaluate.py --agent $(AGENT) --against trapezoid,hold,yield,linear --episodes $(EPISODES) --seed $(SEED) \
	  --scenario training --out runs/evaluation

seas: $(STAMP) ## Evaluate the trained agent and the baselines in each of the sea states 3 to 6
	@set -e; for sea in ss3 ss4 ss5 ss6; do \
	$(BIN)/python evaluate.py --agent $(AGENT) --against trapezoid,hold,yield,linear --episodes $(EPISODES) --seed $(SEED) \
	  --scenario $$sea --no-film --out runs/evaluation_$$sea; done

test: $(STAMP) ## Run the tests (not the long ones)
	$(BIN)/python -m pytest -q -n $(JOBS) --dist loadfile

lint: $(STAMP) ## Check style and types
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --strict ssmash_gym

format: $(STAMP) ## Put the code into the house format
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

bench: $(STAMP) ## Measure the engine beside a MuJoCo model of the same helicopter: JSON and a table
	$(BIN)/python -m benchmarks.run --out build/bench.json

docs: $(STAMP) ## Check the links of every page, build the manual in build/docs and the API reference beside it
	$(BIN)/python tools/check_links.py
	$(BIN)/python -m sphinx -W --keep-going -q -E -d build/doctrees docs build/docs
	$(BIN)/python tools/api_reference.py build/docs/api

acceptance: $(STAMP) ## Run every check, the long ones too (soak, training, full sweeps)
	$(BIN)/python -m pytest -q -m "slow or not slow"

lock: ## Write requirements.lock anew: the newest versions that pyproject.toml allows
	"$$(sh tools/find_python.sh $(PYTHON))" tools/write_lock.py

clean: ## Remove everything that make has made
	rm -rf $(VENV) build dist .pytest_cache .mypy_cache .ruff_cache .hypothesis
