"""Evaluate what the page has saved: `evaluate.py FOLDER ...` for the tests beside this file.

A folder holds `material.safetensors`, `pairs.json` with wi and wo, `program.py`, and a filled
template of shader code. Prints f by `urushi.load`, by the program and by the NumPy code as JSON: an
object for each folder.
"""

import contextlib
import json
import os
import sys
from pathlib import Path
from types import ModuleType

import numpy as np

import urushi


def values(folder: Path) -> dict[str, list[float]]:
    """f by each of the three ways, as flat lists."""
    pairs = np.array(json.loads((folder / "pairs.json").read_text()), np.float32)
    wi, wo = pairs.reshape(2, -1, 3)
    code = ModuleType("code")
    exec((folder / "material-numpy.py").read_text(), code.__dict__)
    program = ModuleType("program")
    os.chdir(folder)  # where the program saves
    with contextlib.redirect_stdout(None):
        exec((folder / "program.py").read_text(), program.__dict__)
    found = {
        "program": program.material.f(wi, wo),
        "loaded": urushi.load(folder / "material.safetensors").f(wi, wo),
        "code": code.f(code.material(), wi, wo),
    }
    return {name: f.ravel().tolist() for name, f in found.items()}


print(json.dumps([values(Path(folder)) for folder in sys.argv[1:]]))
