"""Dr.Jit's array types without Mitsuba."""

import functools
import importlib
from types import ModuleType
from typing import Any

import drjit as dr
import numpy as np

from urushi import platform


@functools.cache
def backend() -> ModuleType:
    """The module of Dr.Jit's array types: `drjit.cuda` if there is a GPU, else `drjit.llvm`."""
    if dr.has_backend(dr.JitBackend.CUDA):
        return importlib.import_module("drjit.cuda")
    platform.require_llvm()
    return importlib.import_module("drjit.llvm")


def shared(kind: type, values: np.ndarray) -> Any:
    """A flat Dr.Jit array of type `kind` over a copy of NumPy values of the same scalar type.

    Dr.Jit (1.5) shares the memory of NumPy arrays. Kernels for LLVM read whole packets of lanes, so
    that they read past an array whose length is no multiple of 16, and end the process if it ends
    with its page. They are also compiled anew for memory that does not start at a multiple of 64
    bytes. The copy starts there, and at least 64 bytes follow it.
    """
    room = np.empty(values.nbytes + 128, np.uint8)
    start = -room.ctypes.data % 64
    copy = room[start : start + values.nbytes].view(values.dtype)
    copy[:] = values.ravel()
    return kind(copy)
