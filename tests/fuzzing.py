"""Mutants of small valid files: readers refuse them in one sentence, in bounded time and memory."""

import random
import struct
import time
import tracemalloc
import warnings
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from urushi.errors import UrushiError, UrushiWarning

NUMBERS = [0, 1, 2, 3, 4, 8, 90, 180, 255, 2**15, 2**16 - 1, 2**31 - 1, 2**31, 2**32 - 1, 2**62]
NUMBERS += [2**63, 2**64 - 1]
FLOATS = [0.0, -0.0, 1.0, -1.0, 1e-45, 3e38, -3e38, float("inf"), float("nan"), 500.0, 1e-20]

#: Longest time of a file [s].
TIME = 60.0


def fuzz(
    read: Callable[[Path], object],
    path: Path,
    seeds: Sequence[bytes],
    runs: int,
    memory: int,
    words: Sequence[str] = (),
) -> int:
    """The number of the mutants that are read; another error than a user's is raised.

    Args:
        path: where the seeds, and then their mutants, are written.
        memory: bytes that may be allocated, besides 16 for each byte of the file.
        words: that replace quoted words and names, in files of text.
    """
    chance, count = random.Random(1), 0
    for run in range(runs):
        content = seeds[run] if run < len(seeds) else _mutant(chance, seeds, words)
        path.write_bytes(content)
        count += _is_read(read, path, memory + 16 * len(content))
    return count


@contextmanager
def bounded(memory: int) -> Iterator[None]:
    """Fail where more bytes are allocated at once."""
    tracemalloc.start()
    try:
        yield
    finally:
        peak = tracemalloc.get_traced_memory()[1]
        tracemalloc.stop()
        assert peak < memory, f"{peak} bytes"


def _is_read(read: Callable[[Path], object], path: Path, memory: int) -> bool:
    begin = time.process_time()
    try:
        with bounded(memory), warnings.catch_warnings():
            warnings.simplefilter("error")
            warnings.simplefilter("ignore", UrushiWarning)
            read(path)
        return True
    except UrushiError as error:
        assert str(error) and "\n" not in str(error), "an error of several lines"
        return False
    finally:
        assert time.process_time() - begin < TIME, "too slow"


def _mutant(chance: random.Random, seeds: Sequence[bytes], words: Sequence[str]) -> bytes:
    content = bytearray(chance.choice(seeds))
    for _ in range(chance.choice([1, 1, 2, 3, 6])):
        change = chance.choice((_other_word, _other_line) if words else (_other_number, _cut))
        change = _other_byte if chance.random() < 0.25 else change
        content = bytearray(change(chance, content, seeds, words))
    return bytes(content)


def _place(chance: random.Random, content: bytes) -> int:
    """Half of all places are among the first bytes, where a header is."""
    limit = min(len(content), 512) if chance.random() < 0.5 else len(content)
    return chance.randrange(limit + 1)


def _other_byte(chance, content, seeds, words):
    at = _place(chance, content)
    content[at : at + chance.randrange(3)] = bytes([chance.randrange(256)])
    return content


def _other_number(chance, content, seeds, words):
    at = _place(chance, content)
    if chance.random() < 0.4:
        number = struct.pack("<f", chance.choice(FLOATS))
    else:
        width, letter = chance.choice([(1, "B"), (2, "H"), (4, "I"), (8, "Q")])
        number = struct.pack("<" + letter, chance.choice(NUMBERS) & (256**width - 1))
    content[at : at + len(number)] = number
    return content


def _cut(chance, content, seeds, words):
    """Some bytes less, or the end of another seed."""
    at, other = _place(chance, content), chance.choice(seeds)
    if chance.random() < 0.5:
        del content[at : at + chance.choice([1, 2, 4, 8, 64, len(content)])]
        return content
    return content[:at] + other[chance.randrange(len(other) + 1) :][: len(content)]


def _other_word(chance, content, seeds, words):
    """Another word in place of a quoted one, or of a name before an equals sign."""
    parts = content.split(b'"')
    at = chance.randrange(len(parts))
    word = chance.choice(words).encode()
    if at % 2:
        parts[at] = word
    else:
        head, space, _ = parts[at].rpartition(b" ")
        parts[at] = head + space + word + b"="
    return b'"'.join(parts)


def _other_line(chance, content, seeds, words):
    """A line once more, or not at all."""
    lines = content.splitlines(keepends=True)
    at = chance.randrange(len(lines))
    lines[at : at + 1] = [lines[at]] * chance.choice([0, 2, 3])
    return b"".join(lines)
