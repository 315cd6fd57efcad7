# From a fresh clone: `make demo`, `make test`. Needs Python 3.11, make and pip; nothing else.
PY ?= python3
VENV := .venv
BIN := $(VENV)/bin
# Python compiles what it imports, a third of what there is; pip would compile all.
PIP := $(BIN)/python -m pip install --quiet --disable-pip-version-check --no-compile -c constraints.txt
STAMP := $(VENV)/.installed
# Kept, also where the environment says no: each process of the tests, and each command they start, would compile its libraries anew.
unexport PYTHONDONTWRITEBYTECODE
# Tests need more: their own tools, and the simulators of others in which our FMUs must run.
TESTING := $(VENV)/.installed-testing
WORKBENCH := $(VENV)/.installed-app
WRITING := $(VENV)/.installed-docs

# The rooms of `make test-ROOM`: about a minute each, without the tests that are marked as slow.
ROOM.models := tests/friction_models tests/contract --ignore=tests/friction_models/discovery --ignore=tests/contract/test_fmus.py
ROOM.discovery := tests/friction_models/discovery
ROOM.forming := tests/forming $(wildcard tests/analytic/test_forming_*.py)
ROOM.twin := tests/sct_twin $(wildcard tests/analytic/test_sct_*.py)
ROOM.fmus := tests/fmus tests/contract/test_fmus.py --ignore=tests/fmus/fuzz
ROOM.cosim := tests/orchestrator/cosim
ROOM.studies := tests/orchestrator/studies
ROOM.reports := tests/orchestrator/reports
ROOM.app := tests/orchestrator/app
ROOM.cli := tests/orchestrator/cli
ROOM.acceptance := tests/acceptance
ROOM.interop := tests/interop
ROOM.fuzz := tests/fuzz tests/fmus/fuzz
ROOM.docs := tests/documentation tests/packaging
ROOM.benchmarks := tests/benchmarks
ROOMS := $(patsubst ROOM.%,%,$(filter ROOM.%,$(.VARIABLES)))
# `make test-forming MARKED=` runs the slow tests, too.
MARKED ?= not slow and not nightly

.PHONY: install demo app monkey test test-nightly $(addprefix test-,$(ROOMS)) lint bench bench-literature bench-measured interop dist docs pictures verify clean
install: $(TESTING)

$(STAMP): pyproject.toml constraints.txt
	$(PY) -m venv $(VENV)
	$(PIP) -e '.[solvers,reports,cross,train-networks]'
	touch $@

$(WORKBENCH): $(STAMP)
	$(PIP) -e '.[solvers,reports,cross,train-networks,app]'
	touch $@

$(WRITING): $(STAMP)
	$(PIP) -e '.[solvers,reports,cross,train-networks,docs]'
	touch $@

# All at once: what the others need is part of it. Every package is known (constraints.txt), so two processes put them in place; what
# this machine has no wheel of is left to pip, which knows what is needed.
$(TESTING): pyproject.toml constraints.txt
	$(PY) -m venv $(VENV)
	xargs -P 2 -n 26 $(PIP) --no-deps < constraints.txt || echo "packages one after the other"
	$(PIP) -e '.[solvers,reports,cross,train-networks,daq,dev,docs,interop,cluster,app]'
	# Only to compare our reader of catman files with; what it depends on stays away.
	$(PIP) --no-deps --target build/apread apread==1.1.3 || echo "apread is not to be had: one test skips"
	touch $(STAMP) $(WORKBENCH) $(WRITING) $@

demo: $(STAMP)
	$(BIN)/tribofmu demo -o build/demo

# The workbench in the browser, on a small example project.
app: $(WORKBENCH)
	$(BIN)/tribofmu app build/example --example

# Random actions at the workbench: 1000 in the simulated browser, 300 in Chromium.
monkey: $(TESTING)
	TRIBOFMU_MONKEY=1000 TRIBOFMU_MONKEY_CLICKS=300 $(BIN)/python -m pytest tests/orchestrator/app/test_monkey.py

# One thread each: threads of several processes that wait for each other take many times as long. Three processes for two cores:
# tests wait for other programs, too.
# Modules in the order of their names: sorted by their number of tests, the few long ones would come last, one process idle.
PYTEST := OMP_NUM_THREADS=1 $(BIN)/python -m pytest -n 3 --dist loadscope --no-loadscope-reorder
test: $(TESTING)
	$(PYTEST) -m "not nightly" tests

# Longer searches for faults, sizes that nobody meets every day, and other seeds, families and kinds of what is proved by day.
test-nightly: $(TESTING)
	$(PYTEST) -m nightly tests

$(addprefix test-,$(ROOMS)): test-%: $(TESTING)
	$(PYTEST) -m "$(MARKED)" $(ROOM.$*)

lint: $(TESTING)
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy --num-workers 2
	$(BIN)/lint-imports

bench: $(TESTING)
	$(BIN)/python -m benchmarks -o docs/benchmarks.md

# 270 campaigns; `make bench-literature QUICK=--quick` runs 40 of them. An interrupted run goes on.
bench-literature: $(TESTING)
	$(BIN)/python -m benchmarks.literature $(QUICK)
	$(BIN)/python -m benchmarks --only literature

# The measurements are not part of the repository; without them nothing is written.
bench-measured: $(TESTING)
	$(BIN)/python -m benchmarks.measured -o docs/measured-data.md

interop: $(TESTING)
	$(BIN)/python -m tests.interop -o docs/interoperability.md

# The site: build/site/index.html. A warning or a dead link is an error.
docs: $(WRITING)
	$(BIN)/python -m sphinx -q -W --keep-going -b html -c docs . build/site

# Source and wheel, checked; the wheel is installed alone and does the main job.
dist: $(TESTING)
	rm -rf dist build/lib build/bdist.* *.egg-info
	$(BIN)/python -m build --outdir dist .
	$(BIN)/python -m twine check --strict dist/*
	$(BIN)/python -m tests.wheel_alone dist/*.whl

# Runs the tutorials and draws their pictures anew; needs Chromium.
pictures: $(TESTING)
	$(BIN)/python -m tests.documentation.walking

verify: $(TESTING)
	$(BIN)/tribofmu verify -o docs/verification.md

clean:
	rm -rf $(VENV) build .pytest_cache .mypy_cache .ruff_cache
