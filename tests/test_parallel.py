"""Large arrays by all cores: the same numbers as in one go, bounded memory, a clean end."""

import itertools
import os
import signal
import threading
import time

import numpy as np
import pytest

from urushi import parallel
from urushi.parallel import ROWS, blocks, fill_blocks


def _blas_threads():
    return [library["num_threads"] for library in parallel._blas().info()]


@pytest.fixture(params=[1, 3])
def threads(request, monkeypatch):
    monkeypatch.setattr(parallel, "available_cores", lambda: request.param)
    return request.param


@pytest.mark.parametrize("rows", [1, 7, 64])
@pytest.mark.parametrize(
    "shape",
    [(), (5,), (64,), (65,), (1000, 3), (3, 1000), (9, 1, 30, 3), (2, 99, 1), (0, 5), (5, 0)],
)
def test_blocks_tile_any_shape(shape, rows):
    times = np.zeros(shape, int)
    sizes = []
    for block in blocks(shape, rows):
        times[block] += 1
        sizes.append(times[block].size)
    assert (times == 1).all()
    # The worst cut: three along an axis, of which two fit, make blocks of two and of one.
    assert all(size <= rows for size in sizes)
    assert len(sizes) <= 1 or 3 * min(sizes) >= rows


# What broadcasts to 70 x 50 x 3 rows in every way: full, missing or single dimensions.
SHAPES = [(70, 50, 3), (70, 50, 1), (70, 1, 3), (1, 50, 3), (1, 1, 3), (1, 50, 1), (1, 1, 1)]


@pytest.mark.parametrize(("a", "b"), list(itertools.product(SHAPES, SHAPES)))
def test_blocks_broadcast_as_the_whole_does(a, b, threads):
    rng = np.random.default_rng(3)
    x, y = rng.random((*a, 4)), rng.random(b)
    seen = []

    def function(x, y):
        seen.append((x.shape, y.shape))
        return x + 2 * y[..., None]

    out = np.full((70, 50, 3, 4), np.nan)
    fill_blocks(out, function, x, y)
    np.testing.assert_array_equal(out, np.broadcast_to(x + 2 * y[..., None], out.shape))
    for whole, part in zip((a, b), seen[0], strict=True):  # nothing that is shared is repeated
        assert all(m == 1 for n, m in zip(whole, part, strict=False) if n == 1)


def test_blas_is_held_and_let_go():
    before = _blas_threads()
    inside = []

    def function(x):
        inside.extend(_blas_threads())
        return x

    x = np.zeros((4 * ROWS, 1))
    fill_blocks(np.empty_like(x), function, x)
    assert set(inside) == {1} and _blas_threads() == before


def _fail():
    raise ZeroDivisionError


def _interrupt():
    os.kill(os.getpid(), signal.SIGINT)  # reaches the main thread, which waits


@pytest.mark.parametrize(
    ("happening", "error"), [(_fail, ZeroDivisionError), (_interrupt, KeyboardInterrupt)]
)
def test_an_error_or_an_interrupt_ends_the_threads(happening, error, threads):
    before, calls, numbers = _blas_threads(), [], itertools.count(1)

    def function(x):
        number = next(numbers)  # each call gets one number, in any order of the threads
        calls.append(number)
        time.sleep(0.05)
        if number == 5:
            happening()
        return x

    x = np.zeros((1000 * ROWS, 1), np.float32)
    with pytest.raises(error):
        fill_blocks(np.empty_like(x), function, x)
    # Of a thousand blocks only those are finished that began before the main thread woke, for
    # which it has half a minute.
    assert len(calls) < 1000 and _blas_threads() == before
    # The interrupt may meet a thread that is just starting, and that ends as soon as it has: half
    # a minute more.
    for _ in range(3000):
        if not _own_threads():
            break
        time.sleep(0.01)
    assert not _own_threads()


def _own_threads():
    return [t for t in threading.enumerate() if t.name.startswith("urushi")]


def test_threads_of_the_caller_take_turns():
    before = _blas_threads()
    x = np.random.default_rng(4).random((20 * ROWS, 1))
    outs = [np.empty_like(x) for _ in range(4)]
    callers = [threading.Thread(target=fill_blocks, args=(out, np.sqrt, x)) for out in outs]
    for caller in callers:
        caller.start()
    for caller in callers:
        caller.join()
    assert all(np.array_equal(out, np.sqrt(x)) for out in outs)
    assert _blas_threads() == before


@pytest.mark.parametrize("outer", ["a task", "one thread of BLAS"])
def test_a_call_within_another_is_worked_on_by_its_thread(outer, threads):
    x = np.random.default_rng(5).random((5 * ROWS, 1))
    inner = []

    def nested(part):
        out, before = np.empty_like(x), threading.current_thread()
        fill_blocks(out, lambda y: inner.append(threading.current_thread() is before) or y, x)
        with parallel.one_blas_thread():
            return part + out[: len(part)]

    if outer == "a task":
        out = np.empty_like(x)
        fill_blocks(out, nested, x)
    else:
        with parallel.one_blas_thread():
            out = nested(x)
    assert all(inner) and len(inner) >= 5
    np.testing.assert_array_equal(out[:ROWS], x[:ROWS] + x[:ROWS])
