# `make bench` and `make test` set up their own virtual environment; nothing else is needed but python3 >= 3.11 with its venv and
# headers, a C compiler and make.

PYTHON ?= python3
# bytecode is kept, of the tests' and the packages' modules too: hundreds of processes that tests start compile nothing
export PYTHONDONTWRITEBYTECODE =
export PYTHONPYCACHEPREFIX = $(CURDIR)/out/bytecode
VENV := .venv
BIN := $(VENV)/bin

CONFIG := config/onboard.toml
VCAN = tests/vcan --ignore=tests/vcan/test_integrator.py

.PHONY: bench bench-rough bench-avoid bench-vcan test coverage test-vcan test-missions test-systemd peers test-peers lint npm chromium hooks docs site benchmark soak kernels sanitize findings wheel client release install install-program uninstall clean

bench: kernels
	$(BIN)/ods bench --config config/bench.toml

# the bench over a rough sea-bed
bench-rough: kernels
	$(BIN)/ods bench --config config/bench-rough.toml

# the bench with a planner in the loop: the simulated vehicle goes as it says
bench-avoid: kernels
	$(BIN)/ods bench --config config/bench-avoid.toml

# the bench where vcan0 is: on this host or in a guest kernel, see docs/bench/vcan.md
bench-vcan: kernels
	$(BIN)/python -m in_vcan --timeout 1800 $(BIN)/ods bench --config config/bench-vcan.toml

QUICK = $(BIN)/pytest -n 3 --dist loadfile --ignore=tests/whole_chain -m "not slow"

test: $(VENV)/.ready
	$(MAKE) kernels
	$(MAKE) -j 2 lint test-quick
	$(MAKE) -j 2 test-chain test-vcan

.PHONY: test-quick test-chain
test-quick: $(VENV)/.ready
	$(MAKE) kernels
	$(QUICK)

# in real time, as those on a CAN bus: they wait more than they compute
test-chain: $(VENV)/.ready
	$(MAKE) kernels
	$(BIN)/pytest tests/whole_chain/test_chain.py

# which lines no test ran, processes started by tests included
coverage: $(VENV)/.ready
	$(MAKE) kernels
	$(QUICK) --cov --cov-report=
	$(BIN)/coverage report

# 125: no vcan to be had, and the reason was said; the tests are then reported as skipped, or failed for ODS_REQUIRE_VCAN
test-vcan: $(VENV)/.ready
	$(BIN)/python -m in_vcan --timeout 900 $(BIN)/pytest $(VCAN) || { [ $$? -eq 125 ] && $(BIN)/pytest $(VCAN); }

# what takes too long for every change: CI runs it after `make test`. Three workers on two processors are too many for what
# judges rates, and whole chains run one at a time, as they judge latencies
test-missions: $(VENV)/.ready
	$(MAKE) kernels
	$(BIN)/pytest -n 2 --dist loadfile --ignore=tests/whole_chain -m slow
	$(BIN)/pytest tests/whole_chain --ignore=tests/whole_chain/test_chain.py
	$(MAKE) test-vcan VCAN=tests/vcan/test_integrator.py

# stock nodes of ROS 2 Jazzy and Kilted, of wheels for Python 3.11, in environments of their own: they exclude each other
PEERS = jazzy kilted
peers: $(PEERS:%=out/peers/%/.ready)

out/peers/%/.ready: tests/peers/%.txt
	$(PYTHON) -m venv out/peers/$*
	out/peers/$*/bin/pip --quiet --disable-pip-version-check install -r $<
	touch $@

# the bridge to ROS 2 against them; no part of CI
test-peers: $(VENV)/.ready peers
	ODS_REQUIRE_PEERS=1 $(BIN)/pytest tests/peers

# `make install` on a real Debian with a real systemd: as root, on Debian, x86-64; CONTRIBUTING.md says when
test-systemd: $(VENV)/.ready
	$(BIN)/pytest tests/systemd

