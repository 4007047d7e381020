# On a fresh machine, `make report` and `make test` do all the set-up; `make help` lists the rest.
PYTHON ?= python3
VENV := .venv
ifeq ($(OS),Windows_NT)
BIN := $(VENV)/Scripts
EXE := .exe
else
BIN := $(VENV)/bin
endif
SETUP := pyproject.toml constraints.txt
FUZZ_SECONDS ?= 600

.DEFAULT_GOAL := help
.PHONY: help report site pictures links check test lab data shapes train forecast grid bench mutate fuzz assignments lint types format clean system

help: ## list these targets
	@grep -hE '^[a-z]+:.*##' $(MAKEFILE_LIST) | sed -E 's/^([a-z]+):.*## /\1|/' | \
		while IFS='|' read -r name text; do printf '  make %-12s %s\n' "$$name" "$$text"; done

report: $(VENV)/report.done system ## run every experiment and typeset report/report.pdf
	OPENBLAS_NUM_THREADS=1 $(BIN)/python report/build.py

site: $(VENV)/site.done system ## build the site in report/site (to look at it: python -m http.server -d report/site)
	OPENBLAS_NUM_THREADS=1 $(BIN)/python report/pages/assemble.py

pictures: $(VENV)/report.done system ## draw README's pictures
	$(BIN)/python report/pictures/draw.py

links: $(VENV)/notebooks.done ## bring the links at the notebooks' beginnings up to pyproject.toml's addresses
	$(BIN)/python data_scripts/write_links.py

# On two busy cores, BLAS threads wait for each other.
check: lint types ## style, types and the numerical tests: less than a minute
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadgroup -m "not slow"

test: $(VENV)/test.done system ## run all tests
	OPENBLAS_NUM_THREADS=1 $(BIN)/python -m pytest -n 2 --dist loadgroup

mutate: $(VENV)/test.done ## plant small errors in the formulas, and see whether the tests find them
	OPENBLAS_NUM_THREADS=1 $(BIN)/python tests/mutation/mutate.py

lab: $(VENV)/notebooks.done system ## open the notebooks in JupyterLab
	$(BIN)/jupyter lab $$([ "$$(id -u)" = 0 ] && echo --allow-root) notebooks/00-start-here.ipynb

data: $(VENV)/report.done ## download the real meshes (MESHFAIR_MIRROR=DIR: copy them from there)
	$(BIN)/python data_scripts/fetch_meshes.py

shapes: $(VENV)/fast.done ## write the built-in shapes to data/
	$(BIN)/python data_scripts/write_shapes.py

train: $(VENV)/train.done ## train the learned filter anew (two hours), or go on where that was interrupted
	OPENBLAS_NUM_THREADS=1 $(BIN)/python data_scripts/train

forecast: $(VENV)/train.done ## train the choice between filters anew (two hours), or go on where that was interrupted
	OPENBLAS_NUM_THREADS=1 $(BIN)/python data_scripts/train/choices.py

grid: $(VENV)/report.done $(VENV)/fast.done ## compare the choices of methods and parameters on the grid (an hour), or go on where that was interrupted
	OPENBLAS_NUM_THREADS=1 $(BIN)/python data_scripts/grid.py

bench: LISTS := apt.txt apt-bench.txt
bench: $(VENV)/bench.done system ## measure times and memory beside other libraries (a quarter of an hour)
	$(BIN)/python tests/benchmarks/bench.py

fuzz: $(VENV)/test.done ## try the readers on random bytes for ten minutes (FUZZ_SECONDS=N)
	MESHFAIR_FUZZ_SECONDS=$(FUZZ_SECONDS) $(BIN)/python -m pytest tests/test_io.py -k random_bytes

assignments: $(VENV)/grading.done ## make the students' versions of the assignments
	$(BIN)/python -m meshfair_grading.generate

lint: $(VENV)/test.done ## check the code's style
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .

types: $(VENV)/test.done ## check the code's types
	$(BIN)/mypy

format: $(VENV)/test.done ## bring the code into the project's style
	$(BIN)/ruff check --fix .
	$(BIN)/ruff format .

clean: ## remove the virtual environment and all that was built
	rm -rf $(VENV) report/build report/report.pdf report/site report/site-build data

# One stamp for each group of dependencies: what is installed is not installed again.
$(VENV)/%.done: $(SETUP) | $(BIN)/python$(EXE)
	$(BIN)/python -m pip install --quiet --disable-pip-version-check \
		--constraint constraints.txt --editable '.[$*]'
	@touch $@

$(BIN)/python$(EXE):
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
		{ echo 'meshfair needs Python 3.11 or newer; set PYTHON=python3.11, say'; exit 1; }
	$(PYTHON) -m venv $(VENV)

# Libraries to draw without a screen (and that make bench measures): installed where that needs no questions, named where not.
LISTS := apt.txt
system:
	@missing=$$(sh data_scripts/missing_packages.sh $(LISTS)); \
	if [ -z "$$missing" ]; then :; \
	elif [ "$$(id -u)" = 0 ]; then \
		echo "installing Debian packages: $$missing"; \
		apt-get -qq update && DEBIAN_FRONTEND=noninteractive \
			apt-get -qq install --no-install-recommends $$missing >/dev/null || \
			echo "they could not be installed; what needs them is done without"; \
	else \
		echo "for all that can be drawn or measured: sudo apt-get install" $$missing; \
	fi
