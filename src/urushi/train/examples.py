"""Training examples from a data store.

The examples of a step depend only on seed and step (see `order`), so that a training that was
interrupted continues to the same bits.
"""

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import COAT_COLUMNS, CoatParameters
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.errors import ParameterError
from urushi.nets import lobe as lobes
from urushi.nets.architecture import Architecture
from urushi.nets.features import DIRECTION_FEATURES, direction_features
from urushi.train.bottoms import bottom_lobes, bottom_rest
from urushi.train.data.spec import Part
from urushi.train.data.store import Store
from urushi.train.order import Order
from urushi.walk.bottoms import KINDS

#: The arrays that are read from a store.
ARRAYS = ("coats", "bottom", "wi", "wo", "f")


class Batch(NamedTuple):
    """Stacks of all depths, deepest first, so that each coat belongs to the first stacks.

    Attributes:
        lobes: (B, L) the bottoms' lobes, see `nets.lobe`.
        probes: (B, probes) the bottoms' values [1/sr] at the probe pairs, without their lobes.
        coats: (B_k, C) columns `checks.COAT_COLUMNS` of each coat, the lowest first, for the B_k
            stacks that have this coat, which are the first ones of the batch.
        features: (B, P, D) of the direction pairs.
        top: (B, P) the part of f [1/sr] that the stacks' own lobes reflect.
        f: (B, P) simulated values [1/sr].
    """

    lobes: np.ndarray
    probes: np.ndarray
    coats: tuple[np.ndarray, ...]
    features: np.ndarray
    top: np.ndarray
    f: np.ndarray


@dataclass(frozen=True)
class Examples:
    """Examples in memory, all with the same number of coats; an item is one run of pairs.

    Attributes:
        lobes: (S, L).
        probes: (S, probes).
        coats: (S, N, C) columns `checks.COAT_COLUMNS`, top to bottom.
        stack: (I,) the stack of each item; the items of a stack lie side by side.
        features: (I, P, D).
        top: (I, P).
        f: (I, P).
    """

    lobes: np.ndarray
    probes: np.ndarray
    coats: np.ndarray
    stack: np.ndarray
    features: np.ndarray
    top: np.ndarray
    f: np.ndarray


