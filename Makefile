# Needs GNU make and Python 3.11 or later with venv; everything else goes into .venv.
PYTHON ?= python3
VENV   := .venv
BIN    := $(VENV)/bin
PIP     = $(BIN)/python -m pip --disable-pip-version-check
UV     := 0.13.9

# Wheels only, and only those whose hash is in the lock, which is complete: pip need not resolve anything, and so cannot
# stumble over a release newer than a pin. Then the project itself, with nothing fetched, and compiled: where Python is
# told to write no bytecode, each start would compile it again.
INSTALL      = $(PIP) install --quiet --no-deps --require-hashes --only-binary :all: -r
INSTALL_SELF = $(PIP) install --quiet --no-deps --no-build-isolation --no-index -e . && \
	PYTHONDONTWRITEBYTECODE= $(BIN)/python -m compileall -q ipcore service

# Extras stay in the lock: pip before 24 looks for `coverage[toml]` outside a lock that pins plain `coverage`, and fails.
# `make lock LOCK_FLAGS=--upgrade` moves to the newest versions; plain `make lock` keeps every pin that still fits.
LOCK_FLAGS ?=
COMPILE = .venv-lock/bin/uv pip compile --quiet --no-config --universal --python-version 3.11 --no-build --generate-hashes \
	--no-strip-extras --no-emit-index-url --no-emit-find-links --custom-compile-command "make lock" $(LOCK_FLAGS)

.DEFAULT_GOAL := serve
.NOTPARALLEL:
.DELETE_ON_ERROR:
.PHONY: serve test check contract lint-api image-check chaos hostile load bench bench-parts bench-paper bench-predictions bench-quality lock openapi docs clean help

serve: $(VENV)/.serve-stamp ## run the service (ARGS="…" goes to `ipfit serve`); the default
	exec $(BIN)/ipfit serve $(ARGS)

# One process for each core, which takes file after file in the order of their names. ARGS="-n 0" runs all in one.
PYTEST = $(BIN)/python -m pytest -n auto --dist loadfile --no-loadscope-reorder

test: $(VENV)/.dev-stamp ## run the tests (ARGS="…" goes to pytest)
	$(PYTEST) $(ARGS)

# Linters of the OpenAPI document and generators of clients. Where there is no npm, the tests that need one are skipped.
CONTRACT := tests/contract
SPECTRAL  = $(CONTRACT)/node_modules/.bin/spectral
REDOCLY   = REDOCLY_TELEMETRY=off REDOCLY_SUPPRESS_UPDATE_NOTICE=true $(CONTRACT)/node_modules/.bin/redocly

contract: .venv-contract/.stamp ## install the linters of the OpenAPI document and the generators of clients
	@if command -v npm >/dev/null; then $(MAKE) --no-print-directory $(CONTRACT)/node_modules/.stamp; \
		else echo "npm IS MISSING: the OpenAPI document is not linted, and no TypeScript client is made" >&2; fi

lint-api: $(CONTRACT)/node_modules/.stamp ## lint openapi/openapi.json with spectral (OWASP's rules, too) and redocly
	$(SPECTRAL) lint openapi/openapi.json --ruleset $(CONTRACT)/.spectral.yaml --fail-severity hint
	$(REDOCLY) lint openapi/openapi.json --config $(CONTRACT)/redocly.yaml

# pytest comes last, so that its closing line is the last one.
check: $(VENV)/.dev-stamp contract ## everything CI checks: style, types, layers, tests, coverage
	$(BIN)/ruff check .
	$(BIN)/ruff format --check .
	$(BIN)/mypy
	$(BIN)/lint-imports
	$(PYTEST) --cov --cov-report=term $(ARGS)

# In one process, so that both images are built once. Building takes minutes, and counts for the first test.
image-check: $(VENV)/.dev-stamp ## build both container images and run them without rights (needs podman; some minutes)
	$(BIN)/python -m pytest tests/image --timeout=1200 $(ARGS)

openapi: $(VENV)/.serve-stamp ## write openapi/openapi.json
	mkdir -p openapi
	$(BIN)/ipfit openapi > openapi/openapi.json.new
	mv openapi/openapi.json.new openapi/openapi.json

docs: $(VENV)/.serve-stamp ## write the tables of docs/options.md, docs/problems.md and docs/settings.md anew
	for name in options problems settings; do \
		{ sed '/^<!-- table/q' docs/$$name.md; $(BIN)/ipfit $$name; sed -n '/^<!-- \/table/,$$p' docs/$$name.md; } \
			> docs/$$name.md.new && mv docs/$$name.md.new docs/$$name.md || exit 1; \
	done

bench: $(VENV)/.bench-stamp bench-parts ## time the parts, then write bench/PEERS.md, this library beside others
	$(BIN)/python bench/peers.py $(ARGS)

bench-parts: $(VENV)/.dev-stamp ## time the parts alone, on one thread
	$(BIN)/python -m pytest bench/parts --benchmark-columns=min,median,iqr,rounds --benchmark-sort=name

