"""Kernels over jobs, pairs and points; their numbers are those of coats (`tests/material`)."""

import drjit as dr
import numpy as np

from urushi.core import lanes
from urushi.core.direction_sets import cosine_pairs


def pairs(count):
    return cosine_pairs(np.random.default_rng(1), count)


def test_one_kernel_for_any_number_of_pairs():
    """Compilation takes longer than a kernel."""

    def hashes(count):
        def value(lane):
            return lane.number(np.arange(3.0)) * lane.directions()[0].z

        with dr.scoped_set_flag(dr.JitFlag.KernelHistory, True):
            lanes.sums(value, 3, pairs(count), 4)
            return {k["hash"] for k in dr.kernel_history([dr.KernelType.JIT])}

    assert hashes(10) == hashes(23)
