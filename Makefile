# Each target does its own set-up: Python 3.11 or newer and make are all it takes.
PYTHON ?= $(shell for p in python3 python3.13 python3.12 python3.11 python; do \
	$$p -c 'import sys; sys.exit(sys.version_info < (3, 11))' 2>/dev/null && echo $$p && break; done)
VENV := .venv
BIN := $(VENV)/bin
INSTALLED := $(VENV)/.installed
PEERS := $(VENV)/.peers
DOCS := $(VENV)/.docs
OLDEST := .venv-oldest
RLLIB := .venv-rllib
# those that load no PyTorch
OLDEST_TESTS = $(shell grep -LE '^(from|import) (torch|ltlc\.agents|ltlc\.cli)' $(wildcard $(addprefix tests/, \
	envs/*.py rewards/*.py ltl/*.py translate/test_[op]*.py formats/test_hoa.py mdp/test_model.py)))
# A worker of pytest-xdist for each core; none of them needs more than a thread.
PYTEST = OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n auto --maxprocesses 8 --dist worksteal

.DEFAULT_GOAL := help
.PHONY: help demo test test-fast test-hosts test-oldest test-rllib docs docs-links check format clean

help:  ## show this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## / {printf "  make %-11s %s\n", $$1, $$2}' $(MAKEFILE_LIST)

demo: $(INSTALLED)  ## compile a task, draw it, judge two words, learn it
	@$(BIN)/python examples/demo.py

test: $(INSTALLED) $(PEERS)  ## run all tests
	$(PYTEST)

test-fast: $(INSTALLED)  ## run the tests that take a minute at most
	$(PYTEST) -q -m "not (slow or peer or build)"

test-oldest: $(OLDEST)/.installed  ## test what needs no torch with the oldest dependencies allowed
	$(OLDEST)/bin/python -m pytest $(OLDEST_TESTS)

test-rllib: $(RLLIB)/.installed  ## test RLlib, which pins Gymnasium, and sweeps on Ray in an environment of its own
	$(RLLIB)/bin/python -m pytest -q tests/bridges/test_rllib.py tests/sweeps/test_ray.py
	LTLC_HOSTS=1 $(RLLIB)/bin/python -m pytest -q tests/bridges/test_hosts.py -k rllib

test-hosts: $(INSTALLED) $(PEERS)  ## learn one task file in every library but RLlib, Atari among them, and judge it
	LTLC_HOSTS=1 $(PYTEST) -q tests/bridges/test_hosts.py

docs: $(INSTALLED) $(DOCS)  ## build the site into build/docs/html, strictly, and run all code in it
	$(PYTEST) -q tests/house/test_readme.py tests/house/test_contributing.py tests/house/test_recipes.py \
		tests/house/test_doctests.py tests/house/test_examples.py tests/house/test_docs.py -k "not cells"
	$(BIN)/python -m sphinx -W --keep-going -q -E -b html docs build/docs/html
	$(BIN)/python docs/_ext/site_check.py build/docs/html

docs-links: $(INSTALLED) $(DOCS)  ## ask other hosts whether the links of the site lead somewhere
	$(BIN)/python -m sphinx -q -D nb_execution_mode=off -D suppress_warnings=myst-nb.lexer,ref.python -b linkcheck docs build/docs/links

check: $(INSTALLED)  ## lint, format, types, architecture
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/python -m pytest -q tests/house/test_architecture.py

format: $(INSTALLED)  ## let ruff repair what it can
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean:  ## remove the environment and everything built
	rm -rf $(VENV) $(OLDEST) $(RLLIB) build dist demo docs/generated *.egg-info .mypy_cache .ruff_cache .pytest_cache

# Installed once; again only when what is to be installed has changed.
$(INSTALLED): pyproject.toml constraints.txt
	@test -n "$(PYTHON)" || { echo "ltlc needs Python 3.11 or newer, as python3 or by make PYTHON=/path/to/python"; exit 1; }
	@test -x $(BIN)/python || { echo "creating $(VENV) ..."; $(PYTHON) -m venv $(VENV); }
	@echo "installing ltlc and its dependencies into $(VENV) (once; PyTorch is by far the largest) ..."
	@$(BIN)/python -m pip install --disable-pip-version-check -c constraints.txt -e '.[dev]'
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt graphviz-pure || \
		echo "no graphviz-pure for this system: pictures of automata need Graphviz (dot)"
	@$(BIN)/python -m compileall -q ltlc agents grammars || true  # else each start compiles, where Python may not write
	@echo "installed."
	@touch $@

# Other people's tools, for comparison; tests are skipped where one cannot be installed.
$(PEERS): $(INSTALLED)
	@echo "installing the tools that tests compare with (once) ..."
	@for p in spottl stormpy stable-baselines3 sb3-contrib pettingzoo torchrl minigrid ale-py; do \
		$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt $$p || \
		echo "no $$p for this system: its comparisons are skipped"; done
	@touch $@

$(DOCS): $(INSTALLED)
	@echo "installing what builds the site (once) ..."
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[docs]'
	@touch $@

$(OLDEST)/.installed: pyproject.toml constraints-oldest.txt
	@test -n "$(PYTHON)" || { echo "ltlc needs Python 3.11 or newer, as python3 or by make PYTHON=/path/to/python"; exit 1; }
	@test -x $(OLDEST)/bin/python || { echo "creating $(OLDEST) ..."; $(PYTHON) -m venv $(OLDEST); }
	@echo "installing the oldest dependencies into $(OLDEST) (once) ..."
	@$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check -c constraints-oldest.txt \
		gymnasium hypothesis jsonschema lark matplotlib numpy pytest rich scipy typer
	@$(OLDEST)/bin/python -m pip install --quiet --disable-pip-version-check --no-deps -e .
	@touch $@

$(RLLIB)/.installed: pyproject.toml
	@test -n "$(PYTHON)" || { echo "ltlc needs Python 3.11 or newer, as python3 or by make PYTHON=/path/to/python"; exit 1; }
	@test -x $(RLLIB)/bin/python || { echo "creating $(RLLIB) ..."; $(PYTHON) -m venv $(RLLIB); }
	@echo "installing RLlib into $(RLLIB) (once) ..."
	@$(RLLIB)/bin/python -m pip install --quiet --disable-pip-version-check 'ray[rllib]>=2.50' hypothesis pytest -e .
	@touch $@