bench-paper: $(VENV)/.bench-stamp ## write bench/PAPER.md (IPFIT_BENCH_DATA names the folder of point sets)
	$(BIN)/python bench/paper.py $(ARGS)

bench-predictions: $(VENV)/.bench-stamp ## write bench/PREDICTIONS.md, predicted beside measured times
	$(BIN)/python bench/predictions.py $(ARGS)

bench-quality: $(VENV)/.bench-stamp ## write bench/QUALITY.md (from the same folder)
	$(BIN)/python bench/quality.py $(ARGS)

chaos: $(VENV)/.dev-stamp ## kill everything at random under load, on both engines (a quarter of an hour each)
	$(BIN)/python -m load.chaos embedded $(ARGS)
	$(BIN)/python -m load.chaos cluster $(ARGS)

hostile: $(VENV)/.dev-stamp ## measure what others notice of clients that flood, stall or leave (some minutes)
	$(BIN)/python -m load.hostile $(ARGS)

load: $(VENV)/.load-stamp ## measure throughput and times under load, on both engines (a quarter of an hour; Tsung for open loops)
	$(BIN)/python -m load.loops $(ARGS)

lock: .venv-lock/.stamp ## write requirements.lock, those of tests/, bench/ and load/, and package-lock.json anew (needs npm)
	$(COMPILE) --group build --extra s3 --extra otel --extra examples -o requirements.lock pyproject.toml
	$(COMPILE) --group build --extra s3 --extra otel --extra examples --extra verify --extra dev -c requirements.lock -o tests/requirements.lock pyproject.toml
	$(COMPILE) --group build --extra s3 --extra otel --extra examples --extra bench -c tests/requirements.lock -o bench/requirements.lock pyproject.toml
	$(COMPILE) --group build --extra s3 --extra otel --extra examples --extra verify --extra dev --extra load -c tests/requirements.lock -o load/requirements.lock pyproject.toml
	$(COMPILE) -o tests/contract/requirements.lock tests/contract/requirements.in
	cd $(CONTRACT) && npm install --package-lock-only

clean: ## remove the environments, caches and build products (data stays)
	rm -rf $(VENV) .venv-lock .venv-contract $(CONTRACT)/node_modules build dist *.egg-info .mypy_cache .ruff_cache .pytest_cache .import_linter_cache \
		.hypothesis .schemathesis .benchmarks .coverage .coverage.* htmlcov openapi/openapi.json.new
	find . -name __pycache__ -type d -prune -exec rm -rf {} +

help: ## list the targets
	@sed -n 's/^\([a-z-]*\):.*## /\1\t/p' $(MAKEFILE_LIST)

$(VENV)/.venv-stamp:
	@$(PYTHON) -c 'import sys; sys.exit(sys.version_info < (3, 11))' || { \
		echo "ipfit needs Python 3.11 or later; this is $$($(PYTHON) --version 2>&1). Try: make PYTHON=python3.13" >&2; exit 1; }
	@$(PYTHON) -m venv $(VENV) || { \
		rm -rf $(VENV); echo "No virtual environment could be made; on Debian: apt-get install python3-venv" >&2; exit 1; }
	@touch $@

$(VENV)/.serve-stamp: $(VENV)/.venv-stamp requirements.lock pyproject.toml
	$(INSTALL) requirements.lock
	$(INSTALL_SELF)
	@touch $@

# The dev lock holds the same pins and more, so both stamps can share one environment.
$(VENV)/.dev-stamp: $(VENV)/.venv-stamp requirements.lock tests/requirements.lock pyproject.toml
	$(INSTALL) tests/requirements.lock
	$(INSTALL_SELF)
	@touch $@

$(VENV)/.load-stamp: $(VENV)/.dev-stamp load/requirements.lock
	$(INSTALL) load/requirements.lock
	$(INSTALL_SELF)
	@touch $@

$(VENV)/.bench-stamp: $(VENV)/.venv-stamp bench/requirements.lock pyproject.toml
	$(INSTALL) bench/requirements.lock
	$(INSTALL_SELF)
	@touch $@

.venv-contract/.stamp: $(CONTRACT)/requirements.lock
	$(PYTHON) -m venv .venv-contract
	.venv-contract/bin/python -m pip --disable-pip-version-check install --quiet --no-deps --require-hashes \
		--only-binary :all: -r $<
	@touch $@

# Without install scripts: nothing here needs one.
$(CONTRACT)/node_modules/.stamp: $(CONTRACT)/package.json $(CONTRACT)/package-lock.json $(CONTRACT)/.npmrc
	cd $(CONTRACT) && npm ci --ignore-scripts --silent
	@touch $@

.venv-lock/.stamp: Makefile
	$(PYTHON) -m venv .venv-lock
	.venv-lock/bin/python -m pip --disable-pip-version-check install --quiet uv==$(UV)
	@touch $@
