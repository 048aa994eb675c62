"""Data-parallel training: every device has all parameters and an equal part of a step's stacks."""

from dataclasses import dataclass
from typing import Any

import jax
import numpy as np
from jax.sharding import Mesh, NamedSharding, PartitionSpec

from urushi.errors import ParameterError

_AXIS = "stacks"


@dataclass(frozen=True)
class Devices:
    """The devices that share a stage's work.

    Attributes:
        mesh: a mesh of one axis; None for JAX's default device alone.
        stacks: number of stacks of a step, a multiple of the number of devices.
    """

    mesh: Mesh | None
    stacks: int

    @property
    def count(self) -> int:
        """Number of devices."""
        return 1 if self.mesh is None else self.mesh.size

    def replicated(self) -> NamedSharding | None:
        """The sharding of the parameters: a copy on every device."""
        return None if self.mesh is None else NamedSharding(self.mesh, PartitionSpec())

    def place(self, state: Any, batches: Any) -> tuple[Any, Any]:
        """Copy a state to every device, and split the batches between the devices.

        Args:
            state: a tree of arrays.
            batches: a tree of arrays (steps, B, ...). Arrays of all stacks are split along B. The
                coats, which only some stacks have, are small and copied to every device.
        """
        if self.mesh is None:
            return state, batches
        cut = NamedSharding(self.mesh, PartitionSpec(None, _AXIS))
        whole = self.replicated()
        shardings = jax.tree.map(lambda x: cut if x.shape[1] == self.stacks else whole, batches)
        return jax.device_put(state, whole), jax.device_put(batches, shardings)

    def collect(self, tree: Any) -> Any:
        """Copy replicated arrays to a single device."""
        return tree if self.mesh is None else jax.device_put(tree, jax.local_devices()[0])


def find(stacks: int) -> Devices:
    """All devices of this process, or the largest number of them that divides a step's stacks.

    Raises:
        ParameterError: there are several devices, but no two can share the stacks evenly.
    """
    devices = jax.local_devices()
    count = max(n for n in range(1, len(devices) + 1) if stacks % n == 0)
    if count == 1 < len(devices):
        raise ParameterError(
            f"a step uses {stacks} stacks, which {len(devices)} devices cannot share evenly; let "
            f"the preset's stacks add up to a multiple of {len(devices)}, or show JAX one device "
            "(CUDA_VISIBLE_DEVICES=0)"
        )
    return Devices(Mesh(np.array(devices[:count]), (_AXIS,)) if count > 1 else None, stacks)
