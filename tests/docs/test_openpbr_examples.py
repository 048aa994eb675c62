"""The table of OpenPBR's examples in the documentation is what the reader finds."""

import os
import re
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import pytest

DOCS = Path(__file__).resolve().parents[2] / "docs"
EXAMPLES = Path(os.environ.get("URUSHI_TEST_DATA", "")) / "data" / "openpbr"


def test_the_table_is_true():
    if "URUSHI_TEST_DATA" not in os.environ or not EXAMPLES.is_dir():
        pytest.skip("URUSHI_TEST_DATA names no folder with the examples of OpenPBR")
    spec = spec_from_file_location("openpbr_examples", DOCS / "openpbr_examples.py")
    module = module_from_spec(spec)
    spec.loader.exec_module(module)
    written = module.PAGE.read_text(encoding="utf-8").split(module.BEGIN)[1].split(module.END)[0]
    assert written == module.table(EXAMPLES)
    assert sum(int(n) for n in re.findall(r"\| (\d+) \|", written)) == 83
    assert "refused" not in written
