"""Coverage-guided fuzzing of the measured-file readers.

usage: python tests/measured/fuzz_readers.py SECONDS [SEED]

Mutates small valid files; a mutant that reaches a new pair of successive lines in the readers joins
the corpus. The run ends and keeps the file if the readers raise anything but FileError or
ParameterError, warn, return a BRDF that is negative or not finite, or need much more memory than
the file's size. MERL tables have a single size, which is too large for the corpus: a few mutants
are MERL tables whose numbers are partly overwritten.
"""

import random
import struct
import sys
import tempfile
import time
import tracemalloc
import warnings
from dataclasses import dataclass
from importlib.util import module_from_spec, spec_from_file_location
from pathlib import Path

import numpy as np

from urushi.errors import FileError, ParameterError
from urushi.measured import load_measured, merl

NUMBERS = [0, 1, 2, 3, 4, 8, 90, 180, 255, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**62]
NUMBERS += [2**63, 2**64 - 1]
FLOATS = [0.0, -0.0, 1.0, -1.0, 1e-45, 3e38, -3e38, float("inf"), float("nan"), 500.0, 1e-20]
DOUBLES = [0.0, -1.0, 1e-300, 1e300, -1e300, 1e38, 5e-324, float("inf"), float("nan")]
ALLOWANCE = 1 << 20

#: Share of the mutants that are MERL tables.
TABLES = 0.005


@dataclass
class Report:
    runs: int
    loaded: int
    corpus: int


def fuzz(folder: Path, seed: int, runs: int | None = None, seconds: float = 0) -> Report:
    """Run `runs` mutants, or for `seconds`; raise any error that is not a user's error."""
    chance = random.Random(seed)
    seeds = _seeds()
    corpus = list(seeds)
    reached: set[tuple] = set()
    path, report, end = folder / "mutant", Report(0, 0, 0), time.monotonic() + seconds
    while report.runs < runs if runs is not None else time.monotonic() < end:
        content = None
        if report.runs < len(seeds):
            content = seeds[report.runs]
        elif report.runs > len(seeds) and chance.random() > TABLES:
            # Half of the mutants derive from valid files; else nearly all would fail in the header.
            parent = chance.choice(seeds[:2] if chance.random() < 0.5 else corpus)
            content = _mutate(chance, parent, corpus)
        if content is None:
            _write_table(chance, path)
        else:
            path.write_bytes(content)
        lines, loaded = _run(path, path.stat().st_size)
        report.runs += 1
        report.loaded += loaded
        if lines - reached and content is not None:
            corpus.append(content)
        reached |= lines
    report.corpus = len(corpus)
    path.unlink()
    return report


def _run(path: Path, size: int) -> tuple[set, bool]:
    """Load and evaluate; return the readers' pairs of successive lines, and whether it loaded."""
    lines: set[tuple] = set()
    last = [None]

    def trace(frame, event, _):
        if "/measured/" not in frame.f_code.co_filename:
            return None
        here = (frame.f_code.co_filename, frame.f_lineno)
        lines.add((last[0], here))
        last[0] = here
        return trace

    previous = sys.gettrace()
    tracemalloc.start()
    sys.settrace(trace)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("error")
            brdf = load_measured(path)
            f = brdf.f(*_DIRECTIONS)
        assert np.isfinite(f).all() and (f >= 0).all(), "f is negative or not finite"
        return lines, True
    except (FileError, ParameterError) as error:
        assert str(error) and "\n" not in str(error)
        return lines, False
    finally:
        sys.settrace(previous)
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < ALLOWANCE + 16 * size, f"{peak} bytes for a file of {size}"


def _mutate(chance: random.Random, content: bytes, corpus: list[bytes]) -> bytes:
    mutant = bytearray(content)
    for _ in range(chance.choice([1, 1, 1, 2, 4])):
        # Half of all changes fall on the first bytes, where the header is.
        limit = min(len(mutant), 512) if chance.random() < 0.5 else len(mutant)
        at = chance.randrange(limit) if limit else 0
        match chance.randrange(7):
            case 0:
                mutant[at : at + 1] = bytes([chance.randrange(256)])
            case 1:
                if limit:
                    mutant[at] ^= 1 << chance.randrange(8)
            case 2:
                width, letter = chance.choice([(1, "B"), (2, "H"), (4, "I"), (8, "Q")])
                number = chance.choice(NUMBERS) & (256**width - 1)
                mutant[at : at + width] = struct.pack("<" + letter, number)
            case 3:
                at += chance.randrange(4)  # data are not aligned
                mutant[at : at + 4] = struct.pack("<f", chance.choice(FLOATS))
            case 4:
                del mutant[at : at + chance.choice([1, 2, 4, 8, 64])]
            case 5:
                mutant = mutant[:at]
            case 6:
                other = chance.choice(corpus)
                cut = chance.randrange(len(other) + 1)
                mutant[at:] = other[cut : cut + len(content)]
    return bytes(mutant)


def _write_table(chance: random.Random, path: Path) -> None:
    """Write a black MERL file that is overwritten in runs of 1 to 10,000 numbers."""
    with path.open("wb") as file:
        file.write(np.array(merl.SHAPE, "<i4").tobytes())
        file.truncate(merl.FILE_SIZE + chance.choice([0, 0, 0, 0, 1, -1, -8, 8]))
        for _ in range(chance.choice([0, 1, 2, 8, 100])):
            number = chance.choice([*DOUBLES, chance.uniform(-1, 1e4)])
            file.seek(
                chance.choice([12 + 8 * chance.randrange(3 * 1458000), chance.randrange(100)])
            )
            file.write(struct.pack("<d", number) * int(10 ** chance.uniform(0, 4)))


def _seeds() -> list[bytes]:
    spec = spec_from_file_location("writers", Path(__file__).with_name("writers.py"))
    writers = module_from_spec(spec)
    spec.loader.exec_module(writers)
    rng = np.random.default_rng(0)
    rgb = writers.rgl_fields(rng, size=2, elevations=2)
    spectral = writers.rgl_fields(rng, wavelengths=[400, 500, 600], size=2, elevations=2)
    merl = np.array([90, 90, 180], "<i4").tobytes() + bytes(24)
    return [writers.tensor_file(rgb), writers.tensor_file(spectral), merl, b"<html></html>"]


def _directions() -> tuple[np.ndarray, np.ndarray]:
    rng = np.random.default_rng(0)
    w = rng.normal(size=(2, 16, 3))
    w[:, 0] = (0, 0, 1)
    w[0, 1] = w[1, 1]
    return tuple(w / np.linalg.norm(w, axis=2, keepdims=True))


_DIRECTIONS = _directions()

if __name__ == "__main__":
    duration = float(sys.argv[1])
    place = Path(tempfile.mkdtemp(prefix="fuzz-"))
    print(f"mutants in {place}")
    print(fuzz(place, int(sys.argv[2]) if len(sys.argv) > 2 else 0, seconds=duration))