class Depth:
    """The examples of one depth, read from the store when they are first needed.

    Args:
        store: a complete store.
        parts: the indices of its parts that have this depth.
        arch: determines the number of probes.
        pairs: number of direction pairs of an item.
    """

    def __init__(self, store: Store, parts: list[int], arch: Architecture, pairs: int) -> None:
        self._store, self._arch, self._pairs = store, arch, pairs
        self._shards = [
            (part, shard)
            for part in parts
            for shard in range(store.spec.shard_count(store.spec.parts[part]))
        ]
        self.items = sum(self._items(*shard) for shard in self._shards)
        self._held: Examples | None = None

    def examples(self) -> Examples:
        """All examples, which stay in memory until `forget`."""
        if self._held is None:
            self._held = self._read()
        return self._held

    def mirrored(self) -> Examples:
        """All stacks with their x and y axes exchanged, which are not held in memory."""
        return self._read(mirrored=True)

    def forget(self) -> None:
        """Release the examples in memory; the next use reads them again."""
        self._held = None

    def _items(self, part: int, shard: int) -> int:
        rows = self._store.spec.rows(part, shard)
        used = trained_pairs(self._store.spec.parts[part])
        return (rows.stop - rows.start) * ((used.stop - used.start) // self._pairs)

    def _read(self, mirrored: bool = False) -> Examples:
        """Read shard after shard into arrays that have room for all."""
        widths = self._arch.widths
        size = DIRECTION_FEATURES[widths]
        features = np.empty((self.items, self._pairs, size), np.float32)
        f, top = (np.empty((self.items, self._pairs), np.float32) for _ in range(2))
        encoded, probes, coats, stack, first, stacks = [], [], [], [], 0, 0
        for index, shard in self._shards:
            part = self._store.spec.parts[index]
            arrays = self._store.read_shard(index, shard, ARRAYS)
            if mirrored:
                arrays = mirror_images(part, arrays)
            place = slice(first, first + self._items(index, shard))
            used, values = trained_pairs(part), arrays["f"]
            wi, wo = arrays["wi"][:, used], arrays["wo"][:, used]
            of_pairs = direction_features(wi, wo, widths)
            features[place] = of_pairs.reshape(-1, self._pairs, size)
            f[place] = values[:, used].reshape(-1, self._pairs)
            topmost = top_lobes(part, arrays, self._arch)
            top[place] = lobes.f(topmost[:, None], wi, wo).reshape(-1, self._pairs)
            own, rest = encoder_inputs(part, arrays, self._arch)
            encoded.append(own)
            probes.append(rest)
            coats.append(coats_to_layer(part, arrays))
            numbers = np.arange(stacks, stacks + len(values), dtype=np.int32)
            stack.append(np.repeat(numbers, (used.stop - used.start) // self._pairs))
            first, stacks = place.stop, stacks + len(numbers)
        return Examples(
            lobes=np.concatenate(encoded),
            probes=np.concatenate(probes),
            coats=np.concatenate(coats),
            stack=np.concatenate(stack),
            features=features,
            top=top,
            f=f,
        )


def load(store: Store, arch: Architecture, pairs: int) -> list[Depth]:
    """Prepare the training parts of a complete store.

    Args:
        store: the data.
        arch: determines the number of probes.
        pairs: direction pairs of one stack in a step; the number of pairs of every part must be a
            multiple of it.

    Returns:
        The examples by number of coats, from 0 up; 36 bytes of memory for each direction pair.
    """
    by_depth: dict[int, list[int]] = {}
    for index, part in enumerate(store.spec.parts):
        if part.directions in TRAINING:
            if (
                depth(part) == 0
                and part.directions != "probed"
                and KINDS[part.distribution.bottom].family.bare
            ):
                continue
            by_depth.setdefault(depth(part), []).append(index)
            used = trained_pairs(part)
            if (used.stop - used.start) % pairs:
                raise ParameterError(
                    f"part '{part.name}' has {used.stop - used.start} pairs to train on for each "
                    f"stack; that must be a multiple of the {pairs} that a step uses"
                )
            if part.distribution.widths != arch.widths:
                raise ParameterError(
                    f"part '{part.name}' has stacks of {part.distribution.widths} GGX widths per "
                    f"surface, but the architecture's networks are for {arch.widths}"
                )
            if part.directions == "probed" and arch.probes != PROBES:
                raise ParameterError(
                    f"part '{part.name}' holds {PROBES} probes, "
                    f"but the architecture's encoder needs {arch.probes}"
                )
        elif part.directions not in METRICS:
            raise ParameterError(
                f"part '{part.name}' has directions '{part.directions}', which training does not "
                f"support; choose one of {', '.join((*TRAINING, *METRICS))}"
            )
    if sorted(by_depth) != list(range(len(by_depth))):
        raise ParameterError(
            "the training data must hold stacks of 0, 1, ... coats without a gap, not of "
            + ", ".join(map(str, sorted(by_depth)))
        )
    return [Depth(store, by_depth[coats], arch, pairs) for coats in range(len(by_depth))]


def batches(depths: list[Depth], stacks: tuple[int, ...], seed: int) -> Callable[[int, int], Batch]:
    """The function of `stage.Learner.batches`: every depth's items in shuffled epochs.

    Args:
        depths: the examples by number of coats.
        stacks: number of stacks of each depth in a step.
        seed: seed of the shuffling.
    """
    if len(stacks) != len(depths):
        raise ParameterError(
            f"the data holds stacks of up to {len(depths) - 1} coats, but the preset draws "
            f"stacks of up to {len(stacks) - 1}; give one number for each depth"
        )
    orders = [Order(depth.items, seed, coats) for coats, depth in enumerate(depths)]

    def rows(coats: int, items: np.ndarray) -> dict[str, np.ndarray]:
        held = depths[coats].examples()
        of_stacks = {name: getattr(held, name) for name in ("lobes", "probes", "coats")}
        of_items = {name: getattr(held, name)[items] for name in ("features", "top", "f")}
        return {name: x[held.stack[items]] for name, x in of_stacks.items()} | of_items

    return lambda step, steps: Batch(**taken(orders, rows, stacks, step, steps))


def taken(
    orders: Sequence[Order],
    rows: Callable[[int, np.ndarray], Mapping[str, np.ndarray]],
    counts: Sequence[int],
    step: int,
    steps: int,
) -> dict[str, Any]:
    """Columns of the batches of `steps` steps from `step` on, stacked along a first axis.

    rows: from the place of a depth and some of its items to columns by name; "coats" are
    (count, N, C), top to bottom, with one more coat at each depth. counts: items of each depth in a
    step. Columns are those of all depths, deepest first; "coats" become a tuple, see `Batch`.
    """
    parts = []
    for depth in reversed(range(len(orders))):
        count = counts[depth]
        columns = rows(depth, orders[depth].items(step * count, steps * count))
        parts.append({k: x.reshape(steps, count, *x.shape[1:]) for k, x in columns.items()})
    coats = [part.pop("coats") for part in parts]
    joined: dict[str, Any] = {
        name: np.concatenate([part[name] for part in parts], axis=1) for name in parts[0]
    }
    joined["coats"] = tuple(
        np.concatenate([x[:, :, -1 - k] for x in coats if x.shape[2] > k], axis=1)
        for k in range(coats[0].shape[2])
    )
    return joined


#: The direction sets of parts to train on.
TRAINING = ("training", "grazing", "probed", "anisotropic")

#: The direction sets of parts to validate on, and the metric that is computed there.
METRICS = {"cosine": "E mean", "half_angle": "P median", "slopes": "P median"}


def depth(part: Part) -> int:
    """Number of coats that are layered onto the encoded codes of a training part.

    It is 0 for stacks with stored values at the probe pairs, because these are encoded directly.
    """
    return 0 if part.directions == "probed" else part.distribution.coats


def trained_pairs(part: Part) -> slice:
    """The direction pairs of a training part that the loss uses."""
    return slice(PROBES if part.directions == "probed" else 0, part.pairs)


def mirror_images(part: Part, arrays: dict[str, np.ndarray]) -> dict[str, np.ndarray]:
    """The arrays of a part of two GGX widths with the x and y axes exchanged.

    This is the mirror image at the plane x = y. Values of f stay, so that simulated stacks give as
    many others at no cost.

    Raises:
        ParameterError: the stacks have one GGX width per surface.
    """
    if part.distribution.widths != 2:
        raise ParameterError(
            f"part '{part.name}' has stacks of one GGX width per surface, which are their own "
            "mirror images; use a Layering stage"
        )
    names = {"coats": COAT_COLUMNS[2], "bottom": KINDS[part.distribution.bottom].parameters}
    orders = {name: _exchanged_widths(columns) for name, columns in names.items()}
    orders |= {"wi": [1, 0, 2], "wo": [1, 0, 2]}
    return {name: x[..., orders[name]] if name in orders else x for name, x in arrays.items()}


def _exchanged_widths(columns: Sequence[str]) -> list[int]:
    """Places of the columns after widths along the tangent have been exchanged with those across.

    Their names end in "alpha_u" and "alpha_v".
    """
    other = {"alpha_u": "alpha_v", "alpha_v": "alpha_u"}
    return [columns.index(c[:-7] + other.get(c[-7:], c[-7:])) for c in columns]


def top_lobes(part: Part, arrays: dict[str, np.ndarray], arch: Architecture) -> np.ndarray:
    """The lobes (S, L) of a part's stacks: of their topmost coats, or of bare bottoms."""
    if part.distribution.coats:
        topmost = CoatParameters.of_columns(arrays["coats"][:, 0].T)
        return lobes.of_coat(topmost.alpha, topmost.eta)
    return bottom_lobes(part.distribution.bottom, arrays["bottom"], arch)


def encoder_inputs(
    part: Part, arrays: dict[str, np.ndarray], arch: Architecture
) -> tuple[np.ndarray, np.ndarray]:
    """The inputs of the encoder for a part's stacks: lobes (S, L) and other values (S, probes)
    [1/sr].

    These are the bottoms, or the whole stacks where their values at the probe pairs are stored.
    """
    if part.directions == "probed":
        own = top_lobes(part, arrays, arch)
        top = lobes.f(own[:, None], *probe_pairs(arch.probes, arch.widths))
        return own, np.maximum(arrays["f"][:, :PROBES] - top, 0.0)
    kind = part.distribution.bottom
    own = bottom_lobes(kind, arrays["bottom"], arch)
    return own, bottom_rest(kind, arrays["bottom"], own, arch)


def coats_to_layer(part: Part, arrays: dict[str, np.ndarray]) -> np.ndarray:
    """The coats (S, N, C) of a part's stacks that are layered, top to bottom; see `depth`."""
    if depth(part) == 0:
        columns = len(COAT_COLUMNS[part.distribution.widths])
        return np.zeros((len(arrays["bottom"]), 0, columns), np.float32)
    return arrays["coats"]
