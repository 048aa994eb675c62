"""The example that exports its material says how it is called."""

import runpy
import sys
from pathlib import Path

import pytest

EXAMPLE = Path(__file__).parents[2] / "examples" / "material.py"


@pytest.mark.parametrize("arguments", [[], ["no such folder"]])
def test_without_a_folder_it_says_what_to_give(arguments, monkeypatch):
    monkeypatch.setattr(sys, "argv", [str(EXAMPLE), *arguments])
    with pytest.raises(SystemExit, match="give a folder that exists"):
        runpy.run_path(str(EXAMPLE), run_name="__main__")
