"""Training examples in memory; which of them a step sees is a function of seed and step alone."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

from urushi.data.spec import Part
from urushi.data.store import Store
from urushi.errors import ParameterError
from urushi.nets.architecture import Architecture
from urushi.nets.features import coat_features, direction_features
from urushi.nets.probes import probe_pairs
from urushi.reference import evaluate


class Batch(NamedTuple):
    """Stacks of all depths, deepest first, so that coat after coat is applied to fewer of them.

    Attributes:
        probes: (B, probes) the bottoms' values [1/sr] at the probe pairs.
        coats: for the lowest coat, the next one up, and so on: coat features of the first B_k
            stacks, which are those that have this coat, (B_k, 16).
        features: (B, P, 8) of the direction pairs.
        f: (B, P) simulated values [1/sr].
    """

    probes: np.ndarray
    coats: tuple[np.ndarray, ...]
    features: np.ndarray
    f: np.ndarray


@dataclass(frozen=True)
class Depth:
    """All examples with the same number of coats; an item is one run of a stack's pairs.

    Attributes:
        probes: (S, probes).
        coats: (S, N, 16) coat features, top to bottom.
        features: (S R, P, 8), the R runs of a stack side by side.
        f: (S R, P).
    """

    probes: np.ndarray
    coats: np.ndarray
    features: np.ndarray
    f: np.ndarray

    @property
    def runs(self) -> int:
        """Runs of pairs of every stack."""
        return len(self.f) // len(self.probes)


def load(store: Store, arch: Architecture, pairs: int) -> list[Depth]:
    """Read the training parts of a complete store.

    Args:
        store: the data.
        arch: fixes the number of probes.
        pairs: direction pairs that a step sees of one stack; every part has a multiple of it.

    Returns:
        The examples by number of coats, from none up.
    """
    by_depth: dict[int, list[Depth]] = {}
    for part in store.spec.parts:
        if part.directions == "training":
            example = _read(store, part, arch, pairs)
            by_depth.setdefault(part.distribution.coats, []).append(example)
    if sorted(by_depth) != list(range(len(by_depth))):
        raise ParameterError(
            "the training data must hold stacks of 0, 1, ... coats without a gap, not of "
            + ", ".join(map(str, sorted(by_depth)))
        )
    return [_joined(by_depth[coats]) for coats in range(len(by_depth))]


def bottom_values(part: Part, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of a part's bottoms (S, K), in air, at the probe pairs: exact."""
    names = evaluate.BOTTOM_KINDS[part.distribution.bottom][1]
    wi, wo = probe_pairs(arch.probes)
    count = len(bottom)
    values = evaluate.rows(
        part.distribution.bottom,
        dict(zip(names, bottom.T, strict=True)),
        np.repeat(np.arange(count, dtype=np.uint32), arch.probes),
        np.tile(wi, (count, 1)),
        np.tile(wo, (count, 1)),
    )
    return values.reshape(count, arch.probes)


def coat_inputs(part: Part, arrays: dict[str, np.ndarray]) -> np.ndarray:
    """Coat features (S, N, 16) of a part's arrays."""
    if part.distribution.coats == 0:
        nothing = np.zeros((part.stacks, 0), np.float32)
        return coat_features(*(nothing,) * 5)
    return coat_features(*np.moveaxis(arrays["coats"], -1, 0)).astype(np.float32)


def _read(store: Store, part: Part, arch: Architecture, pairs: int) -> Depth:
    if part.pairs % pairs:
        raise ParameterError(
            f"part '{part.name}' has {part.pairs} pairs for each stack; "
            f"that must be a multiple of the {pairs} that a step sees"
        )
    arrays = store.read(part)
    features = direction_features(arrays["wi"], arrays["wo"]).astype(np.float32)
    return Depth(
        probes=bottom_values(part, arrays["bottom"], arch),
        coats=coat_inputs(part, arrays),
        features=features.reshape(-1, pairs, features.shape[-1]),
        f=arrays["f"].reshape(-1, pairs),
    )


def _joined(parts: list[Depth]) -> Depth:
    names = ("probes", "coats", "features", "f")
    return Depth(
        **{name: np.concatenate([getattr(part, name) for part in parts]) for name in names}
    )


class Batches:
    """Batches by step: every depth's items in shuffled epochs, each its own permutation.

    Args:
        depths: the examples, by number of coats.
        stacks: how many stacks of each depth a step sees.
        seed: of the shuffling.
    """

    def __init__(self, depths: list[Depth], stacks: tuple[int, ...], seed: int) -> None:
        if len(stacks) != len(depths):
            raise ParameterError(
                f"the data holds stacks of up to {len(depths) - 1} coats, but the preset draws "
                f"stacks of up to {len(stacks) - 1}; give one number for each depth"
            )
        self._depths = depths
        self._stacks = stacks
        self._seed = seed
        self._epochs: dict[int, tuple[int, np.ndarray]] = {}

    def take(self, step: int, steps: int) -> Batch:
        """The batches of `steps` steps from `step` on, stacked along a first axis."""
        parts = []
        for coats in reversed(range(len(self._depths))):  # deepest first
            depth, count = self._depths[coats], self._stacks[coats]
            items = self._items(coats, step * count, steps * count).reshape(steps, count)
            rows = items // depth.runs
            parts.append(
                (depth.probes[rows], depth.coats[rows], depth.features[items], depth.f[items])
            )
        levels = len(self._depths) - 1
        return Batch(
            probes=np.concatenate([part[0] for part in parts], axis=1),
            coats=tuple(
                np.concatenate([part[1][:, :, -1 - k] for part in parts[: levels - k]], axis=1)
                for k in range(levels)
            ),
            features=np.concatenate([part[2] for part in parts], axis=1),
            f=np.concatenate([part[3] for part in parts], axis=1),
        )

    def _items(self, coats: int, start: int, count: int) -> np.ndarray:
        """Items `start` to `start + count` of a depth's endless sequence of epochs."""
        size = len(self._depths[coats].f)
        pieces = []
        while count:
            epoch, first = divmod(start, size)
            piece = self._epoch(coats, epoch)[first : first + count]
            pieces.append(piece)
            start, count = start + len(piece), count - len(piece)
        return np.concatenate(pieces)

    def _epoch(self, coats: int, epoch: int) -> np.ndarray:
        if self._epochs.get(coats, (-1,))[0] != epoch:
            seeds = np.random.SeedSequence(self._seed, spawn_key=(coats, epoch))
            order = np.random.default_rng(seeds).permutation(len(self._depths[coats].f))
            self._epochs[coats] = epoch, order
        return self._epochs[coats][1]
