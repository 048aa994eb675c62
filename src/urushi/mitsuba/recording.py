"""Code that Dr.Jit records: routines compiled once, work that is skipped, a cache of the vertex."""

import zlib
from collections.abc import Callable, Hashable, Iterable, Iterator
from functools import partial
from numbers import Number
from types import FunctionType, MethodType, ModuleType
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.backend import shared


def compiled_once(function: Callable, *args):
    """Return function(*args) as a call of a routine that a kernel holds once, however often called.

    Dr.Jit merges routines of equal code, also of different materials.
    """
    return dr.switch(mi.UInt32(0), [function], *args)


def only_where(active, function: Callable, *args):
    """Return function(*args), zeros where not active.

    Kernels jump over the function where none of the lanes of a vector is active, for instance where
    all rays have left the scene. Arguments and result are Dr.Jit arrays, and numbers that stay the
    same, in nested lists, named tuples and `Widths`.
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
    source = shared(kind, values)
    copy = dr.zeros(kind, len(source))
    dr.scatter(copy, source, dr.arange(mi.UInt32, len(source)))
    dr.eval(copy)
    return copy


def opaque(value: float) -> "mi.Float":
    """A Dr.Jit scalar that kernels read from memory, so that plugins of one type share code."""
    scalar = mi.Float(value)
    dr.make_opaque(scalar)
    return scalar


class Recorded:
    """Base of what Mitsuba's objects hold: frozen functions see the variables in all its parts.

    Dr.Jit 1.5 calls the two methods, and looks by itself into containers, not into other objects.
    """

    def _traverse_1_cb_ro(self, callback):
        """Show Dr.Jit the variables."""
        for part in [self, *_objects_in(_parts(self), {})]:
            dr.detail.traverse_py_cb_ro(part, callback)

    def _traverse_1_cb_rw(self, callback):
        """Let Dr.Jit replace them."""
        for part in [self, *_objects_in(_parts(self), {})]:
            dr.detail.traverse_py_cb_rw(part, callback)


def signature_of(plugin: Any) -> list:
    """Dr.Jit variables whose types encode what a plugin's recorded code may depend on.

    A plugin holds them, so that frozen functions record again where its code changes: Dr.Jit
    compares the types of variables, but not Python's values, which code contains as literals.

    They encode a hash of all attributes, and of the attributes of all objects in them. Left out are
    the contents of arrays, which code reads from memory, and attributes that a class lists in
    `UNRECORDED`. Weights are known by their fingerprint.
    """
    digits = np.base_repr(zlib.crc32(repr([*_described(plugin, {})]).encode()), 5).zfill(14)
    kinds = (mi.Float, mi.UInt32, mi.Int32, mi.UInt64, mi.Int64)
    variables = [kinds[int(digit)](0) for digit in digits]
    dr.make_opaque(variables)
    return variables


#: Types of values without parts.
PLAIN = type | str | bytes | Number | np.generic | np.ndarray | ModuleType | None


def _objects_in(value: Any, seen: dict[int, Any]) -> Iterator[Any]:
    """Objects with attributes in a value, once each; seen: by id.

    Left out are those at which Dr.Jit looks by itself.
    """
    if isinstance(value, PLAIN | mi.Object | Recorded) or dr.is_array_v(value) or id(value) in seen:
        return
    seen[id(value)] = value
    if hasattr(value, "__dict__") and not isinstance(value, FunctionType | partial):
        yield value
    for part in _parts(value):
        yield from _objects_in(part, seen)


def _described(value: Any, seen: dict[int, Any]) -> Iterator[str]:
    """A value as `signature_of` takes it; seen: objects that need no second description, by id."""
    if isinstance(value, PLAIN) and not isinstance(value, np.ndarray):
        yield repr(value)
        return
    if isinstance(value, np.ndarray) or dr.is_array_v(value):
        in_memory = isinstance(value, np.ndarray) or dr.is_jit_v(value)
        yield "array" if in_memory else repr(value)
        return
    yield type(value).__qualname__
    if isinstance(mark := getattr(value, "fingerprint", None), str):
        yield mark
        return
    if id(value) in seen:
        yield str([*seen].index(id(value)))
        return
    seen[id(value)] = value
    for part in _parts(value):
        yield from _described(part, seen)


def _parts(value: Any) -> Iterable[Any]:
    """The contents of a container, a function or another object; of weights, nothing."""
    if isinstance(getattr(value, "fingerprint", None), str):
        return ()
    if isinstance(value, dict):
        return [x for item in value.items() for x in item]
    if isinstance(value, set | frozenset):
        return sorted(map(repr, value))
    if isinstance(value, list | tuple):
        return [len(value), *value]
    if isinstance(value, FunctionType):
        cells = [cell.cell_contents for cell in value.__closure__ or ()]
        return [value.__qualname__, *cells, value.__defaults__, value.__kwdefaults__]
    if isinstance(value, MethodType):
        return [value.__func__, value.__self__]
    if isinstance(value, partial):
        return [value.func, value.args, value.keywords]
    left_out = {name for kind in type(value).__mro__ for name in vars(kind).get("UNRECORDED", ())}
    named = getattr(value, "__dict__", {}).items()
    return [x for name, part in named if name not in left_out for x in (name, part)]


def _flat(nested: Any) -> list:
    """The Dr.Jit floats of nested lists, named tuples and `Widths`."""
    if isinstance(nested, Widths):
        nested = [nested.u, nested.v]
    if isinstance(nested, list | tuple):
        return [value for part in nested for value in _flat(part)]
    return [] if isinstance(nested, Number) else [nested]


def _nested_like(template: Any, values: Iterator) -> Any:
    """The inverse of `_flat`: values in the structure of a template."""
    if isinstance(template, Number):
        return template
    if isinstance(template, Widths):
        return Widths(_nested_like(template.u, values), _nested_like(template.v, values))
    if not isinstance(template, list | tuple):
        return next(values)
    # No closure that calls itself: it would keep the values until Python looks for cycles. While a
    # frozen function is recorded, no scene may be freed.
    parts = [_nested_like(part, values) for part in template]
    return type(template)(*parts) if hasattr(template, "_fields") else parts


class CacheEntry(NamedTuple):
    """A result, the scope of recorded code that it was computed in, and what it was computed of."""

    key: Hashable
    inputs: list[int]  # indices of Dr.Jit variables
    arrays: Any  # which keep the variables
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

    def get(self, key: Hashable, si, active, compute: Callable[[], Any]) -> Any:
        """Return compute(), or the last result if the inputs are the same and it can be used.

        Inputs are the key, the surface interaction and the active lanes. A result can be used in
        the scope that it was computed in, and in the scopes that `extend` reaches: they follow it
        without leaving the recorded code.
        """
        last, self._last = self._last, None
        arrays = mi.SurfaceInteraction3f(si), active  # a copy: callers may change theirs
        inputs = dr.detail.collect_indices(arrays)
        if last and (last.scope, last.key, last.inputs) == (_scope(), key, inputs):
            return last.result
        if not dr.flag(dr.JitFlag.FreezingScope):
            self._replaced.clear()
        elif last:
            # The entry may hold the last reference to a scene. Dr.Jit ends the process if a scene
            # is freed while a frozen function is recorded.
            self._replaced.append(last)
        result = compute()
        if dr.detail.any_symbolic(arrays):  # evaluated arrays would stay in memory
            self._last = CacheEntry(key, inputs, arrays, _scope(), result)
        return result

    def extend(self) -> None:
        """Let the last result be used in the present scope too: only calls have come between."""
        if self._last:
            self._last = self._last._replace(scope=_scope())


def _scope() -> int:
    return dr.detail.scope(dr.backend_v(mi.Float))
