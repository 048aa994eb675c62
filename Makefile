# Two commands: `make demo` and `make test`. Each sets up .venv first; later runs skip that.
READY := .venv/.ready
# Many processes import the same modules, which are compiled once.
unexport PYTHONDONTWRITEBYTECODE
# One worker for each core; a file's tests stay together, since they share fixtures.
PYTEST := .venv/bin/pytest --numprocesses auto --dist loadfile --no-loadscope-reorder

.PHONY: demo test first-tier test-all test-research lint check-wheel docs docs-packages cookbook tutorial \
    notebook thumbnails measured-pictures figures set-up format clean viewer viewer-packages printed \
    test-web test-page

demo: $(READY)
	.venv/bin/urushi demo

# The tests of the first tier; the static checks, which mostly use one core, run beside them.
test: $(READY)
	$(MAKE) --jobs 2 lint first-tier

first-tier: $(READY)
	$(PYTEST) -m "not slow and not research"

# The tests of the first and of the second tier: the long sweeps too, marked as slow
test-all: $(READY)
	$(PYTEST) -m "not research"

# The third tier: gallery, rivals, figures, benchmarks and trainings
test-research: $(READY)
	$(PYTEST) -m research

lint: $(READY)
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports

# Installs the built wheel into an empty environment and uses it there.
check-wheel: $(READY)
	scripts/check_wheel

# Builds the documentation site, and the page that it shows, into out/docs; a warning is an error.
docs: docs-packages
	.venv/bin/python -m sphinx -b html -W --keep-going -q docs out/docs
	.venv/bin/urushi view -o out/docs/page

docs-packages: $(READY)
	VIRTUAL_ENV= UV_PROJECT_ENVIRONMENT=.venv .venv/bin/uv sync --quiet --locked --all-extras --inexact --group docs

# The pictures of the cookbook and of the tutorial, by the present weights
cookbook: $(READY)
	mkdir -p out/cookbook
	for scene in docs/cookbook/*.xml; do \
	    .venv/bin/urushi render $$scene -o out/cookbook/$$(basename $$scene .xml).png || exit; \
	done
	.venv/bin/python docs/small_jpg.py out/cookbook/*.png docs/cookbook

tutorial: $(READY)
	mkdir -p out/tutorial
	.venv/bin/python docs/tutorial/first_coat.py out/tutorial
	.venv/bin/python docs/small_jpg.py out/tutorial/*.png docs/tutorial

# Executes the notebooks in docs and stores their results in them.
notebook: $(READY)
	VIRTUAL_ENV= UV_PROJECT_ENVIRONMENT=.venv .venv/bin/uv sync --quiet --locked --all-extras --inexact --group notebook
	PYTHONPATH=$(CURDIR) .venv/bin/jupyter execute --inplace --NotebookClient.record_timing=False docs/notebooks/*.ipynb

# The README's pictures of the gallery, by the present weights
GALLERY := still-life globe teapot shoe brushed car leaf glass
thumbnails: $(READY)
	for scene in $(GALLERY); do \
	    .venv/bin/python -m gallery $$scene out/gallery/$$scene || exit; \
	done
	for scene in still-life globe teapot shoe brushed; do \
	    .venv/bin/urushi render out/gallery/$$scene/scene.xml --width 320 --height 240 --spp 128 \
	        -o docs/images/$$scene.png || exit; \
	done
	for scene in car leaf glass; do \
	    spp=160; if [ $$scene = glass ]; then spp=1024; fi; \
	    .venv/bin/urushi render out/gallery/$$scene/scene.xml --width 320 --height 240 --spp $$spp \
	        -o out/$$scene.png || exit; \
	    .venv/bin/python docs/small_jpg.py out/$$scene.png docs/images || exit; \
	done
	for scene in car leaf; do \
	    .venv/bin/urushi render out/gallery/$$scene/scene.xml -D coat=layered --width 320 \
	        --height 240 --spp 160 -o out/$$scene-walk.png || exit; \
	    .venv/bin/python docs/small_jpg.py out/$$scene-walk.png docs/images || exit; \
	done
	.venv/bin/python -m gallery library out/gallery/library --width 900 --height 560 --spp 128
	.venv/bin/urushi render out/gallery/library/scene.xml -o docs/images/library.jpg

# The picture of docs/measured.md, by the present weights
measured-pictures: $(READY)
	.venv/bin/python -m benchmarks.examine docs/materials.xml#car-paint -o out/materials/report
	cp out/materials/report/car-paint.png docs/images/encode_report.png

# Results that are stale, their figures and their tables in the documentation, in a night; finished
# cases in out/figures are kept.
figures: $(READY)
	.venv/bin/python -m benchmarks stale

# Builds the page of `urushi view` into the package; using it needs no Node, building it does.
viewer: printed viewer/node_modules/.ready
	cd viewer && npm run build

# Of the goals of one command, what reads the built page waits for it, and what installs packages
# waits for the static checks, which read them.
test-page: | $(filter viewer,$(MAKECMDGOALS))
docs-packages docs check-wheel: | $(filter viewer lint,$(MAKECMDGOALS))

# Builds the page, then checks and tests it; in Chromium also the long cases.
test-web: viewer
	$(MAKE) test-page
	cd viewer && npm run test:long

# Checks and tests of the page as it is built: types, style, units, and the whole page in Chromium,
# but for the long cases
test-page: printed viewer/node_modules/.ready
	cd viewer && npm run check && npm test
	viewer/install_chromium
	cd viewer && npm run test:page

# What the page has of Python's formulas and constants, which is not under version control
printed: $(READY)
	.venv/bin/python -m viewer.formulas

viewer-packages: viewer/node_modules/.ready

# Not `npm ci`: since npm 11 it refuses a lock file without the packages of other platforms.
viewer/node_modules/.ready: viewer/package-lock.json
	cd viewer && npm install --no-save --no-audit --no-fund
	@touch $@

set-up: $(READY)

format: $(READY)
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

clean:
	rm -rf .venv out

$(READY): pyproject.toml uv.lock scripts/setup
	scripts/setup
	@touch $@
