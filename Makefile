# `make demo` and `make test` need python3 (3.10 or later), a Rust toolchain and a network for their first call, nothing
# else: they make their own environment in .venv, each with what it uses. Stamp files make a second call quick.

PYTHON ?= python3
VENV := .venv
BIN := $(VENV)/bin

# maturin looks for the environment here, whatever else is active.
export VIRTUAL_ENV := $(CURDIR)/$(VENV)
# pyo3 looks for the interpreter here.
export PYO3_PYTHON := $(CURDIR)/$(BIN)/python
export PIP_DISABLE_PIP_VERSION_CHECK := 1
unexport CONDA_PREFIX PYTHONPATH PYTHONHOME

# What the module is built from: neither tests nor benches.
RUST := Cargo.toml Cargo.lock $(shell find rust/core/src rust/core/Cargo.toml rust/python -type f)

.PHONY: demo test test-rust check lint lint-rust lint-python golden bench kill peers readme accuracy deployment ikaros docs dist clean

# A sail from the roll to the flat square, and both sails of the paper from the cross, on all cores: pictures, VTU frames,
# curves and a table, in out/.
demo: $(VENV)/built
	$(BIN)/python examples/demo.py --out out

# The tests of the core are built and run while the environment and the module are made. Files of tests are shared out to
# all cores; what a file prepares once stays with one of them. A process that crashes is not replaced: its test then
# fails, and the others end, where a replacement would wait for ever.
test:
	@$(MAKE) --no-print-directory --jobs=2 test-rust $(VENV)/tools
	$(BIN)/python -m pytest --numprocesses=auto --maxprocesses=8 --dist=loadfile --max-worker-restart=0

# Cargo is not to share the two jobs of `make test`: it has its own, one for each core.
test-rust: | $(VENV)/made
	MAKEFLAGS= cargo test --workspace

check: test lint docs

lint: lint-rust lint-python

# rustfmt leaves comments and texts as long as they are.
lint-rust: $(VENV)/tools
	cargo fmt --all --check
	@! LC_ALL=C.UTF-8 grep --recursive --line-number --extended-regexp --include='*.rs' '.{121}' rust || \
		{ echo "lines above are longer than 120 characters; wrap them"; exit 1; }
	cargo clippy --workspace --all-targets -- -D warnings

lint-python: $(VENV)/tools
	$(BIN)/ruff check
	$(BIN)/ruff format --check
	$(BIN)/mypy
	$(BIN)/python -m mypy.stubtest membrane_rs._core
	$(BIN)/lint-imports --no-logo

# Whether a change has changed a bit of any motion, at every width of vector instructions; it may: WRITE=--write.
golden: $(VENV)/tools
	@$(BIN)/python tests/golden.py $(WRITE)

# Times of laws and steps, into benchmarks/README.md; some of them: make bench PART="model_1 steps". QUICK=--quick shows
# that all works.
PART_OF_BENCH := model_1 kernels steps building output designs
bench: $(VENV)/tools
	@for part in $(or $(PART),$(PART_OF_BENCH)); do $(BIN)/python benchmarks/$$part.py --write $(QUICK) || exit 1; done

# Kills model 1's run until 200 kills have hit it, resumes each, and compares all bits with those of a run that nobody
# stopped: the table of docs/interruption.md. QUICK=--quick: few kills of a small scene.
kill: $(VENV)/tools
	$(BIN)/python benchmarks/interruption.py $(or $(QUICK),--write)

# MuJoCo and Newton, an optional extra, on the same membrane: docs/peers.md and its picture.
peers: $(VENV)/tools
	@$(BIN)/python -m pip install --quiet --group peers || \
		{ echo "MuJoCo and Newton could not be installed: this needs a network, and a platform that both have wheels for"; exit 1; }
	cd benchmarks && ../$(BIN)/python -m peers --write

# Every figure and table of the accuracy side from nothing, which takes hours; some of them:
# make accuracy PART="work-precision limits". Parts: benchmarks/remake.py --list.
accuracy: $(VENV)/tools
	$(BIN)/python benchmarks/remake.py $(PART)

# The whole deployment charted: tables and pictures of docs/deployment.md, in an hour on two cores. Runs are
# kept in out/deployment; PART="plane reel": some of plane, reel, release, energy, crossings, cost, shapes.
deployment: $(VENV)/tools
	$(BIN)/python tools/docs/deployment.py --write $(if $(PART),--only $(PART))

# The deployment of IKAROS: tables and pictures of docs/ikaros.md, in half an hour on two cores. Runs are kept in
# out/ikaros; PART="spin match": some of spin, needed, match, meshes, values, roll, reeling, balance,
# cost, shapes.
ikaros: $(VENV)/tools
	$(BIN)/python tools/docs/ikaros.py --write $(if $(PART),--only $(PART))

# Remakes README.md's pictures, and the tables of docs/accuracy.md.
readme: demo
	$(BIN)/python tools/docs/accuracy.py
	$(BIN)/python tools/docs/readme_numbers.py --write

# The site of the documentation, in out/docs: without a network, each warning an error; then a look at what its pages load
# and where their links lead.
docs: $(VENV)/tools
	rm -rf out/docs
	$(BIN)/python -m sphinx -b html -W --keep-going -q -d out/doctrees docs out/docs
	cd tools/docs && ../../$(BIN)/python -m website.offline ../../out/docs
	cd tools/docs && ../../$(BIN)/python -m website.links ../../out/docs

# A wheel for manylinux x86-64 and a source archive, in dist/, each installed and tried in a fresh environment.
# LINKS=https://... makes the links and pictures of README.md absolute for the page of a package.
dist: $(VENV)/built
	$(BIN)/python -m pip install --quiet --group dist
	PATH="$(CURDIR)/$(BIN):$$PATH" $(BIN)/python tools/dist/build.py $(if $(LINKS),--links $(LINKS))
	$(BIN)/python tools/dist/smoke.py

clean:
	rm -rf docs/gallery docs/reference
	rm -rf $(VENV) target dist out runs .pytest_cache .mypy_cache .ruff_cache .import_linter_cache .hypothesis
	rm -f python/membrane_rs/_core*.so
	find python tests examples benchmarks tools -name __pycache__ -prune -exec rm -rf {} +

$(VENV)/made:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 10))' || \
		{ echo "membrane_rs needs Python 3.10 or later; name one: make PYTHON=python3.12"; exit 1; }
	@command -v cargo > /dev/null || \
		{ echo "membrane_rs needs a Rust toolchain (cargo and rustc); install one"; exit 1; }
	$(PYTHON) -m venv $(VENV)
	@touch $@

# The module, with what its pictures need. pip learned dependency groups with version 25.1.
$(VENV)/built: pyproject.toml $(RUST) | $(VENV)/made
	$(BIN)/python -m pip install --quiet --upgrade 'pip>=25.1' 'maturin>=1.9,<2'
	MAKEFLAGS= $(BIN)/maturin develop --release --extras plot
	@touch $@

# All extras, and what tests, linters and pages need; the package itself is there already.
$(VENV)/tools: $(VENV)/built
	$(BIN)/python -m pip install --quiet --group dev 'membrane_rs[docs]'
	@touch $@
