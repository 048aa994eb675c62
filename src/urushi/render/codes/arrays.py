"""NumPy's numbers in memory of Dr.Jit's own, as frozen functions need them."""

import drjit as dr
import mitsuba as mi
import numpy as np


def owned(kind: type, values: np.ndarray):
    """A copy of numbers, flattened, as a Dr.Jit array of a kind.

    Dr.Jit takes NumPy's memory as it is where it can. But what a plugin holds must not be: where
    that memory does not start at a multiple of the vector width, frozen functions (Dr.Jit 1.5) are
    replayed with the numbers of their recording; and while one is recorded, such an array cannot be
    freed without ending the process.
    """
    source = kind(np.ascontiguousarray(values).reshape(-1))
    copy = dr.zeros(kind, len(source))
    dr.scatter(copy, source, dr.arange(mi.UInt32, len(source)))
    dr.eval(copy)
    return copy
