"""Evaluate what the page has saved: `evaluate.py FOLDER ...` for the tests beside this file.

A folder holds `material.safetensors`, `input.json` with what is evaluated, `program.py`, a filled
template of shader code, and `basis.f32`, the page's texels of the basis. Prints an object for each
folder as JSON: f by `urushi.load`, by the program and by the NumPy code, and the albedo and the
drawn directions of the loaded material.
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


def incident(cosines: np.ndarray) -> np.ndarray:
    """Unit vectors (N, 3) of cosines in the plane y = 0."""
    return np.stack([np.sqrt(1 - cosines**2), 0 * cosines, cosines], axis=-1).astype(np.float32)


def values(folder: Path) -> dict[str, list[float]]:
    """All values as flat lists."""
    given = json.loads((folder / "input.json").read_text())
    wi, wo = (np.array(given[name], np.float32).reshape(-1, 3) for name in ("wi", "wo"))
    table = np.fromfile(folder / "basis.f32", np.float32).reshape(*SHAPE[:2], -1, 4)
    code = ModuleType("code")
    exec((folder / "material-numpy.py").read_text(), code.__dict__)
    program = ModuleType("program")
    os.chdir(folder)  # where the program saves
    with contextlib.redirect_stdout(None):
        exec((folder / "program.py").read_text(), program.__dict__)
    loaded = urushi.load(folder / "material.safetensors")
    rows = (np.arange(given["rows"]) + 0.5) / given["rows"]
    seen = np.repeat(incident(rows), len(given["u"]), axis=0)
    drawn, densities = loaded.sample(seen, np.tile(given["u"], (len(rows), 1)))
    found = {
        "program": program.material.f(wi, wo),
        "loaded": loaded.f(wi, wo),
        "code": code.f(code.material(), wi, wo, table),
        "albedo": loaded.directional_albedo(incident(np.array(given["cosines"]))),
        "drawn": drawn,
        "densities": densities,
    }
    return {name: f.ravel().tolist() for name, f in found.items()}


print(json.dumps([values(Path(folder)) for folder in sys.argv[1:]]))