# surprises about the libraries and formats of others, each on its own: fetches their packages; no part of CI
findings:
	@failed=0; for one in findings/*.sh; do \
	  if said=$$(sh $$one 2>&1); then echo "pass $$one"; else echo "FAIL $$one: $$(echo "$$said" | tail -n 1)"; failed=1; fi; \
	done; exit $$failed

lint: $(VENV)/.ready
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/lint-imports

# what `make bench` needs, and what all else does; without build isolation numpy is not fetched twice
PIP = $(BIN)/python -m pip --quiet --disable-pip-version-check install --no-compile -c constraints.txt
KERNELS = ods/compiled/native.abi3.so

define environment
	@echo "making a virtual environment in $(VENV), with all that $(1) needs"
	$(PYTHON) -m venv $(VENV)
	$(PIP) setuptools numpy
	@echo "installing ODS: its kernels are compiled"
	$(PIP) --no-build-isolation -e .[$(1)]
endef

$(VENV)/.bench: pyproject.toml setup.py constraints.txt
	$(call environment,bench)
	touch $@

# a target that needs it calls for the kernels in its recipe: side by side the two would install at the same time
$(VENV)/.ready: pyproject.toml setup.py constraints.txt
	$(call environment,dev)
	touch $(VENV)/.bench $@

# the readers of Foxglove and Lichtblick, for tests/export/test_by_node.py
npm:
	npm install --silent --no-audit --no-fund --no-package-lock --fetch-retries 2 --fetch-timeout 30000 --prefix out/npm @mcap/core@2.2.2 @mcap/support@1.1.0 \
	  @foxglove/rosmsg@5.0.5 @foxglove/rosmsg2-serialization@3.1.0

# the browser of tests/workbench/browser; installed by root, on Debian. ODS_REQUIRE_BROWSER=1 makes a miss a failure
chromium:
	{ command -v chromium && command -v chromedriver; } >/dev/null || [ $$(id -u) -ne 0 ] || { apt-get update -q && apt-get install -y -q --no-install-recommends chromium chromium-driver; }

# the checks of `make lint` before each commit
hooks: $(VENV)/.ready
	$(BIN)/pre-commit install

# the C kernels, anew where one has changed
kernels: $(VENV)/.bench $(KERNELS)

$(KERNELS): $(shell find ods -name '*.[ch]') setup.py | $(VENV)/.bench
	$(BIN)/python setup.py --quiet build_ext --inplace
	touch $@

# tests of the kernels, built with gcc's checks of addresses and of undefined behaviour, in a copy of the sources; some ten minutes.
# What is found ends the tests. New memory is filled, so that reading it before it is written gives wrong results. Freed memory
# is held back, so the one test that measures it is left out
SANITIZED = out/sanitized
SANITIZE = -fsanitize=address,undefined,float-cast-overflow -fno-omit-frame-pointer
SANITIZED_TESTS = tests/compiled tests/pipeline tests/tracker tests/sim_sonar
runtime_of = $(shell $(CC) -print-file-name=$(1))

sanitize: $(VENV)/.ready
	rm -rf $(SANITIZED) && mkdir -p $(SANITIZED)
	git ls-files -z | xargs -0 cp --parents --no-dereference --target-directory=$(SANITIZED)
	cd $(SANITIZED) && ODS_CFLAGS="$(SANITIZE) -O1 -g -DKEPT_BYTES=0" LDFLAGS="$(SANITIZE)" $(CURDIR)/$(BIN)/python setup.py --quiet build_ext --inplace
	cd $(SANITIZED) && PYTHONPATH=$(CURDIR)/$(SANITIZED) LD_PRELOAD="$(call runtime_of,libasan.so) $(call runtime_of,libstdc++.so)" \
	  ASAN_OPTIONS=detect_leaks=0:max_malloc_fill_size=1000000000:log_path=$(CURDIR)/$(SANITIZED)/found \
	  UBSAN_OPTIONS=halt_on_error=1:print_stacktrace=1:log_path=$(CURDIR)/$(SANITIZED)/found \
	  $(CURDIR)/$(BIN)/pytest -p no:cacheprovider --timeout=1800 -m "not slow" $(SANITIZED_TESTS) \
	    --deselect tests/compiled/test_binding.py::test_scratch_memory_is_given_back || { cat found*; exit 1; }

# dist/*.whl, for `pip install` on board; build/ would bring in what was deleted since
wheel: $(VENV)/.ready
	rm -rf build dist
	$(BIN)/pip wheel --quiet --disable-pip-version-check --no-deps --wheel-dir dist .
	rm -rf build

# dist/ods_client-*.whl, for a planner's computer: of a copy, as setuptools leaves files beside what it builds
client: $(VENV)/.bench
	rm -rf out/client && mkdir -p out/client
	git ls-files -z ods client | xargs -0 cp --parents --no-dereference --target-directory=out/client
	$(BIN)/pip wheel --quiet --disable-pip-version-check --no-build-isolation --no-deps --wheel-dir dist out/client/client

# dist/ as it is published: of what is committed, with the wheel built from the source distribution, as others will
release: $(VENV)/.ready
	@test -z "$$(git status --porcelain)" || { echo "make release: what is not committed would be left out"; exit 1; }
	rm -rf out/release dist && git clone --quiet . out/release
	$(BIN)/python -m build --no-isolation --outdir dist out/release > out/release.log 2>&1 || { tail -n 20 out/release.log; exit 1; }
	$(MAKE) client
	rm -rf out/release out/release.log out/client
	@ls dist

# on board, as root: docs/installation.md
PREFIX := /opt/ods
INSTALL = @env -u PYTHONDONTWRITEBYTECODE -u PYTHONPYCACHEPREFIX PREFIX=$(PREFIX) PYTHON=$(PYTHON) CONFIG=$(CONFIG) WHEEL=$(WHEEL) deploy/install.sh

install:
	$(INSTALL)

install-program:
	$(INSTALL) program

uninstall:
	@PURGE=$(PURGE) deploy/uninstall.sh

docs: $(VENV)/.ready
	$(BIN)/python -m ods.reference docs

site: $(VENV)/.ready
	NO_MKDOCS_2_WARNING=1 $(BIN)/mkdocs build --strict

benchmark: $(VENV)/.ready
	$(BIN)/python -m benchmarks.detection.speed
	$(BIN)/python -m benchmarks.c_chain
	$(BIN)/python -m benchmarks.tracker
	$(BIN)/python -m benchmarks.processes.sonar_link --seconds 60
	$(BIN)/python -m benchmarks.processes.nav
	$(BIN)/python -m benchmarks.processes.nav --source dbc

# an hour of the bench with faults at random times: what was valid and wrong, what grew
soak: $(VENV)/.ready
	$(MAKE) kernels
	$(BIN)/python -m benchmarks.processes.soak --minutes 60 --seed 0

clean:
	rm -rf $(VENV) out build dist
