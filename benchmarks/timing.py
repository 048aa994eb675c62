"""CPU times of operations that take turns, so that other load affects all of them alike."""

import time
from collections.abc import Callable, Mapping
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.mitsuba.reading import probing


def seconds(operation: Callable[[], Any]) -> float:
    """CPU time of an operation, of all threads [s]."""
    begin = time.process_time()
    operation()
    return time.process_time() - begin


def evaluation(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray | None = None
) -> Callable[[], Any]:
    """The evaluation of a BSDF at pairs (N, 3) in memory, for `kernel`; uv: (N, 2)."""
    si = probing.interaction(wi, np.full((len(wi), 2), 0.5) if uv is None else uv)
    out = mi.Vector3f(np.ascontiguousarray(wo.T, np.float32))
    dr.eval(si, out)
    return partial(bsdf.eval, mi.BSDFContext(), si, out)


def kernel(record: Callable[[], Any]) -> float:
    """CPU time of a kernel of Dr.Jit without that of recording it [s]."""
    value = record()
    dr.schedule(value)

    def evaluate() -> None:
        dr.eval(value)
        dr.sync_thread()

    return seconds(evaluate)


def calls(functions: Mapping[str, Callable[[], Any]], turns: int) -> dict[str, float]:
    """The least CPU time of each function over turns of all [s]; see `least`."""
    return least({name: partial(seconds, call) for name, call in functions.items()}, turns)


def least(operations: Mapping[str, Callable[[], float]], turns: int) -> dict[str, float]:
    """The least time that each operation returns over turns of all; the first one compiles."""
    times: dict[str, list[float]] = {name: [] for name in operations}
    for turn in range(turns + 1):
        for name, operation in operations.items():
            value = operation()
            if turn > 0:
                times[name].append(value)
    return {name: min(values) for name, values in times.items()}
