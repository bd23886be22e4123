# Two commands: `make heat` and `make test`. Both install what is missing first.
PYTHON := .venv/bin/python
SHELL := /bin/bash
export OMP_NUM_THREADS := 1
PEER_PYTHON := python3.12
MPIRUN := mpirun --oversubscribe $(if $(filter 0,$(shell id -u)),--allow-run-as-root)
PARTS := 3

.PHONY: heat deb test-container docs docs-test test test-quick test-durations test-fast test-heavy test-mpi check install tables packing speed-against-error work-precision adjoint hard-cases random-scenes crossed-scenes three-dimensions measured-stores accuracy peers model-choice lattices bubbling-bed patil-bed sheared-bed regression regression-store sweep growth figures chapter-6 bead-interior expanding-liquids permeability workshop fluid-properties tracer validation kill-test fuzz-test test-debian13 test-debian-sid clean

heat: .venv/installed  ## heat the aluminium mold: summary and pictures in runs/aluminium
	$(PYTHON) -m porousmold run studies/mold/aluminium.toml --out runs/aluminium --force

test-quick: .venv/installed  ## unit tests: no whole runs, within a minute once forms are compiled
	$(PYTHON) -m pytest -q -n $(PARTS) --timeout=120 -m "not slow and not heavy and not docs" tests

test-durations: .venv/installed  ## all tests on one rank, and which of them are slow: tests/durations.json
	$(PYTHON) -m pytest -q -n $(PARTS) --store-durations -m "not docs" tests

test: .venv/installed  ## style, types, the tests of up to 3 s on 1, 2 and 3 ranks
	$(MAKE) --no-print-directory check test-fast test-mpi

test-fast: .venv/installed  ## the tests on one rank
	$(PYTHON) -m pytest -q -n $(PARTS) --timeout=600 -m "not heavy and not docs" tests

test-heavy: .venv/installed  ## the tests of more than 3 s, whole runs and studies, on 1, 2 and 3 ranks
	$(PYTHON) -m pytest -q -n $(PARTS) --timeout=600 -m "heavy and not docs" tests
	timeout 600 $(MPIRUN) -n 2 $(PYTHON) -m pytest -q -x --timeout=500 -m "mpi and heavy" tests
	timeout 600 $(MPIRUN) -n 3 $(PYTHON) -m pytest -q -x --timeout=500 -m "mpi and heavy" tests

test-mpi: .venv/installed  ## the parallel tests of up to 3 s on 2 and 3 ranks
	timeout 600 $(MPIRUN) -n 2 $(PYTHON) -m pytest -q -x --timeout=500 -m "mpi and not heavy" tests
	timeout 600 $(MPIRUN) -n 3 $(PYTHON) -m pytest -q -x --timeout=500 -m "mpi and not heavy" tests

check: .venv/installed  ## style and types
	$(PYTHON) -m ruff check . && $(PYTHON) -m ruff format --check . && $(PYTHON) -m mypy

tables: .venv/installed  ## refinement and turbulence tables: docs/tables.md
	$(PYTHON) -m studies.tables

packing: .venv/installed  ## packings against the thesis and LIGGGHTS, profiles and heating times on them: docs/packing.md
	$(PYTHON) -m studies.packing

speed-against-error: .venv/installed  ## model ladder, meshes and steps: docs/speed-against-error.md
	$(PYTHON) -m studies.speed_against_error

work-precision: .venv/installed  ## 40 crossed scenes, fewer cells and steps: docs/work-precision.md (50 minutes)
	$(PYTHON) -m studies.work_precision

adjoint: .venv/installed  ## all sensitivities by one adjoint sweep, beside differences of runs: docs/adjoint.md
	$(PYTHON) -m studies.adjoint

hard-cases: .venv/installed  ## every hard case and what happened: docs/hard-cases.md
	$(PYTHON) -m studies.hard_cases

random-scenes: .venv/installed  ## 200 scenes drawn at random, their answers and errors: docs/random-scenes.md
	$(PYTHON) -m studies.random_scenes

crossed-scenes: .venv/installed  ## 300 scenes that cross every feature, errors by feature: docs/crossed-scenes.md
	$(PYTHON) -m studies.crossed_scenes

three-dimensions: .venv/installed  ## locally developed against full flow, random scenes: docs/three-dimensions.md
	$(PYTHON) -m studies.three_dimensions

peers: .venv/installed  ## beside OpenTerrace, on Schumann's front (Python 3.12, or PEER_PYTHON=...): docs/peers.md
	test -x build/peers/bin/python || $(PEER_PYTHON) -m venv build/peers
	build/peers/bin/pip install -q openterrace==0.1.4
	$(PYTHON) -m studies.peers

accuracy: .venv/installed  ## solver.accuracy: its estimate against the true error, and its cost, 40 scenes
	$(PYTHON) -m studies.accuracy

