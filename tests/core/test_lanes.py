"""Kernels over jobs, pairs and points against NumPy, and Dr.Jit arrays over its memory."""

import drjit as dr
import numpy as np
import pytest

from urushi.core import lanes
from urushi.core.backend import backend, shared
from urushi.core.direction_sets import cosine_pairs
from urushi.core.table import SHAPE, interpolated_at


def pairs(count):
    return cosine_pairs(np.random.default_rng(1), count)


def test_sums_are_those_of_numpy():
    """Jobs have their own numbers, pairs their directions, points their numbers of a lattice."""
    sides, numbers, points, generator = pairs(7), np.array([2.0, 3.0, 5.0]), 64, 19

    def value(lane):
        wi, wo = lane.directions()
        u = lane.lattice(points, generator)
        return lane.number(numbers) * (wi.z + 2 * wo.x) * (u[0] + u[3] * u[3])

    index = np.arange(points)
    u = [(index * generator**k % points + 0.5) / points for k in (0, 3)]
    of_points, of_pairs = (u[0] + u[1] ** 2).sum(), sides[0][:, 2] + 2 * sides[1][:, 0]
    expected = of_pairs[:, None] * numbers * of_points
    np.testing.assert_allclose(lanes.sums(value, 3, sides, points), expected, rtol=1e-5)


def test_tables_are_looked_up_as_by_numpy():
    tables = np.random.default_rng(0).random((2, *SHAPE)).astype(np.float32)
    places, (wi, _) = np.array([0.3, 0.7, 0.1]), pairs(5)
    found = lanes.sums(
        lambda lane: lane.table(tables)([0 * lane.directions()[0].z + float(x) for x in places]),
        2,
        (wi, wi),
        1,
    )
    expected = np.log(interpolated_at(np.moveaxis(tables, 0, -1), *places[:, None]))
    np.testing.assert_allclose(found, np.repeat(expected, 5, axis=0), rtol=1e-4)


def test_one_kernel_for_any_number_of_pairs():
    """Compilation takes longer than a kernel."""

    def hashes(count):
        def value(lane):
            return lane.number(np.arange(3.0)) * lane.directions()[0].z

        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            lanes.sums(value, 3, pairs(count), 4)
            return {k["hash"] for k in dr.kernel_history([dr.KernelType.JIT])}

    assert hashes(10) == hashes(23)


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
