"""The form of a network's hidden layers that is fastest where it runs."""

from collections.abc import Callable, Mapping, Sequence
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.render.networks import memory, network


def choose(
    params: Mapping[str, np.ndarray], prefix: str, activation: str, cooperative: bool | None = None
) -> Callable[[Sequence], list]:
    """The function from a network's first pre-activation to its output, both lists.

    cooperative: in cooperative vectors; None: where there is hardware for them.
    """
    if cooperative is None:
        cooperative = dr.backend_v(mi.Float) == dr.JitBackend.CUDA
    if cooperative:
        return memory.Hidden(params, prefix, activation)
    return partial(network.hidden_to_output, params, prefix, activation=activation)
