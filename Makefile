# People and CI run the same verbs; `make` lists them.
VENV   := .venv
PYTHON := $(VENV)/bin/python
CBPT   := $(VENV)/bin/cbpt
OUT    := out
CRATES := $(OUT)/crates
export CARGO_TARGET_DIR := $(CURDIR)/target
# Cargo chooses the features of dependencies by what it is asked to build. With --examples, of which there are none, they are
# those of the tests: nothing is compiled twice.
RUSTDOC := RUSTDOCFLAGS='-D warnings' cargo doc --workspace --lib --examples --no-deps --quiet
export PIP_DISABLE_PIP_VERSION_CHECK := 1
# Python compiles what is imported; pip would compile all that is installed, for as long as the installation takes.
export PIP_NO_COMPILE := 1
# Two processes on two cores, so none of them needs threads for linear algebra.
PYTEST := OPENBLAS_NUM_THREADS=1 $(PYTHON) -m pytest -n 2 --dist worksteal

.PHONY: help build demo test plain rust lint pytest python package wheel wheels audit fuzz mutants bench test-long trial trial-short instructions setup-browser screenshots docs format clean
help:  ## this list
	@grep -E '^[a-z-]+:.*##' $(MAKEFILE_LIST) | sed -E 's/:.*## /\t/' | expand -t 10

$(VENV)/installed: pyproject.toml
	python3 -c 'import sys; sys.exit(sys.version_info < (3, 11) and "Python 3.11 or later is needed")'
	python3 -m venv $(VENV)
	$(PYTHON) -m pip install -q --upgrade pip
	$(PYTHON) -m pip install -q 'maturin>=1.12,<2' 'numpy>=1.26' 'scipy>=1.12' 'matplotlib>=3.8'
	touch $@

build: $(VENV)/installed  ## release build into .venv: the cbpt command and the Python package
	PIP_QUIET=1 $(VENV)/bin/maturin develop --release --generate-stubs

demo: build  ## the main job on bundled input
	@$(PYTHON) examples/demo.py $(OUT)

test: pytest rust lint package  ## everything that CI checks

# What rust compiles anyway. pytest needs it, and would wait for the lints to let go of the build directory.
plain:  # the plain binary, whose answers the package's are compared with
	cargo build --quiet --workspace --bin cbpt --examples

rust: plain  ## format, lints, tests and documentation of the Rust crates
	cargo fmt --all --check
	cargo clippy --workspace --lib --bins --examples --tests -- -D warnings
	cargo test --workspace --quiet
	$(RUSTDOC)

$(VENV)/tested: $(VENV)/installed
	$(PYTHON) -m pip install -q --group test
	touch $@

setup-browser: $(VENV)/tested  ## Debian's Chromium for the tests of the page: by apt-get, where this is root's shell
	@command -v chromium || if [ "$$(id -u)" = 0 ] && command -v apt-get >/dev/null; \
	then apt-get update -qq && apt-get install -y -qq --no-install-recommends chromium >/dev/null && chromium --version; \
	else echo 'No Chromium and not root: the browser tests will be skipped (apt-get install chromium).'; fi

python: lint pytest  ## lints, types, stubs and tests of the Python package

lint: build $(VENV)/tested
	$(VENV)/bin/deno fmt --check --quiet
	$(VENV)/bin/deno lint --quiet
	$(VENV)/bin/deno check --quiet python/cbpt/page/web
	$(VENV)/bin/ruff check
	$(VENV)/bin/ruff format --check
	$(VENV)/bin/mypy
	git diff --exit-code -- python/cbpt/_core.pyi  # the stub is the build's own
	$(PYTHON) -m mypy.stubtest --mypy-config-file .ci/stubtest.ini cbpt._core

# While one test waits for a browser or a process, the compilers go on: in CI this begins with them, not after them.
pytest: build plain $(VENV)/tested
	$(PYTEST)

test-long: build $(VENV)/tested  ## some claims of the tests on more cases than `make test` has time for
	$(PYTEST) -m long

# As the tests of the workspace have the dependencies: most are compiled already.
package: export CARGO_PROFILE_DEV_DEBUG := line-tables-only
package: build  ## a program outside the workspace on the crates as published, the wheel in an empty environment
	# Unpacked anew (-m) and built here: by version and date cargo takes an earlier cbpt-core for this one. One workspace has
	# one choice of features: core and dependencies are compiled once for the program and for the command line.
	rm -rf target/package $(CRATES) && mkdir -p $(CRATES)/embed
	cargo package --quiet --allow-dirty --no-verify -p cbpt-core -p cbpt-cli
	for crate in target/package/cbpt-*.crate; do tar -xzmf $$crate -C $(CRATES) || exit; done
	cp -r examples/embed/src $(CRATES)/embed && cp Cargo.lock $(CRATES)
	sed -e '/^\[workspace\]/d' -e 's/path = "[^"]*"/version = "*"/' examples/embed/Cargo.toml > $(CRATES)/embed/Cargo.toml
	cd $(CRATES) && printf '[workspace]\nresolver = "3"\nmembers = ["*/"]\n[patch.crates-io]\ncbpt-core.path = "%s"\n' cbpt-core-* > Cargo.toml
	cd $(CRATES) && cargo build --quiet --workspace --lib --bin embed
	$(CARGO_TARGET_DIR)/debug/embed
	rm -rf $(OUT)/wheel $(OUT)/empty && mkdir -p $(OUT)
	$(VENV)/bin/maturin build --release --quiet --out $(OUT)/wheel
	python3 -m venv $(OUT)/empty
	$(OUT)/empty/bin/python -m pip install -q $(OUT)/wheel/cbpt-*.whl
	cd $(OUT) && empty/bin/python ../examples/smoke.py