lattices: .venv/installed  ## conductivity of packings beside resolved lattices: docs/packed-conductivity.md
	$(PYTHON) -m studies.lattices

bubbling-bed: .venv/installed  ## 80 000 beads in a bubbling bed: docs/bubbling-bed.png
	$(PYTHON) -m studies.bubbling_bed

patil-bed: .venv/installed  ## a bubbling bed that cools at its walls, three velocities (100 minutes of one core): docs/patil-bed.md
	$(PYTHON) -m studies.patil_bed

droplet: .venv/installed  ## a droplet on hot grains at six temperatures, seeds, variants (40 minutes): docs/droplet.md
	$(PYTHON) -m studies.droplet

sheared-bed: .venv/installed  ## sheared beds beside what Forgber and Radl state: docs/sheared-bed.md
	$(PYTHON) -m studies.sheared_bed

model-choice: .venv/installed  ## model.choose: the cheapest model beside the fullest, 40 scenes
	$(PYTHON) -m studies.model_choice

regression-store: .venv/installed  ## numbers that a refactoring must leave alone: runs/regression.json
	$(PYTHON) -m studies.regression store runs/regression.json

regression: .venv/installed  ## the same numbers again, beside those stored
	$(PYTHON) -m studies.regression compare runs/regression.json

sweep: .venv/installed  ## the strip of a workshop's sweep where bead sources fade out: 200 cases in runs/strip
	$(MPIRUN) -n 2 $(PYTHON) -m mpi4py -m porousmold study studies/sweep/strip.toml

growth: .venv/installed  ## seconds and memory from 4k to 1M unknowns: docs/growth.md
	$(PYTHON) -m studies.growth

figures: .venv/installed  ## the thesis's parametric curves: docs/parametric.md
	$(MPIRUN) -n 2 $(PYTHON) -m mpi4py -m studies.figures $(COMPARED)

chapter-6: .venv/installed  ## the thesis's chapter 6, term by term: docs/chapter-6.md
	$(PYTHON) -m studies.chapter_6

bead-interior: .venv/installed  ## beads that are not isothermal: docs/bead-interior.md
	$(PYTHON) -m studies.bead_interior

expanding-liquids: .venv/installed  ## fluids that expand, against finite volumes: docs/expanding-liquids.md
	$(PYTHON) -m studies.expanding_liquids

tracer: .venv/installed  ## when a tracer comes through the aluminium mold's bed
	$(PYTHON) -m studies.tracer

measured-stores: .venv/installed  ## two measured heatings with flow: docs/measured-stores.md
	$(PYTHON) -m studies.measured_stores

validation: .venv/installed  ## the closures against measurements: docs/validation.md (minutes)
	$(PYTHON) -m studies.validation

workshop: .venv/installed  ## seconds of the workshop's mold beside a plain one (docs/shop-floor.md)
	$(PYTHON) -m studies.workshop

fluid-properties: .venv/installed  ## the library's fluids fitted anew; wants CoolProp in the environment
	$(PYTHON) -m studies.fluid_properties

permeability: .venv/installed  ## falling-head tests of known permeability: docs/permeability.md
	$(PYTHON) -m studies.permeability_tests

kill-test: .venv/installed  ## 1000 kills of seven commands at random moments, given again: the same answers
	$(PYTHON) -m studies.kill_test

fuzz-test: .venv/installed  ## 10 000 mutated scenes, studies, packings, series and meshes, and new examples of every property
	$(PYTHON) -m studies.fuzz
	$(PYTHON) -m pytest -q -n $(PARTS) -m "hypothesis and not slow" --hypothesis-profile=new-examples tests

test-debian13: .venv/installed  ## the tests on one rank on Debian 13 (dolfinx 0.9), in a root of its own outside the tree
	tools/test-debian trixie

test-container:  ## the Containerfile's steps in a root of debootstrap, where there is no container builder
	tools/test-container

test-debian-sid: .venv/installed  ## the same on the newest dolfinx of Debian
	tools/test-debian sid

docs: .venv/docs  ## the documentation site: docs/_build/index.html
	$(PYTHON) -m sphinx -q -W --keep-going -b html docs docs/_build

docs-test: .venv/docs  ## every command of README, tutorials and notebooks is run
	$(PYTHON) -m pytest -q -n 2 --timeout=600 -m docs tests

deb:  ## the Debian package: build/deb
	tools/make-deb

install: .venv/installed

.venv/installed: pyproject.toml tools/install tools/install-packages tools/packages
	tools/install
	touch $@

.venv/docs: .venv/installed tools/docs-packages
	tools/install-packages tools/docs-packages
	touch $@

clean:  ## remove the environment and the runs
	rm -rf .venv runs docs/_build
