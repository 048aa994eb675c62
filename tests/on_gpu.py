"""Run tests of LLVM variants on an NVIDIA GPU: `pytest -p tests.on_gpu tests/mitsuba ...`.

It puts Mitsuba's and Dr.Jit's CUDA counterparts in the place of what the tests ask for.
"""

import sys
from collections.abc import Callable

import drjit as dr
import drjit.cuda.ad
import mitsuba as mi


def _on_cuda(choose: Callable[..., None]) -> Callable[..., None]:
    return lambda *names: choose(*(name.replace("llvm", "cuda") for name in names))


mi.set_variant = _on_cuda(mi.set_variant)
sys.modules |= {"drjit.llvm": drjit.cuda, "drjit.llvm.ad": drjit.cuda.ad}
dr.llvm = drjit.cuda
