# make reproduce   the paper's three simulations and every rival: pictures, honest tables, a page, in reproduce/
# make test        everything that must hold
# make robot       the Panda in MuJoCo with an unknown payload: every controller, tables and pictures, in robot/
# make robots      the chosen controllers on all robots and in all cases, and ten seeds, in robots/: takes long
# make which       the tables and pictures of "Which controller?" in the manual, in docs/which: ten minutes
# make bench       speed: criterion benches, and the Python peers, every claim with its verdict; writes
#                  benches/results/<processor>.csv (`python benches/claims.py`: the smallest ratios of all of them)
# make bench-dynamics   speed of the dynamics against Pinocchio and dynibo (compiles Pinocchio's headers: minutes)
# make docs        the manual, in docs/_build/html
# make docs-check  the manual built anew, and every page of it opened in Chromium without a network
# make setup-debian   Chromium, which docs-check wants, from Debian: the only target that calls apt
# make reliability the table of docs/reliability.md, from a run of its tests
# make house       sizes and tangles of the code, counted
# make sweep-kills workers and clients of sweeps killed at twenty random moments each: processes, Dask, Ray
# make cortex      the core on an emulated Cortex-M7: the same torques, stack, instructions a step
# make check-all   all of that which can fail: test, reproduce, robot, docs, the bits of AArch64 and the Cortex-M7 where
#                  they can be run, and what the benches compare, but no verdict on speed; what it prints is in check-all.log too
#
# Needs Rust >= 1.89, Python >= 3.11 and make; all else comes from the package registries.

PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
CARGO  ?= cargo
OUT    ?= reproduce
NO_STD := --no-default-features --features libm

SOURCES := $(shell find src python -name '*.rs' -o -name '*.py' -o -name '*.pyi') Cargo.toml Cargo.lock pyproject.toml README.md

.PHONY: reproduce robot robots which test test-crate test-rust test-python lint no-std bits bits-aarch64 cortex reliability bench bench-dynamics docs docs-check setup-debian release-check house same-work sweep-kills check-all clean

reproduce: $(VENV)/wheel
	$(BIN)/steadyarm reproduce --out $(OUT)

robot: $(VENV)/wheel $(VENV)/tools
	$(BIN)/python examples/mujoco_payload.py --out robot
	$(BIN)/python examples/mujoco_bench.py --out robot

which: $(VENV)/wheel $(VENV)/tools
	$(BIN)/python examples/mujoco_bench.py --page docs/which

robots: $(VENV)/wheel $(VENV)/tools
	$(BIN)/python examples/mujoco_bench.py --full --out robots
	$(BIN)/python examples/mujoco_bench.py --seeds 10 --case base noise drop gain --only recommended --out robots/seeds

# The wheel takes minutes of one core: it is built, and tested, beside the tests of the crate. These are compiled once,
# and not for a debugger: a sixth less of the compiler's time.
test: export CARGO_INCREMENTAL := 0
test: export CARGO_PROFILE_TEST_DEBUG := false
test: $(VENV)/tools
	$(MAKE) --jobs=2 test-python test-crate

# One after the other, as cargo would wait for itself.
test-crate:
	$(MAKE) --jobs=1 lint test-rust no-std bits

lint: $(VENV)/tools
	$(CARGO) fmt --check
	$(CARGO) clippy --locked -- -D warnings
	$(CARGO) clippy --locked $(NO_STD) -- -D warnings
	PYO3_PYTHON=$(CURDIR)/$(BIN)/python $(CARGO) clippy --locked --all-targets --all-features -- -D warnings
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --no-deps
	RUSTDOCFLAGS="-D warnings" $(CARGO) doc --locked --no-deps $(NO_STD)
	RUSTDOCFLAGS="-D warnings" PYO3_PYTHON=$(CURDIR)/$(BIN)/python $(CARGO) doc --locked --no-deps --all-features
	$(BIN)/ruff format --check python tests benches examples
	$(BIN)/ruff check python tests benches examples

# Examples are run by tests, and compiled by lint.
test-rust:
	$(CARGO) test --locked --lib --tests
	$(CARGO) test --locked --doc
	$(CARGO) test --locked $(NO_STD) --lib --tests

