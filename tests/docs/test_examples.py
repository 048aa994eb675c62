"""The code of README and documentation runs, at small sizes."""

import os
import re
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest

from urushi.app.cli import main

pytestmark = pytest.mark.slow

ROOT = Path(__file__).parents[2]
DOCS = ROOT / "docs"

PYTHON_BLOCK = re.compile(r"^```python\n(.*?)^```$", re.MULTILINE | re.DOTALL)

#: What blocks of pages need.
DIRECTIONS = """
import numpy as np
import urushi
wi, wo = np.array([[0.0, 0.6, 0.8]]), np.array([[0.36, -0.48, 0.8]])
"""


def run(folder: Path, *arguments: str | Path) -> str:
    """Run a script in a folder, or a block of code, and return what it prints."""
    script, *others = arguments
    if isinstance(script, str):
        (folder / "block.py").write_text(script)
        script = "block.py"
    result = subprocess.run(
        [sys.executable, "-m", "tests.fast", script, *others],
        cwd=folder,
        env=os.environ | {"PYTHONPATH": os.pathsep.join(map(str, (ROOT / "src", ROOT)))},
        capture_output=True,
        text=True,
        timeout=600,
    )
    assert result.returncode == 0, result.stderr
    return result.stdout


def is_lit(path: Path, width: int, height: int) -> bool:
    """Whether a picture has this size, finite pixels and light."""
    import mitsuba as mi

    mi.set_variant("scalar_rgb")
    pixels = np.array(mi.Bitmap(str(path)))
    return pixels.shape[:2] == (height, width) and np.isfinite(pixels).all() and pixels.max() > 0


def test_readme(tmp_path):
    (block,) = PYTHON_BLOCK.findall((ROOT / "README.md").read_text())
    assert block.count("spp=64") == 1
    # The Cornell box of Mitsuba has 256 x 256 pixels.
    run(tmp_path, block.replace("spp=64", "spp=1"))
    assert is_lit(tmp_path / "box.png", 256, 256)
    assert (tmp_path / "lacquer.safetensors").is_file()


def test_tutorial(tmp_path):
    """Every picture of the page is made."""
    run(tmp_path, DOCS / "tutorial" / "first_coat.py", tmp_path, "--size", "16", "--spp", "2")
    page = (DOCS / "tutorial" / "index.md").read_text()
    names = set(re.findall(r"(\w+)\.jpg", page))
    assert names == {path.stem for path in tmp_path.glob("*.png")}
    assert all(is_lit(tmp_path / f"{name}.png", 16, 16) for name in names)


def test_gradients(tmp_path):
    """The target is grey, so that the gradient differs by channel and none is zero."""
    printed = run(tmp_path, DOCS / "examples" / "gradients.py")
    gradient = [float(number) for number in re.findall(r"-?\d+\.?\d*(?:e-?\d+)?", printed)]
    assert len(gradient) == 3
    assert all(np.isfinite(gradient)) and len(set(gradient)) == 3 and 0 not in gradient


def test_textures(tmp_path):
    assert "64 x 64 nodes over v, u" in run(tmp_path, DOCS / "examples" / "textures.py", tmp_path)


def test_anisotropy(tmp_path):
    """The blocks of the page run; the script draws both pictures."""
    blocks = PYTHON_BLOCK.findall((DOCS / "anisotropy.md").read_text())
    # A quarter of a turn exchanges x and y of the directions, here up to the signs.
    after = "\nassert np.array_equal(f, lacquered.f(wi[:, [1, 0, 2]], wo[:, [1, 0, 2]]))\n"
    run(tmp_path, DIRECTIONS + "".join(blocks) + after)
    run(tmp_path, DOCS / "examples" / "anisotropy.py", tmp_path, "--size", "12", "--spp", "1")
    assert is_lit(tmp_path / "anisotropy.png", 12, 8)


def test_measured(tmp_path):
    """Every Python block of the page runs, on an RGB table in MERL's format."""
    from benchmarks.experiments.speed import synthetic_merl

    synthetic_merl(tmp_path / "gold-paint.binary")
    blocks = PYTHON_BLOCK.findall((DOCS / "measured.md").read_text())
    assert len(blocks) == 2
    after = "\nassert (f > 0).all() and (coated.f(wi, wo) > 0).all()\n"
    run(tmp_path, DIRECTIONS + "\n".join(blocks) + after)


@pytest.mark.parametrize("scene", sorted(DOCS.glob("cookbook/*.xml")), ids=lambda path: path.stem)
def test_cookbook(scene, tmp_path):
    size = ("-D", "width=12", "-D", "height=8", "--spp", "1")
    picture = tmp_path / "scene.exr"
    assert main(["render", str(scene), *size, "-o", str(picture)]) == 0
    assert is_lit(picture, 12, 8)
