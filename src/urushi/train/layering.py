"""The layering stage: the layerer alone, wider, on quadratic forms about what it makes so far."""

from typing import NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from urushi.nets.architecture import Architecture, Params
from urushi.train.forms import Forms, risen
from urushi.train.losses import apply
from urushi.train.order import Order

#: What a stack counts whose uppermost coat lies over a code that was decoded and encoded again,
#: as against the same stack layered coat after coat.
REENTRY = 0.5


class LayeringBatch(NamedTuple):
    """Stacks of all depths, deepest first; B of them, B_k with k coats or more.

    Attributes:
        bottoms, z, slope, curvature: as in `Forms`, of all B.
        coats: for the lowest coat, the next one up, and so on, (B_k, 5) for the first B_k stacks.
        below: (B_2, L) as in `Forms`.
        top: (B_2, 5) their uppermost coats.
    """

    bottoms: np.ndarray
    coats: tuple[np.ndarray, ...]
    below: np.ndarray
    top: np.ndarray
    z: np.ndarray
    slope: np.ndarray
    curvature: np.ndarray


class LayeringBatches:
    """Batches by step: every depth's stacks in shuffled epochs.

    Args:
        forms: by number of coats, from one up.
        stacks: how many stacks of each of these depths a step sees.
        seed: of the shuffling.
    """

    def __init__(self, forms: list[Forms], stacks: tuple[int, ...], seed: int) -> None:
        self._forms, self._stacks = forms, stacks
        sizes = [len(held.z) for held in forms]
        self._orders = [Order([[n]], n, seed, coats) for coats, n in enumerate(sizes, start=1)]

    def take(self, step: int, steps: int) -> LayeringBatch:
        """The batches of `steps` steps from `step` on, stacked along a first axis."""
        parts: list[Forms] = []
        for forms, order, count in reversed(
            list(zip(self._forms, self._orders, self._stacks, strict=True))
        ):
            runs = order.runs(step * count, steps * count)
            rows = np.concatenate([run.items for run in runs])
            parts.append(Forms(*(x[rows].reshape(steps, count, *x.shape[1:]) for x in forms)))
        levels = len(parts)

        def joined(name: str) -> np.ndarray:
            return np.concatenate([getattr(part, name) for part in parts], axis=1)

        several = parts[:-1] or [Forms(*(x[:, :0] for x in parts[0]))]
        return LayeringBatch(
            bottoms=joined("bottoms"),
            coats=tuple(
                np.concatenate([part.coats[:, :, -1 - k] for part in parts[: levels - k]], axis=1)
                for k in range(levels)
            ),
            below=np.concatenate([part.below for part in several], axis=1),
            top=np.concatenate([part.coats[:, :, 0] for part in several], axis=1),
            z=joined("z"),
            slope=joined("slope"),
            curvature=joined("curvature"),
        )


def layering_loss(
    params: Params, arch: Architecture, batch: LayeringBatch
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """By how much the stacks' loss exceeds that of the codes before, and its terms.

    - fit: coat after coat over the encoded bottom;
    - reentry: the uppermost coat over all that is below, decoded and encoded again.
    """
    z = apply(params, arch, batch.bottoms, batch.coats)
    fit = risen(z, batch.z, batch.slope, batch.curvature)
    some = slice(len(batch.below))
    again = apply(params, arch, batch.below, (batch.top,))
    reentry = risen(again, batch.z[some], batch.slope[some], batch.curvature[some])
    count = len(fit) + REENTRY * len(reentry)
    loss = (jnp.sum(fit) + REENTRY * jnp.sum(reentry)) / count
    return loss, {"loss": loss, "fit": jnp.mean(fit), "reentry": jnp.sum(reentry) / count}
