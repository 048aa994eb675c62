"""Dr.Jit arrays over NumPy's memory."""

import numpy as np
import pytest

from urushi.core.backend import backend, shared


@pytest.mark.parametrize("count", [1, 17, 99_999])
@pytest.mark.parametrize("kind, dtype", [("Float", np.float32), ("UInt32", np.uint32)])
def test_shared_memory_is_aligned_and_padded(kind, dtype, count):
    given: list[np.ndarray] = []
    values = np.arange(count + 1, dtype=dtype)[1:]  # starts beside an aligned address
    shared(lambda copy: given.append(copy), values)
    copy = given[0]
    assert copy.ctypes.data % 64 == 0
    whole = copy
    while isinstance(whole.base, np.ndarray):
        whole = whole.base
    assert whole.ctypes.data + whole.nbytes >= copy.ctypes.data + copy.nbytes + 64
    found = shared(getattr(backend(), kind), values)
    values[0] = 0
    assert np.array_equal(found.numpy(), np.arange(1, count + 1))
