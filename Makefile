# Two commands: `make demo` and `make test`. Each does all set-up first; the second time it is quick.
READY := .venv/.ready

.PHONY: demo test set-up format clean

demo: $(READY)
	.venv/bin/urushi demo

test: $(READY)
	.venv/bin/ruff check .
	.venv/bin/ruff format --check .
	.venv/bin/mypy
	.venv/bin/lint-imports
	.venv/bin/pytest

set-up: $(READY)

format: $(READY)
	.venv/bin/ruff check --fix .
	.venv/bin/ruff format .

clean:
	rm -rf .venv out

$(READY): pyproject.toml uv.lock scripts/setup
	scripts/setup
	@touch $@
