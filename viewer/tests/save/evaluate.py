"""Evaluate what the page has saved: `evaluate.py FOLDER ...` for the tests beside this file.

A folder holds `material.safetensors`, `pairs.json` with wi and wo, `program.py`, a filled template
of shader code, and `basis.f32`, the page's texels of the basis. Prints f by `urushi.load`, by the
program and by the NumPy code as JSON: an object for each folder.
"""

import contextlib
import json
import os
import sys
from pathlib import Path
from types import ModuleType

import numpy as np

import urushi
from urushi.core.table import SHAPE


def values(folder: Path) -> dict[str, list[float]]:
    """f by each of the three ways, as flat lists."""
    pairs = np.array(json.loads((folder / "pairs.json").read_text()), np.float32)
    wi, wo = pairs.reshape(2, -1, 3)
    table = np.fromfile(folder / "basis.f32", np.float32).reshape(*SHAPE[:2], -1, 4)
    code = ModuleType("code")
    exec((folder / "material-numpy.py").read_text(), code.__dict__)
    program = ModuleType("program")
    os.chdir(folder)  # where the program saves
    with contextlib.redirect_stdout(None):
        exec((folder / "program.py").read_text(), program.__dict__)
    found = {
        "program": program.material.f(wi, wo),
        "loaded": urushi.load(folder / "material.safetensors").f(wi, wo),
        "code": code.f(code.material(), wi, wo, table),
    }
    return {name: f.ravel().tolist() for name, f in found.items()}


print(json.dumps([values(Path(folder)) for folder in sys.argv[1:]]))
