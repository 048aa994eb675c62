"""Principal numbers: the codes of one texture by fewer numbers, for rendering.

The codes of a texture vary less than those of all materials. With c the numbers of a code after its
gain, c = mean + d A, where d are the principal components of the texture's codes in the metric of
the error of ln f. The gain is kept apart and is exact. A renderer then looks up the few functions
U A of the texture in place of all functions U, and reads fewer bytes. The proposal's terms are
linear in the code, and are stored too.
"""

from collections.abc import Iterable, Iterator
from dataclasses import dataclass, replace

import numpy as np

from urushi.nets import basis, proposal
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.weights import Model
from urushi.textures import packing
from urushi.textures.packing import PackedTexels, TexelLayout
from urushi.textures.store import PACKED_BLOCK, TextureStore

#: Numbers of functions that are tried. With the mean they fill packets.
COUNTS = 3, 7, 11, 15

#: Errors of f at the probe pairs: their mean over a texture, and the largest one.
MEAN_ERROR, LARGEST_ERROR = 7e-4, 1e-2

#: Texels by which the errors are measured, evenly spaced, and those that are represented worst.
SAMPLE, WORST = 256, 64

#: Share of the measure beside the light in the metric.
FLOOR = 0.02


@dataclass
class PrincipalTexture:
    """A packed texture of principal numbers, which a renderer reads as a `TextureStore`.

    The numbers of a channel are those of its lobe, the proposal's terms of the mean code, the gain
    relative to the texture's mean, and the principal components d.
    """

    layout: TexelLayout
    packed: PackedTexels
    projection: "Projection"
    functions: np.ndarray  # float32 (P, 1 + N), mean and functions, at the nodes of `core.table`
    lobe: int  # numbers of a lobe

    @property
    def first(self) -> int:
        """Place of the gain among the numbers; the components follow."""
        return self.lobe + proposal.TERMS

    def scaled(self, factor: float) -> "PrincipalTexture":
        """The texture whose components are multiplied by a factor."""
        factors = np.ones(self.layout.size, np.float32)
        factors[self.first + 1 :] = factor
        lowest, step = self.packed.lowest * factors, self.packed.step * factors
        return replace(self, packed=self.packed._replace(lowest=lowest, step=step))

    def codes(self, numbers: np.ndarray) -> np.ndarray:
        """Codes (..., size) of numbers (...)."""
        rest = self.projection.rests(numbers[..., self.first :])
        return np.concatenate([numbers[..., : self.lobe], rest], axis=-1)


@dataclass
class Projection:
    """Rests c of codes as principal numbers (..., 1 + N): a gain, and components d."""

    mean: np.ndarray  # (K - 1,) of the numbers after the gain
    into: np.ndarray  # (K - 1, N)
    back: np.ndarray  # (N, K - 1)
    levels: np.ndarray  # (K - 1,) mean of each function over the light

    def numbers(self, rests: np.ndarray) -> np.ndarray:
        """Principal numbers (..., 1 + N) of rests (..., K)."""
        off = rests[..., 1:] - self.mean
        gain = rests[..., :1] + (off @ self.levels)[..., None]
        return np.concatenate([gain, off @ self.into], axis=-1)

    def rests(self, numbers: np.ndarray) -> np.ndarray:
        """Rests (..., K) of principal numbers (..., 1 + N)."""
        off = numbers[..., 1:] @ self.back
        gain = numbers[..., :1] - (off @ self.levels)[..., None]
        return np.concatenate([gain, off + self.mean], axis=-1)

    def changes(self, slopes: np.ndarray) -> np.ndarray:
        """Slopes (..., 1 + N) of `numbers` for slopes (..., K) of rests."""
        gain = slopes[..., :1] + (slopes[..., 1:] @ self.levels)[..., None]
        return np.concatenate([gain, slopes[..., 1:] @ self.into], axis=-1)

    def functions(self, rows: np.ndarray) -> np.ndarray:
        """Mean and functions (P, 1 + N) of principal numbers, from rows (P, 1 + K) of a basis."""
        others = rows[:, 2:]
        mean = rows[:, :1] + (others @ self.mean)[:, None]
        return np.concatenate([mean, (others - self.levels) @ self.back.T], axis=1)

    def first(self, count: int) -> "Projection":
        """The projection to the first components."""
        return Projection(self.mean, self.into[:, :count], self.back[:count], self.levels)

    def scaled(self, factors: np.ndarray) -> "Projection":
        """The projection to components times factors (N,)."""
        return Projection(self.mean, self.into * factors, self.back / factors[:, None], self.levels)


