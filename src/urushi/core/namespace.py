"""Functions by which one text of a formula serves arrays, kernels and shaders.

A formula takes a `Namespace` as its last argument, `xp`, and directions with the components x, y
and z. Operands bring their own arithmetic. `NUMPY` and `arrays` are for NumPy, `arrays` for JAX,
`DRJIT` for Dr.Jit, and `urushi.export.statements.namespace` for the expressions of shader code.
"""

import functools
from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import drjit as dr
import numpy as np

Function = Callable[..., Any]


class Components(NamedTuple):
    """A vector whose components are arrays (...) or expressions."""

    x: Any
    y: Any
    z: Any


def _absent(*_: Any) -> Any:
    raise NotImplementedError("shader code does not have this function")


class Namespace(NamedTuple):
    """Functions of numbers, as in NumPy unless a comment says otherwise."""

    sqrt: Function
    safe_sqrt: Function  # with a finite derivative at 0
    exp: Function
    log: Function
    log1p: Function
    absolute: Function
    minimum: Function
    maximum: Function
    where: Function
    positive: Function  # at least zero, by the real part in a complex step; finite derivative
    sincos: Function  # sine and cosine of an angle [rad]
    normalized: Function  # a vector, scaled to length one
    clip: Function
    falling_logistic: Function  # 1 / (1 + exp(x)), without overflow
    # A value, given its name, by which shader code declares a variable.
    named: Callable[[str, Any], Any] = lambda _label, value: value
    # Shader code has none of the following.
    cos: Function = _absent
    arccos: Function = _absent
    arctan2: Function = _absent


DRJIT = Namespace(
    *(dr.sqrt, dr.safe_sqrt, dr.exp, dr.log, lambda x: dr.log(1 + x)),
    *(dr.abs, dr.minimum, dr.maximum, dr.select, lambda x: dr.select(x > 0, x, 0)),
    *(dr.sincos, dr.normalize, dr.clip, lambda x: 1 / (1 + dr.exp(x))),
    cos=dr.cos,
    arccos=dr.acos,
    arctan2=dr.atan2,
)


def arrays(x: Any) -> Namespace:
    """The functions of NumPy or JAX, whichever made the array x."""
    return _of_module(x.__array_namespace__())


@functools.cache
def _of_module(xp: Any) -> Namespace:
    def normalized(w: Components) -> Components:
        length = xp.sqrt(w.x * w.x + w.y * w.y + w.z * w.z)
        return Components(w.x / length, w.y / length, w.z / length)

    return Namespace(
        *(xp.sqrt, xp.sqrt, xp.exp, xp.log, xp.log1p),
        *(xp.abs, xp.minimum, xp.maximum, xp.where, lambda x: xp.where(x.real > 0.0, x, 0.0)),
        *(lambda x: (xp.sin(x), xp.cos(x)), normalized, xp.clip),
        lambda x: 0.5 - 0.5 * xp.tanh(0.5 * x),
        cos=xp.cos,
        arccos=xp.arccos,
        arctan2=xp.arctan2,
    )


NUMPY = _of_module(np)


def components(w: Any) -> Components:
    """The components (...) of an array (..., 3)."""
    return Components(w[..., 0], w[..., 1], w[..., 2])


def stacked(columns: Sequence[Any]) -> Any:
    """Arrays (...) of NumPy or JAX, which broadcast against each other, as one (..., C)."""
    xp = columns[0].__array_namespace__()
    return xp.stack(xp.broadcast_arrays(*columns), axis=-1)
