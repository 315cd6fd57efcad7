# From a fresh clone: `make demo`, `make test`. Needs Python 3.11, make and pip; nothing else.
PY ?= python3
VENV := .venv
BIN := $(VENV)/bin
STAMP := $(VENV)/.installed

.PHONY: install demo test lint bench clean
install: $(STAMP)

$(STAMP): pyproject.toml constraints.txt
	$(PY) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[cross,dev]'
	touch $@

demo: $(STAMP)
	$(BIN)/tribofmu demo -o build/demo

test: $(STAMP)
	$(BIN)/python -m pytest -n 2 --dist loadscope tests

lint: $(STAMP)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports

bench: $(STAMP)
	$(BIN)/python -m tests.benchmarks -o docs/benchmarks.md

clean:
	rm -rf $(VENV) build .pytest_cache .mypy_cache .ruff_cache