def principal_texture(model: Model, store: TextureStore) -> PrincipalTexture | None:
    """The principal numbers of a texture; None: it needs about as many numbers as its codes have.

    The components are scaled to functions of which the largest value is one.
    """
    own, lobe, texels = model.networks.basis, model.arch.lobe, len(store.packed.bytes)
    if own.widths == 2 or not texels:
        return None  # codes of two widths stretch the directions
    some = store.read(slice(None, None, -(-texels // SAMPLE))).reshape(-1, store.layout.size)
    whole = _projection(own, _blocks(store), some, lobe)
    off = np.concatenate([_left(part[..., lobe:], whole) for part in _blocks(store)])
    worst = np.sort(np.argpartition(off, -min(WORST, texels))[-WORST:])
    tried = np.concatenate([some, store.read(worst).reshape(-1, store.layout.size)])
    projection = _sufficient(own, whole, tried, len(some), lobe)
    if len(projection.back) + 1 >= model.arch.functions:
        return None
    functions, projection = _functions(own, projection)
    return _packed(model, store, projection, functions, some)


def projection_of(
    model: Model, tops: np.ndarray, rests: np.ndarray
) -> tuple[np.ndarray, Projection]:
    """The functions and the projection, as of `PrincipalTexture`, of codes.

    tops: lobes (N, M). rests: (C, N, K).
    """
    own, lobe = model.networks.basis, model.arch.lobe
    codes = np.concatenate([np.broadcast_to(tops, (*rests.shape[:2], lobe)), rests], axis=-1)
    codes = codes.reshape(-1, 1, codes.shape[-1])
    some = codes[:: -(-len(codes) // SAMPLE), 0]
    whole = _projection(own, [codes], some, lobe)
    off = _left(codes[..., lobe:], whole)
    worst = np.argpartition(off, -min(WORST, len(codes)))[-WORST:]
    tried = np.concatenate([some, codes[worst, 0]])
    return _functions(own, _sufficient(own, whole, tried, len(some), lobe))


def _sufficient(
    own: Basis, whole: Projection, tried: np.ndarray, count: int, lobe: int
) -> Projection:
    """The projection to so few components that codes `tried`, `count` typical ones first, stay."""
    for projection in map(whole.first, COUNTS):
        errors = _errors(own, tried[:, :lobe], tried[:, lobe:], projection)
        if errors[:count].mean() < MEAN_ERROR and errors.max() < LARGEST_ERROR:
            return projection
    return whole


def _functions(own: Basis, projection: Projection) -> tuple[np.ndarray, Projection]:
    """Mean and functions of a projection, scaled to largest values of one, and the projection."""
    functions = projection.functions(own.rows)
    size = np.maximum(np.abs(functions[:, 1:]).max(axis=0), 1e-9)
    functions[:, 1:] /= size
    return functions.astype(np.float32), projection.scaled(size)


def _blocks(store: TextureStore) -> Iterator[np.ndarray]:
    """Codes (n, channels, size) of all texels in turn."""
    for start in range(0, len(store.packed.bytes), PACKED_BLOCK):
        yield store.read(slice(start, start + PACKED_BLOCK))


def _projection(
    own: Basis, blocks: Iterable[np.ndarray], some: np.ndarray, lobe: int
) -> Projection:
    """The projection to all components, the most important first, of codes in blocks.

    some: codes (S, size).
    """
    rows = own.probe_rows(0.0).astype(np.float64)
    rest = basis.decode(some[:, None, lobe:], own.probe_rows(0.0)).astype(np.float64)
    light = (rest + lobes.f(some[:, None, :lobe], *own.pairs())) @ own.measure
    share = (rest / np.maximum(light, 1e-12)[:, None]).mean(axis=0)
    weights = own.measure * (share + FLOOR)
    weights /= weights.sum()
    levels = weights @ rows[:, 2:]
    others = rows[:, 2:] - levels
    metric = (others * weights[:, None]).T @ others
    metric += 1e-9 * np.trace(metric) * np.eye(len(metric))
    count, total, squares = 0, np.zeros(len(metric)), np.zeros_like(metric)
    for part in blocks:
        c = part[..., lobe + 1 :].reshape(-1, len(metric)).astype(np.float64)
        count, total, squares = count + len(c), total + c.sum(axis=0), squares + c.T @ c
    mean = total / count
    root = np.linalg.cholesky(metric)
    spread = root.T @ (squares / count - np.outer(mean, mean)) @ root
    turned = root @ np.linalg.eigh(spread)[1][:, ::-1]
    return Projection(mean, turned, np.linalg.inv(turned), levels)


def _left(rests: np.ndarray, whole: Projection) -> np.ndarray:
    """Largest squared distance (n,) of rests (n, channels, K) from the most components."""
    left = whole.numbers(rests)[..., 1 + COUNTS[-1] :]
    return np.square(left).sum(axis=-1).max(axis=-1)


def _errors(own: Basis, lobe: np.ndarray, rests: np.ndarray, projection: Projection) -> np.ndarray:
    """Errors E (n,) of f at the probe pairs by a projection; codes: lobes (n, N), rests (n, K)."""
    f = basis.decode(rests[:, None], own.probe_rows(0.0))
    projected = projection.rests(projection.numbers(rests))
    found = basis.decode(projected[:, None], own.probe_rows(0.0))
    light = f + lobes.f(lobe[:, None], *own.pairs())
    return (np.abs(found - f) @ own.measure) / np.maximum(light @ own.measure, 1e-12)


def _packed(
    model: Model,
    store: TextureStore,
    projection: Projection,
    functions: np.ndarray,
    some: np.ndarray,
) -> PrincipalTexture:
    """The texture of a projection; some: codes (S, size) by which bits are chosen."""
    lobe, channels = model.arch.lobe, store.layout.channels

    def numbers(codes: np.ndarray) -> np.ndarray:
        """Numbers (n, channels, size) of codes (n, channels, size)."""
        terms = proposal.code_terms(model.params, codes[..., lobe:].mean(axis=1, keepdims=True))
        terms = np.broadcast_to(terms, (*codes.shape[:2], proposal.TERMS))
        parts = codes[..., :lobe], terms, projection.numbers(codes[..., lobe:])
        return np.concatenate(parts, axis=-1, dtype=np.float32)

    ends = [(x.min(axis=(0, 1)), x.max(axis=(0, 1))) for x in map(numbers, _blocks(store))]
    lowest = np.min([low for low, _ in ends], axis=0)
    highest = np.max([high for _, high in ends], axis=0)
    result = PrincipalTexture(store.layout, store.packed, projection, functions, lobe)

    tried = numbers(some.reshape(-1, channels, some.shape[-1])).reshape(-1, len(lowest))
    errors = packing.rounding_errors(
        lambda z: packing.log_values(model, result.codes(z)), tried, lowest, highest
    )
    own = np.array(store.layout.same)
    same = np.concatenate(
        [own[:lobe], np.ones(proposal.TERMS, bool), np.full(len(functions[0]), own[lobe:].all())]
    )
    # An order that does not depend on the texture, so that textures share compiled code
    first = [*WIDTH_PLACES[model.widths], *range(result.first, len(same))]
    order = [*first, *(i for i in range(len(same)) if i not in first)]
    result.layout = packing.texel_layout(channels, errors, lowest == highest, same, order=order)
    parts = [
        packing.pack_texels(result.layout, numbers(x), lowest, highest) for x in _blocks(store)
    ]
    result.packed = parts[0]._replace(bytes=np.concatenate([part.bytes for part in parts]))
    return result
