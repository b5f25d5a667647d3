# make demo   the main job: four Go1s in a square walk through the paper's arena, in physics
# make studio  the page in the browser, with the arena: build, drive and study teams
# make test   the suite, in the same environment: all that needs neither a browser nor ROS 2
# make venv   only the environment
# make test-fast  what a change needs at once: everything that takes no more than a moment
# make test-studio  the tests that look at the studio in Chromium
# make chromium  the browser for them, where root or sudo may install it
# make test-live  the tests that need ROS 2 or the SDK of Unitree, in an environment of their own
# make lint   ruff, mypy, the layers and the structure
# make docs  the documentation as a site, in site/
# make bench  timing against peers, and the start (scikit-fmm may need a C++ compiler)
# make evidence  the paper's scenarios and all campaigns, for hours; the runs so far are kept

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin
RUNS := runs
ROS := .venv-ros2
WORKERS ?= 2
PIP := $(BIN)/python -m pip --disable-pip-version-check install --quiet --constraint constraints.txt
INPUTS := pyproject.toml constraints.txt
CAMPAIGNS ?= clutter forest rooms corridors barn real-maps sizes disturbed events ablation \
             table1 swaps corridor crowd terrain infeasible \
             physics-walk physics-formation physics-plans physics-leaps

# Nothing is kept outside the checkout: an empty or missing home directory is fine.
export MPLCONFIGDIR ?= $(abspath $(VENV))/matplotlib

# Each of the tests' many processes would read all of the source anew.
unexport PYTHONDONTWRITEBYTECODE

.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.PHONY: help demo studio chromium test test-fast test-studio test-live venv lint docs bench evidence clean

help:
	@sed -n 's/^# make/make/p' Makefile

$(VENV)/.stamp: $(INPUTS)
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo "Cavalcade needs Python 3.11 or newer; name one with PYTHON=..."; exit 1; }
	@echo "Building the environment in $(VENV) (once) ..."
	@$(PYTHON) -m venv $(VENV)
	@$(PIP) --editable .
	@touch $@

$(VENV)/.stamp-%: $(VENV)/.stamp
	@echo "Adding what 'make $*' needs ..."
	@$(PIP) --editable '.[$*]'
	@touch $@

# The tests of campaigns on a cluster skip where Ray has no wheel for the platform.
$(VENV)/.stamp-test: $(VENV)/.stamp
	@echo "Adding what 'make test' needs ..."
	@$(PIP) --editable '.[test,cluster]' || $(PIP) --editable '.[test]'
	@touch $@

venv: $(VENV)/.stamp

demo: $(VENV)/.stamp-physics
	@$(BIN)/cavalcade run square-clutter --backend mujoco --out $(RUNS)/demo --force

studio: $(VENV)/.stamp-physics $(VENV)/.stamp-studio
	@$(BIN)/cavalcade studio square-clutter --open

# The tests' processes find the compiled kernels instead of each compiling its own.
test: $(VENV)/.stamp-test
	@$(BIN)/cavalcade warm --all
	@$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile \
		--no-loadscope-reorder --durations 5 -m "not browser"

test-studio: $(VENV)/.stamp-test
	@$(BIN)/cavalcade warm --all
	@$(BIN)/python -m pytest --durations 5 -m browser tests/studio

# Tests of the studio look at it in a real browser; where none can be had, they skip.
chromium:
	@for name in chromium chromium-browser google-chrome; do \
		! command -v $$name || exit 0; done; \
	as=; test "$$(id -u)" = 0 || as="sudo -n"; \
	if command -v apt-get > /dev/null && $$as true 2> /dev/null; then \
		echo "Installing Chromium ..."; \
		$$as apt-get update --quiet=2 && $$as env DEBIAN_FRONTEND=noninteractive \
			apt-get install --quiet=2 --yes --no-install-recommends chromium > /dev/null; \
	fi; \
	command -v chromium || echo "No Chromium: install it, or the studio's tests are skipped"

test-fast: $(VENV)/.stamp-test
	@$(BIN)/python -m pytest --numprocesses $(WORKERS) --dist loadfile \
		--no-loadscope-reorder -m "not slow and not browser"

# Wheels of rclpy start every Python of their environment twice: it is one of its own, on top of
# the other. Where there are none for the platform, the tests skip.
$(ROS)/.stamp: $(VENV)/.stamp-test
	@echo "Building the environment in $(ROS) (once) ..."
	@$(PYTHON) -m venv $(ROS)
	@$(BIN)/python -c 'import sysconfig as s; print("import site; site.addsitedir(%r)" % s.get_path("purelib"))' \
		> $$(echo $(ROS)/lib/python3*/site-packages)/cavalcade_tests.pth
	@for extra in ros2 unitree; do \
		$(BIN)/python -c 'import sys, tomllib; f = open("pyproject.toml", "rb"); \
		print(*tomllib.load(f)["project"]["optional-dependencies"][sys.argv[1]], sep="\n")' $$extra \
		> $(ROS)/requirements.txt; \
		$(ROS)/bin/python -m pip --disable-pip-version-check install --quiet \
		--constraint constraints.txt --requirement $(ROS)/requirements.txt || \
		echo "$$extra has no wheels for this platform: its tests are skipped"; done
	@-$(ROS)/bin/python -m pip --disable-pip-version-check install --quiet --only-binary :all: \
		--constraint constraints.txt far-unitree-sdk
	@touch $@

test-live: $(ROS)/.stamp
	@$(ROS)/bin/python -m pytest --durations 5 tests/live

lint: $(VENV)/.stamp-lint
	@$(BIN)/ruff check .
	@$(BIN)/ruff format --check .
	@$(BIN)/mypy
	@$(BIN)/lint-imports
	@$(BIN)/python tools/check_structure.py

docs: $(VENV)/.stamp-docs
	@NO_MKDOCS_2_WARNING=1 $(BIN)/python -m mkdocs build
	@echo "Built: site/index.html"

bench: $(VENV)/.stamp-bench
	@-$(PIP) --only-binary :all: eikonalfm
	@$(BIN)/python benchmarks/bench_eikonal.py
	@$(BIN)/python benchmarks/bench_cycle.py
	@$(BIN)/python benchmarks/bench_live_planner.py
	@$(BIN)/python benchmarks/bench_body.py
	@$(BIN)/python benchmarks/bench_startup.py
	@$(BIN)/python benchmarks/bench_waits.py

# A campaign that is there is gone on with; after a change of the code, remove $(RUNS)/evidence first.
# Exit code 1 of a campaign: its data are not there, or MuJoCo is not installed.
evidence: $(VENV)/.stamp
	@failed=; absent=; \
	$(BIN)/python benchmarks/paper_scenarios.py || failed=" paper_scenarios"; \
	for name in $(CAMPAIGNS); do \
		$(BIN)/cavalcade campaign $$name --out $(RUNS)/evidence/$$name --workers $(WORKERS) --resume; \
		case $$? in \
			0) ;; \
			1) absent="$$absent $$name" ;; \
			130) exit 130 ;; \
			*) failed="$$failed $$name" ;; \
		esac; \
	done; \
	$(BIN)/python benchmarks/results_table.py $$(dirname $(RUNS)/evidence/*/trials.parquet); \
	test -z "$$absent" || echo "Left out, their data or MuJoCo are not there:$$absent"; \
	test -z "$$failed" || { echo "Failed:$$failed"; exit 1; }

clean:
	rm -rf $(VENV) $(ROS) build dist site src/*.egg-info
