# `make bench` and `make test` set up their own virtual environment; nothing else is needed but python3 >= 3.11, venv and make.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

.PHONY: bench test lint docs benchmark clean

bench: $(VENV)/.ready
	$(BIN)/ods bench --config config/bench.toml

test: $(VENV)/.ready lint
	$(BIN)/pytest -n 2 --dist loadfile --ignore=tests/test_chain.py
	$(BIN)/pytest tests/test_chain.py

lint: $(VENV)/.ready
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

$(VENV)/.ready: pyproject.toml constraints.txt
	$(PYTHON) -m venv $(VENV)
	$(BIN)/pip install --quiet --disable-pip-version-check -c constraints.txt -e .[dev]
	touch $@

docs: $(VENV)/.ready
	$(BIN)/python -m ods.reference docs

benchmark: $(VENV)/.ready
	$(BIN)/python -m benchmarks.pipeline
	$(BIN)/python -m benchmarks.tracker
	$(BIN)/python -m benchmarks.sonar_link --seconds 60

clean:
	rm -rf $(VENV) out
