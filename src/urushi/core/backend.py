"""Dr.Jit's array types without Mitsuba."""

import functools
import importlib
from types import ModuleType

import drjit as dr

from urushi import platform


@functools.cache
def backend() -> ModuleType:
    """The module of Dr.Jit's array types: `drjit.cuda` if there is a GPU, else `drjit.llvm`."""
    if dr.has_backend(dr.JitBackend.CUDA):
        return importlib.import_module("drjit.cuda")
    platform.require_llvm()
    return importlib.import_module("drjit.llvm")
