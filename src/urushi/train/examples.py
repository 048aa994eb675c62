"""Training examples from a data store: pairs with their features, and the encoder's inputs."""

from dataclasses import dataclass

import numpy as np

from urushi.checks import COAT_COLUMNS, CoatParameters
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.errors import ParameterError
from urushi.nets import lobe as lobes
from urushi.nets.architecture import Architecture
from urushi.nets.features import DIRECTION_FEATURES, direction_features
from urushi.nets.lobe_fit import fit_lobes
from urushi.train.store import Part, Store
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS

#: The arrays that are read from a store.
ARRAYS = ("coats", "bottom", "wi", "wo", "f")


@dataclass(frozen=True)
class Examples:
    """Examples in memory, all with the same number of coats; an item is one run of pairs.

    Arrays of the names of `batches.Batch` have its meaning.
    """

    lobes: np.ndarray  # (S, L)
    probes: np.ndarray  # (S, probes)
    coats: np.ndarray  # (S, N, C) columns `checks.COAT_COLUMNS`, top to bottom
    stack: np.ndarray  # (I,) the stack of each item; the items of a stack lie side by side
    features: np.ndarray  # (I, P, D)
    top: np.ndarray  # (I, P)
    f: np.ndarray  # (I, P)


class Depth:
    """The examples of one depth, read from the store when they are first needed."""

    def __init__(self, store: Store, parts: list[int], arch: Architecture, pairs: int) -> None:
        """parts: indices of this depth's parts. pairs: number of direction pairs of an item."""
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
            if depth(part):
                coats.append(arrays["coats"])
            else:
                no_coats = 0, len(COAT_COLUMNS[part.distribution.widths])
                coats.append(np.zeros((len(values), *no_coats), np.float32))
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
    """The training parts of a complete store, by number of coats, from 0 up.

    They take 36 bytes of memory for each direction pair.

    pairs: direction pairs of one stack in a step; the number of pairs of every part must be a
        multiple of it.
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
    """
    if part.distribution.widths != 2:
        raise ParameterError(
            f"part '{part.name}' has stacks of one GGX width per surface, which are their own "
            "mirror images; use a Layering stage"
        )
    names = {"coats": COAT_COLUMNS[2], "bottom": KINDS[part.distribution.bottom].parameters}
    # Names of widths along the tangent end in "alpha_u", across it in "alpha_v".
    other = {"alpha_u": "alpha_v", "alpha_v": "alpha_u"}
    orders = {"wi": [1, 0, 2], "wo": [1, 0, 2]}
    for name, columns in names.items():
        orders[name] = [columns.index(c[:-7] + other.get(c[-7:], c[-7:])) for c in columns]
    return {name: x[..., orders[name]] if name in orders else x for name, x in arrays.items()}


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


def bottom_lobes(kind: str, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Lobes (S, L) of bottoms with the parameters (S, K), in the order of their kind.

    Lobes that the family does not know are fitted to its values, as `encode` does.
    """
    columns = dict(zip(KINDS[kind].parameters, bottom.T, strict=True))
    fresnel = KINDS[kind].family.fresnel_numbers(columns)
    if fresnel is None:
        return fit_lobes(_values(kind, bottom, arch), arch.widths)
    result = np.tile(np.array(lobes.no_lobe(arch.widths), np.float32), (len(bottom), 1))
    if widths := [column for name, column in columns.items() if name.startswith("alpha")]:
        result[:, lobes.WIDTH_PLACES[arch.widths]] = np.stack(widths, axis=-1)
    for place, numbers in enumerate(fresnel, start=1):
        result[:, place] = numbers
    return result


def bottom_rest(kind: str, bottom: np.ndarray, own: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs, minus their lobes."""
    if KINDS[kind].family.bare:
        return np.zeros((len(bottom), arch.probes), np.float32)
    top = lobes.f(own[:, None], *probe_pairs(arch.probes, arch.widths))
    return np.maximum(_values(kind, bottom, arch) - top, 0.0)


def _values(kind: str, bottom: np.ndarray, arch: Architecture) -> np.ndarray:
    """Values (S, probes) [1/sr] of bottoms in air at the probe pairs."""
    columns = dict(zip(KINDS[kind].parameters, bottom.T, strict=True))
    return analytic.at_all(kind, columns, *probe_pairs(arch.probes, arch.widths))