no-std:
	sh tests/no_std/link.sh

bits:
	sh tests/bits/run.sh

bits-aarch64:
	sh tests/bits/aarch64.sh

cortex:
	sh tests/no_std/cortex.sh

reliability: $(VENV)/wheel $(VENV)/tools
	$(BIN)/python tests/reliability.py

test-python: $(VENV)/wheel $(VENV)/tools
	$(BIN)/python -m mypy
	cd tests/python && ../../$(BIN)/python -m mypy.stubtest steadyarm --allowlist stubtest-allowlist.txt
	cd tests/python && ../../$(BIN)/python -m pytest -c ../../pyproject.toml --numprocesses=2 --dist=loadfile --no-loadscope-reorder .

# All programs run, even if a claim falls short.
bench: $(VENV)/wheel $(VENV)/peers
	$(CARGO) bench --locked
	@failed=0; for program in results.py compare.py "many.py --full" rivals.py recommended.py view.py; do \
	  $(BIN)/python benches/$$program || failed=1; \
	done; exit $$failed

bench-dynamics: $(VENV)/wheel $(VENV)/peers
	$(CARGO) bench --locked --bench dynamics
	$(BIN)/python benches/compare_dynamics.py

docs: $(VENV)/wheel $(VENV)/manual
	$(BIN)/python -m sphinx -W --keep-going -b html docs docs/_build/html
	@echo "The manual is in docs/_build/html/index.html"

release-check: $(VENV)/release
	$(BIN)/python tests/release_check.py

# The Python blocks of the pages run with the tests of the pages; the notebooks with the build.
docs-check: docs $(VENV)/tools $(VENV)/docs-check
	cd tests/python && ../../$(BIN)/python -m pytest -c ../../pyproject.toml test_docs.py
	$(BIN)/python docs/check.py --self-test
	$(BIN)/python docs/check.py

setup-debian:
	apt-get update
	apt-get install --yes --no-install-recommends chromium

house:
	@$(PYTHON) tests/house.py

# That the benches compare the same work to the same accuracy, with all their programs run once or twice.
same-work: $(VENV)/wheel $(VENV)/peers
	$(CARGO) bench --locked -- --test
	$(BIN)/python benches/compare.py --quick
	$(BIN)/python benches/many.py --quick
	$(BIN)/python benches/friction_accuracy.py

sweep-kills: $(VENV)/wheel $(VENV)/tools $(VENV)/cluster
	cd tests/python && STEADYARM_KILLS=20 ../../$(BIN)/python -m pytest -c ../../pyproject.toml test_sweep_kills.py

# The mark tells whether all went well: tee hides the exit code.
check-all:
	@rm -f target/check-all.passed && mkdir -p target
	@{ date; $(MAKE) test bits-aarch64 cortex reproduce robot docs same-work sweep-kills && date && touch target/check-all.passed; } 2>&1 | tee check-all.log
	@rm target/check-all.passed && echo "All passed; check-all.log has it."

# The environment, and the wheel as `pip install .` builds it.

$(VENV)/python:
	$(PYTHON) -m venv $(VENV)
	$(BIN)/python -m pip install --quiet --upgrade pip
	@touch $@

$(VENV)/wheel: $(SOURCES) | $(VENV)/python
	$(BIN)/python -m pip install --quiet ".[plot]"
	@touch $@

# What the tests, the comparison and the manual need beside the wheel: the dependency groups of pyproject.toml.
$(VENV)/tools: GROUP := test
$(VENV)/peers: GROUP := bench
$(VENV)/manual: GROUP := docs
$(VENV)/release: GROUP := release
$(VENV)/docs-check: GROUP := docs-check
$(VENV)/cluster: GROUP := cluster
$(VENV)/tools $(VENV)/peers $(VENV)/manual $(VENV)/release $(VENV)/docs-check $(VENV)/cluster: pyproject.toml | $(VENV)/python
	$(BIN)/python -m pip install --quiet --group $(GROUP)
	@touch $@

clean:
	rm -rf $(VENV) target docs/_build robot robots $(OUT)
