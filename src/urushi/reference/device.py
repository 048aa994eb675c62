"""Which Dr.Jit backend the reference runs on: CUDA where there is one, else LLVM."""

import functools
import importlib
from types import ModuleType

import drjit as dr

from urushi import backend


@functools.cache
def types() -> ModuleType:
    """The module of Dr.Jit array types to use (`drjit.cuda` or `drjit.llvm`).

    Raises:
        PlatformError: there is no GPU, and no libLLVM that Dr.Jit can use.
    """
    if dr.has_backend(dr.JitBackend.CUDA):
        return importlib.import_module("drjit.cuda")
    backend.require_llvm()
    return importlib.import_module("drjit.llvm")
