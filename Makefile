# Every recipe runs in this folder with relative names, so a space in the path to it does no harm.
SHELL := /bin/sh
.DEFAULT_GOAL := help
.DELETE_ON_ERROR:
.SUFFIXES:
MAKEFLAGS += --no-print-directory

PYTHON ?= python3
BIN := .venv/bin
EXAMPLES := $(basename $(notdir $(wildcard examples/*.fz)))

# An environment is made anew in a moved checkout, without its Python, or where PYTHON asks for another version.
ifneq ($(shell .venv/bin/python -c '' 2>/dev/null && cat .venv/made-in 2>/dev/null),$(CURDIR))
.PHONY: .venv/made-in
else ifneq ($(origin PYTHON),file)
ifneq ($(shell "$(PYTHON)" -V 2>&1),$(shell .venv/bin/python -V 2>&1))
.PHONY: .venv/made-in
endif
endif

.PHONY: help demo test lint pytest gates test-long wheel generated bench fit limits campaign fuzz prove prove-choices mutants mutants-python clean compiler

help: ## this list
	@awk -F ':.*## ' '/^[a-z-]+:.*## /{printf "  make %-14s %s\n", $$1, $$2}' Makefile
	@echo "  make ... PYTHON=/path/to/python3   with another Python (3.11 or later)"

demo: .venv/for-demo ## compile nav.fz, verify it, run the paper's two robots under the generated C
	@$(BIN)/python scripts/demo.py out

test: lint pytest ## ruff, mypy, the import contract and the tests: under ten minutes

lint: .venv/for-test
	@$(BIN)/python -m ruff check --quiet
	@$(BIN)/python -m ruff format --check
	@$(BIN)/python -m mypy
	@$(BIN)/lint-imports --no-logo

pytest: .venv/for-test
	@$(BIN)/python -m pytest -n auto -m "not long and not gate"

gates: .venv/for-test ## what CI runs besides: proofs, mutants, coverage, a hundred random specs: twenty minutes
	@$(BIN)/python -m pytest -n auto -m "gate and not long"

test-long: .venv/for-test lint wheel ## everything: also the tests that take minutes and an installed wheel
	@$(BIN)/python -m pytest -n auto

wheel: .venv/for-test ## build the wheel, install it into an empty environment, compile from another folder
	@$(BIN)/python scripts/try_wheel.py

generated: .venv/for-test ## bring generated/ up to date with the examples, and the parser's table with the grammar
	@$(BIN)/python -m fuzzyspec.syntax.generate
	@for name in $(EXAMPLES); do $(BIN)/fuzzyc compile "examples/$$name.fz" -o "generated/$$name" || exit $$?; done

bench: .venv/for-bench ## measure cost and error beside lookup tables, float C and libraries; write docs/benchmarks.md
	@$(BIN)/python -m benchmarks --json out/benchmarks.json

fit: .venv/for-test ## measure what has changed of the cost model's training set, and fit its weights: minutes
	@$(BIN)/python -m scripts.fit_costs

limits: .venv/for-test ## measure how near the generated C comes to the counted limit; write the tables of docs/limit.md
	@$(BIN)/python -m scripts.limits

N ?= 1000
campaign: .venv/for-test ## a thousand random specs and ten times as many damaged ones (N, from SEED on): hours
	@$(BIN)/python -m tests.random_specs.campaign --specs $(N) --mutants $(N)0 --seed $(or $(SEED),0)

RUNS ?= 1000000
fuzz: .venv/for-fuzz ## a million inputs (RUNS, from SEED on) through parser and checker, guided by coverage: an hour
	@$(BIN)/python -m tests.breaking.fuzz --runs $(RUNS) --seed $(or $(SEED),1) --jobs 2

prove: .venv/for-test ## prove the C of the examples, benchmarks and ten random specs (or SPECS) free of alarms (Frama-C): a quarter of an hour
	@$(BIN)/python -m scripts.prove_all $(SPECS)

prove-choices: .venv/for-test ## the same for every C that goals and targets choose, some of which keeps alarms: hours
	@$(BIN)/python -m scripts.prove_all --choices $(SPECS)

SAMPLE ?= 0
mutants: .venv/for-test ## all mutants of generated C (SAMPLE of each file) against fuzzyc verify, with the score: hours
	@$(BIN)/python -m tests.mutation --sample $(SAMPLE)

mutants-python: .venv/for-test ## mutants of the compiler (SAMPLE of a package, else 75) against its tests: an hour
	@$(BIN)/python -m tests.mutation.python_mutants $(if $(filter-out 0,$(SAMPLE)),--sample $(SAMPLE))

clean: ## remove what make made, .venv too
	rm -rf .venv out build dist .mypy_cache .pytest_cache .ruff_cache .import_linter_cache .hypothesis

# --- the environment -------------------------------------------------------------------------

.venv/made-in:
	@command -v "$(PYTHON)" >/dev/null 2>&1 || \
	  { echo "fuzzyc: '$(PYTHON)' was not found: install Python 3.11 or later, or run make with PYTHON=/path/to/python3" >&2; exit 1; }
	@"$(PYTHON)" -c 'import sys; sys.exit(sys.version_info < (3, 11))' || \
	  { echo "fuzzyc: '$(PYTHON)' is older than Python 3.11: run make with PYTHON=/path/to/a/newer/python3" >&2; exit 1; }
	@"$(PYTHON)" -c 'import venv, ensurepip' 2>/dev/null || \
	  { echo "fuzzyc: '$(PYTHON)' has no venv module: install it (Debian, Ubuntu: apt install python3-venv)" >&2; exit 1; }
	@echo "making .venv"
	@rm -rf .venv
	@"$(PYTHON)" -m venv .venv
	@pwd > $@

compiler: .venv/made-in
	@for name in $$CC gcc clang cc; do command -v "$$name" >/dev/null 2>&1 && exit 0; done; \
	  $(BIN)/python -c 'import ziglang' 2>/dev/null || \
	  { echo "fuzzyc: no C compiler was found: install gcc or clang (Debian, Ubuntu: apt install gcc), or run: $(BIN)/pip install ziglang" >&2; exit 1; }

.venv/for-demo: .venv/made-in pyproject.toml constraints.txt | compiler
	@echo "installing fuzzyc into .venv"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[sim]'
	@touch $@

.venv/for-test: .venv/made-in pyproject.toml constraints.txt | compiler
	@echo "installing fuzzyc and what its tests need into .venv"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[sim,test]'
	@touch $@ .venv/for-demo

.venv/for-bench: .venv/made-in pyproject.toml constraints.txt | compiler
	@echo "installing fuzzyc and what its benchmarks need into .venv"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[bench]'
	@touch $@

.venv/for-fuzz: .venv/made-in pyproject.toml constraints.txt
	@echo "installing fuzzyc and what its fuzzer needs into .venv"
	@$(BIN)/python -m pip install --quiet --disable-pip-version-check -c constraints.txt -e '.[fuzz]'
	@touch $@
