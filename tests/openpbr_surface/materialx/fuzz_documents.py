"""Fuzzing of the reader of MaterialX documents.

usage: python tests/materialx/fuzz_documents.py SECONDS [SEED]

Mutates small valid documents, as bytes and as elements. The run ends and keeps the document if the
reader raises anything but a user's error of one line, warns of anything but a user's warning, takes
longer than TIME or needs more memory than ALLOWANCE.
"""

import random
import sys
import tempfile
import time
import tracemalloc
import warnings
from dataclasses import dataclass
from pathlib import Path

import numpy as np
import OpenImageIO

from urushi.errors import UrushiError, UrushiWarning
from urushi.openpbr_surface.materialx.graph import library
from urushi.openpbr_surface.materialx.surface import read_surface

#: Longest time of a document, and the most memory that Python allocates for it [s, bytes].
TIME = 60.0
ALLOWANCE = 512 << 20

SEEDS = [
    """<materialx version="1.39" colorspace="acescg">
<open_pbr_surface name="s" type="surfaceshader">
<input name="base_color" type="color3" value="0.5, 0.2, 0.1"/>
<input name="coat_weight" type="float" value="1"/></open_pbr_surface>
<surfacematerial name="m" type="material">
<input name="surfaceshader" type="surfaceshader" nodename="s"/></surfacematerial></materialx>""",
    """<materialx version="1.39"><nodegraph name="g"><input name="a" type="float" value="3"/>
<texcoord name="uv" type="vector2"/><place2d name="p" type="vector2">
<input name="texcoord" type="vector2" nodename="uv"/></place2d>
<image name="i" type="color3"><input name="file" type="filename" value="a.exr"/>
<input name="texcoord" type="vector2" nodename="p"/></image>
<fractal2d name="f" type="float">
<input name="amplitude" type="float" interfacename="a"/></fractal2d>
<mix name="x" type="color3"><input name="fg" type="color3" nodename="i"/>
<input name="mix" type="float" nodename="f"/></mix>
<separate3 name="c" type="multioutput"><input name="in" type="color3" nodename="x"/></separate3>
<checkerboard name="k" type="color3"/><output name="o" type="color3" nodename="x"/>
<output name="r" type="float" nodename="c" output="outr"/>
<output name="b" type="color3" nodename="k"/></nodegraph>
<open_pbr_surface name="s" type="surfaceshader">
<input name="base_color" type="color3" nodegraph="g" output="o"/>
<input name="coat_color" type="color3" nodegraph="g" output="b"/></open_pbr_surface></materialx>""",
    """<materialx version="1.38"><nodedef name="D" node="d"><input name="in" type="color3"/>
<output name="out" type="color3"/></nodedef><nodegraph name="N" nodedef="D">
<worleynoise2d name="w" type="vector3"/><convert name="v" type="color3">
<input name="in" type="vector3" nodename="w"/></convert>
<add name="z" type="color3"><input name="in1" type="color3" interfacename="in"/>
<input name="in2" type="color3" nodename="v"/></add>
<output name="out" type="color3" nodename="z"/></nodegraph><d name="n" type="color3"/>
<standard_surface name="s" type="surfaceshader">
<input name="base_color" type="color3" nodename="n"/>
<input name="coat" type="float" value="1"/></standard_surface></materialx>""",
]
WORDS = ["", "0", "-1", "1e30", "1e-320", "nan", "4294967296", "true", "float", "color3", "vector2"]
WORDS += [
    "color4",
    "integer",
    "string",
    "multioutput",
    "surfaceshader",
    "image",
    "switch",
    "extract",
]
WORDS += ["combine4", "s", "g", "i", "x", "out", "nodename", "nodegraph", "value", "output", "../a"]
WORDS += ["normalmap", "noise2d", "0, 0, 0", "1, 2", "acescg", "srgb_texture", "interfacename"]
WORDS += [
    "colorspace",
    "fileprefix",
    "inherit",
    "nodedef",
    "defaultgeomprop",
    "UV0",
    "1.36",
    "1.39",
]


@dataclass
class Report:
    runs: int
    loaded: int


def fuzz(folder: Path, seed: int, runs: int | None = None, seconds: float = 0) -> Report:
    """Run `runs` mutants, or for `seconds`; raise any error that is not a user's error."""
    chance = random.Random(seed)
    pixels = np.full((4, 4, 3), 0.5, np.float32)
    assert OpenImageIO.ImageBuf(pixels).write(str(folder / "a.exr"))
    path, report, end = folder / "mutant.mtlx", Report(0, 0), time.monotonic() + seconds
    library()  # not a part of any document's time and memory
    while report.runs < runs if runs is not None else time.monotonic() < end:
        path.write_bytes(_mutant(chance))
        report.loaded += _run(path)
        report.runs += 1
    path.unlink()
    return report


def _run(path: Path) -> bool:
    begin = time.process_time()
    tracemalloc.start()
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", UrushiWarning)
            read_surface(path, resolution=8)
        return True
    except UrushiError as error:
        assert str(error) and "\n" not in str(error), "an error of several lines"
        return False
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < ALLOWANCE, f"{peak} bytes"
        assert time.process_time() - begin < TIME, "too slow"


def _mutant(chance: random.Random) -> bytes:
    text = chance.choice(SEEDS)
    for _ in range(chance.choice([1, 1, 2, 3, 6])):
        match chance.randrange(5):
            case 0 | 1:  # another word in place of one
                quoted = [i for i, c in enumerate(text) if c == '"']
                if len(quoted) > 1:
                    at = chance.randrange(len(quoted) // 2) * 2
                    begin, end = quoted[at] + 1, quoted[at + 1]
                    text = text[:begin] + chance.choice(WORDS) + text[end:]
            case 2:  # an element once more, or not at all
                lines = text.splitlines(keepends=True)
                at = chance.randrange(len(lines))
                lines[at : at + 1] = [lines[at]] * chance.choice([0, 2, 3])
                text = "".join(lines)
            case 3:  # another word in place of an attribute's or element's name
                words = text.split(" ")
                at = chance.randrange(len(words))
                words[at] = words[at].replace(words[at].partition("=")[0], chance.choice(WORDS), 1)
                text = " ".join(words)
            case 4:
                at = chance.randrange(len(text) + 1)
                text = text[:at] + chr(chance.randrange(1, 300)) + text[at + chance.randrange(3) :]
    return text.encode()


if __name__ == "__main__":
    duration = float(sys.argv[1])
    place = Path(tempfile.mkdtemp(prefix="fuzz-"))
    print(f"mutants in {place}")
    print(fuzz(place, int(sys.argv[2]) if len(sys.argv) > 2 else 0, seconds=duration))