wheel: build  ## the wheel, into dist/
	$(VENV)/bin/maturin build --release --out dist

$(VENV)/wheeled: $(VENV)/installed
	$(PYTHON) -m pip install -q --group wheels
	touch $@

wheels: $(VENV)/wheeled  ## wheels for Linux (x86_64, aarch64; glibc, musl) and the sdist, into dist/; run where this machine can
	$(PYTHON) .ci/wheels.py

$(VENV)/audited: $(VENV)/installed
	$(PYTHON) -m pip install -q --group audit
	touch $@

audit: $(VENV)/audited  ## licences, sources, duplicates and weaknesses of the crates; the workflows; the API against the last tag (cargo-deny, zizmor, cargo-semver-checks)
	$(VENV)/bin/zizmor --offline --quiet .github/workflows
	cargo deny --log-level error check licenses bans sources
	cargo deny --log-level error check advisories || echo 'advisories: not checked, or something was found (see above)'
	if tag=$$(git describe --tags --abbrev=0 2>/dev/null); \
	then cargo semver-checks --baseline-rev $$tag -p cbpt-core -p cbpt-cli; else echo 'No tag yet: no API to compare with.'; fi

FUZZ_SECONDS ?= 600
fuzz: build $(VENV)/tested  ## parsers and readers on edited seeds, FUZZ_SECONDS (600) for each; what fails is kept in tests/data/corpus
	FUZZ_SECONDS=$(FUZZ_SECONDS) cargo test --release --quiet -p cbpt-cli --test fuzz -- --nocapture
	FUZZ_SECONDS=$(FUZZ_SECONDS) $(PYTHON) -m pytest -s tests/readings/test_fuzz.py

$(VENV)/mutated: $(VENV)/tested
	$(PYTHON) -m pip install -q --group mutants
	touch $@

SHARD ?= 0/20
mutants: $(VENV)/mutated  ## mutants of the mechanics (listed by cargo-mutants; SHARD=K/N of them) and of the decision: docs/explanation/tests.md
	$(PYTHON) benches/core_mutants.py --shard $(SHARD) --python
	$(PYTHON) benches/mutants.py

$(VENV)/benched: $(VENV)/installed
	$(PYTHON) -m pip install -q --group bench
	touch $@

bench: build $(VENV)/benched $(VENV)/tested  ## speed beside fsolve, NumPy, numba and C, ratios first; predictions, diagnoses, the page
	cargo build --release --quiet -p cbpt-cli
	$(PYTHON) benches/peers.py
	$(PYTHON) benches/diagnosis.py
	$(PYTHON) benches/page.py

trial: build  ## the diagnosis scored on campaigns with a hidden effect, at full length (two to three hours): docs/explanation/trial.md
	$(PYTHON) benches/trial --sets 60 --null-sets 400 --seed 5 --quiet --page docs/explanation/trial.md --json out/trial.json

trial-short: build  ## the trial on some campaigns of each kind, for development: about ten minutes on two cores
	$(PYTHON) benches/trial --short --seed 5 --quiet --page docs/explanation/trial.md

screenshots: build $(VENV)/tested  ## the picture of the page in the README, taken anew
	$(PYTHON) docs/site/screenshots.py $(OUT)/screenshots
	cp $(OUT)/screenshots/after.png docs/img/page.png

$(VENV)/documented: $(VENV)/installed
	$(PYTHON) -m pip install -q --group docs
	touch $@

docs: build $(VENV)/documented $(VENV)/tested  ## the documentation as a site, without a network: out/docs/index.html
	$(RUSTDOC)
	$(PYTHON) docs/site/build_site.py --rust $(CARGO_TARGET_DIR)/doc

instructions:  ## instructions of the hot loops against what is kept, by callgrind
	python3 benches/instructions.py

format:  ## format Rust, Python and the page's modules
	cargo fmt --all
	$(VENV)/bin/ruff check --fix && $(VENV)/bin/ruff format
	$(VENV)/bin/deno fmt --quiet

clean:  ## remove what was built
	rm -rf target $(OUT) $(VENV) dist
