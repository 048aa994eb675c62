"""Code that Dr.Jit records: routines compiled once, work that is skipped, a cache of the vertex."""

import zlib
from collections.abc import Callable, Iterator, Sequence
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np
import numpy.typing as npt

from urushi.checks import Widths


def compiled_once(function: Callable, *args):
    """Return function(*args) as a call of a routine that a kernel holds once, however often called.

    Dr.Jit merges routines of equal code, also of different materials.
    """
    return dr.switch(mi.UInt32(0), [function], *args)


def only_where(active, function: Callable, *args):
    """Return function(*args), zeros where not active.

    Kernels jump over the function where none of the lanes of a vector is active, for instance where
    all rays have left the scene. Arguments and result are Dr.Jit arrays, in nested lists, named
    tuples and `Widths`.
    """
    results: list[Any] = []  # of the recorded call: its structure is needed for the zeros

    def evaluated(*values):
        result = function(*_nested_like(args, iter(values)))
        results.append(result)
        return _flat(result)

    def zeros(*values):
        if not results:  # no lane is active, and Dr.Jit knows it: the other branch is left out
            evaluated(*values)
        return [dr.zeros(type(value)) for value in _flat(results[0])]

    # Conditions of Dr.Jit take neither named tuples nor frozen dataclasses.
    values = dr.if_stmt(tuple(_flat(args)), active, evaluated, zeros)
    return _nested_like(results[0], iter(values))


def owned(kind: type, values: np.ndarray):
    """A flattened copy of NumPy values as a Dr.Jit array of type `kind`, in Dr.Jit's own memory.

    Dr.Jit shares NumPy's memory where it can. A plugin must not hold such memory: if it does not
    start at a multiple of the vector width, frozen functions (Dr.Jit 1.5) are replayed with the
    values of their recording; and freeing it while a function is recorded ends the process.
    """
    source = kind(np.ascontiguousarray(values).reshape(-1))
    copy = dr.zeros(kind, len(source))
    dr.scatter(copy, source, dr.arange(mi.UInt32, len(source)))
    dr.eval(copy)
    return copy


def signature(states: Sequence[int]) -> list:
    """Dr.Jit variables whose types encode small numbers, one each.

    A plugin that lists them among its variables lets frozen functions record again where its code
    changes: Dr.Jit compares the types of variables, but neither Python's values nor scalars.
    """
    kinds = (mi.Float, mi.UInt32, mi.Int32, mi.UInt64, mi.Int64)
    variables = [kinds[state](0) for state in states]
    dr.make_opaque(variables)
    return variables


def signature_of(numbers: npt.ArrayLike) -> list:
    """`signature` of numbers that are part of a plugin's code."""
    digits = np.base_repr(zlib.crc32(np.asarray(numbers, np.float64).tobytes()), 5)
    return signature([int(digit) for digit in digits])


def _flat(nested: Any) -> list:
    """The Dr.Jit floats of nested lists, named tuples and `Widths`."""
    if isinstance(nested, Widths):
        nested = [nested.u, nested.v]
    if isinstance(nested, list | tuple):
        return [value for part in nested for value in _flat(part)]
    return [nested]


def _nested_like(template: Any, values: Iterator) -> Any:
    """The inverse of `_flat`: values in the structure of a template."""
    if isinstance(template, Widths):
        return Widths(next(values), next(values))
    # No closure that calls itself: it would keep the values until Python looks for cycles. While a
    # frozen function is recorded, no scene may be freed.
    parts = [
        _nested_like(part, values) if isinstance(part, list | tuple | Widths) else next(values)
        for part in template
    ]
    return type(template)(*parts) if hasattr(template, "_fields") else parts


class CacheEntry(NamedTuple):
    """Inputs (Dr.Jit arrays), the scope of recorded code that they were used in, and the result."""

    inputs: Sequence
    scope: int
    result: Any


class VertexCache:
    """The last result that a plugin computed at a vertex of a path.

    Path integrators evaluate a BSDF towards a light and then draw a direction, one right after the
    other in the same recorded code, at the same vertex. Dr.Jit merges equal expressions but not
    equal calls.
    """

    def __init__(self):
        self._last: CacheEntry | None = None
        self._replaced: list[CacheEntry] = []

    def get(self, inputs: Sequence, compute: Callable[[], Any]) -> Any:
        """Return compute(), or the last result if the inputs are the same and it can be used.

        inputs: Dr.Jit arrays. A result can be used in the scope that it was computed in, and in
        the scopes that `extend` reaches: they follow it without leaving the recorded code.
        """
        last, self._last = self._last, None
        scope, indices = _scope(inputs), _indices(inputs)
        if last and (last.scope, _indices(last.inputs)) == (scope, indices):
            return last.result
        if not dr.flag(dr.JitFlag.FreezingScope):
            self._replaced.clear()
        elif last:
            # The entry may hold the last reference to a scene. Dr.Jit ends the process if a scene
            # is freed while a frozen function is recorded.
            self._replaced.append(last)
        result = compute()
        if dr.detail.any_symbolic(inputs):  # evaluated arrays would stay in memory
            self._last = CacheEntry(inputs, _scope(inputs), result)
        return result

    def extend(self) -> None:
        """Let the last result be used in the present scope too: only calls have come between."""
        if self._last:
            self._last = self._last._replace(scope=_scope(self._last.inputs))


def _scope(arrays: Sequence) -> int:
    return dr.detail.scope(dr.backend_v(arrays[0]))


def _indices(arrays: Sequence) -> list[tuple[int, int]]:
    return [(array.index, array.index_ad) for array in arrays]
