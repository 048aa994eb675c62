"""Notebooks in docs are stored with the outputs of one run from top to bottom, without warnings."""

import json
from pathlib import Path

import pytest

NOTEBOOKS = sorted((Path(__file__).parents[1] / "docs" / "notebooks").glob("*.ipynb"))


@pytest.mark.parametrize("path", NOTEBOOKS, ids=lambda path: path.stem)
def test_a_notebook_was_executed_in_order(path):
    cells = [cell for cell in json.loads(path.read_text())["cells"] if cell["cell_type"] == "code"]
    assert [cell["execution_count"] for cell in cells] == list(range(1, len(cells) + 1))
    outputs = [output for cell in cells for output in cell["outputs"]]
    assert outputs
    # Warnings and errors would contain file names of the machine that executed the notebook.
    assert all(output["output_type"] != "error" for output in outputs)
    assert all(output.get("name") != "stderr" for output in outputs)


def test_notebooks_are_small():
    """The repository stores every version of the pictures in them."""
    assert NOTEBOOKS
    assert all(path.stat().st_size < 300_000 for path in NOTEBOOKS)
