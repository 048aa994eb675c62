"""The table of OpenPBR's examples in the documentation is what the reader finds."""

import os
import runpy
import subprocess
import sys
from pathlib import Path
from types import SimpleNamespace

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"


@pytest.fixture(scope="module")
def module():
    mi = pytest.importorskip("mitsuba")
    mi.set_variant("llvm_ad_rgb")
    return SimpleNamespace(**runpy.run_path(DOCS / "openpbr_examples.py"))


def materials(table):
    """The rows of a table by material: what it asks for, and what becomes of it."""
    rows = [line.strip("|").split(" | ") for line in table.splitlines()[2:]]
    return {name: (row[0].strip(), row[1]) for row in rows for name in row[3].strip().split(", ")}


@pytest.mark.slow
def test_the_table_is_true(module, stored):
    """It may be behind: a material that it calls refused may be rendered by now."""
    page = module.PAGE.read_text(encoding="utf-8")
    written = materials(page.split(module.BEGIN)[1].split(module.END)[0])
    found = materials(module.table(stored("data/openpbr")))
    assert len(written) == 83 and written.keys() == found.keys()
    for name, (asks, result) in written.items():
        assert found[name][0] == asks
        assert found[name][1] in (result, "rendered")


def test_refusals_name_what_is_missing(module):
    glass = {"transmission_weight": 1.0, "transmission_dispersion_scale": 1.0}
    result = module.outcome({"type": "openpbr", **glass})
    assert result == "refused: dispersion (`transmission_dispersion_scale`)"
    assert module.outcome({"type": "openpbr", "transmission_weight": 1.0}) == "rendered"
    assert module.outcome({"type": "openpbr"}) == "rendered"


def test_the_sheet_finds_the_gallery_from_any_folder(tmp_path):
    """The gallery is not installed, and lies beside the folder of the script."""
    code = "import runpy, sys; runpy.run_path(sys.argv[1])"
    command = [sys.executable, "-c", code, str(DOCS / "openpbr_sheet.py")]
    environment = os.environ | {"PYTHONPATH": str(DOCS.parent / "src")}
    subprocess.run(command, cwd=tmp_path, env=environment, check=True, timeout=600)
