"""Codes of materials over axes, at nodes between which renderers interpolate.

Light transport is computed at some hundred points, and interpolated to the nodes (`interpolant`).
The lobe of the coat is known at every point.

A material whose parameters are not known has the axes v and u, and its nodes are texels.
"""

from collections.abc import Callable, Mapping, Sequence
from functools import partial
from typing import Any, NamedTuple

import numpy as np

from urushi.core.namespace import Namespace
from urushi.core.stretched import rounded
from urushi.material.albedo_rule import albedo_rule
from urushi.material.energy import MARGIN, limit_albedo, nearest_within
from urushi.nets import transmittance
from urushi.nets.weights import Model
from urushi.textures.axes import LINEAR, Axis, Changes, nearest, simplex
from urushi.textures.interpolation import interpolant
from urushi.textures.own_functions import extended
from urushi.textures.point_codes import FAINT, SPARSE, PointCodes, Rows, slope_weights
from urushi.textures.store import TexelGrid

#: Numbers of nodes of an axis, and the most nodes of all channels together: their codes take three
#: megabytes.
COUNTS, NODES = (2, 3, 5, 9, 17, 33, 65), 1 << 16

#: Root mean square error of ln f between nodes from which an axis has enough of them.
SMOOTH = 1e-3

#: Lines along one of several axes, and steps of each, by which its nodes are chosen.
LINES, STEPS = 32, 32

#: Step of the differences by which slopes are found, in coordinates.
DIFFERENCE = 0.04


class Baked(NamedTuple):
    """Codes of a material at the nodes of its axes; C is one if all channels are alike.

    `rests` and `slopes` are computed when they are called: at all nodes, they take megabytes.
    """

    model: Model
    functions: np.ndarray  # of the material, see `own_functions`
    axes: tuple[Axis, ...]
    shape: tuple[int, ...]  # number of nodes along each axis
    channels: int  # C, number of different channels at the same place on the axes
    lobes: np.ndarray  # float32 (C, N, M) of the codes, the last axis the fastest; C maybe one
    rests: Callable[[], np.ndarray]  # float32 (C, N, K) the other numbers
    #: From numbers (k,) of axes and then constants to the slopes of the rests by their values,
    #: float32 (C, N, k, K). Texels have none.
    slopes: Callable[[Sequence[int]], np.ndarray]
    faint: float = 0.0  # [1/sr] by which g of the rests is too large
    grid: TexelGrid | None = None  # of texels, if these are the nodes
    constants: tuple[str, ...] = ()  # names of the constants of which `slopes` are known, too

    @classmethod
    def of_texels(cls, model: Model, codes: np.ndarray, grid: TexelGrid) -> "Baked":
        """Codes (T, C, L) of the texels of a grid."""
        codes = np.moveaxis(codes[:, :1] if (codes == codes[:, :1]).all() else codes, 1, 0)
        lobes, rests = np.split(codes, [model.arch.lobe], axis=-1)
        axes = tuple(Axis(name, LINEAR, 0.0, 1.0) for name in ("v", "u"))
        return cls(
            model=model,
            functions=np.empty((0, 0), np.float32),
            axes=axes,
            shape=(grid.height, grid.width),
            channels=len(rests),
            lobes=lobes,
            rests=lambda: rests,
            slopes=lambda _: rests[:, :, None][:, :, :0],
            grid=grid,
        )

    @property
    def extended(self) -> Model:
        """The model with the functions of the material, in which the codes are."""
        return extended(self.model, self.functions)

    def corners(
        self, coordinates: Sequence, index: Callable[[Any], Any], xp: Namespace
    ) -> list[tuple[Any, Any]]:
        """Nodes and weights by which codes are interpolated at coordinates, one on each axis.

        index: makes whole numbers.
        """
        if self.grid is not None:
            return [(nearest(self.shape, coordinates, index), 1.0)]
        return simplex(self.shape, coordinates, index, xp)


def bake(model: Model, axes: Sequence[Axis], rows: Rows, constants: Mapping[str, Changes]) -> Baked:
    """The codes at nodes of the axes, at most `AXES` of them.

    Args:
        model: of the codes.
        axes: along which the material varies.
        rows: the coated material.
        constants: changes of each constant whose slopes are wanted, too.
    """
    own, found = tuple(axes), PointCodes(model, axes, rows, constants)
    norm = extended(model, found.functions).networks.basis.norm

    def limited(
        x: np.ndarray,
        rests: np.ndarray,
        limit: Callable[[Model, np.ndarray, np.ndarray], np.ndarray],
    ) -> np.ndarray:
        """The rests (C, k, K) of codes that `limit` makes of those of rests at coordinates (k, d).

        Albedos are those of rounded stretches: each stretch has functions of its own.
        """
        tops = found.lobes(x)
        whole = np.broadcast_to(tops, (*rests.shape[:2], tops.shape[-1]))
        codes = np.concatenate([whole, rests], axis=-1, dtype=np.float32)
        if model.widths == 2:
            codes[..., -1] = rounded(codes[..., -1])
        directions = albedo_rule(model.widths).directions
        # No light is added by what `FAINT` adds, of at most this albedo.
        faint = np.pi * FAINT * transmittance.of_lobe(tops[:, None], directions)
        own_model = extended(model, found.functions)
        changes = limit(own_model, codes, found.ceiling - MARGIN + faint) - codes
        return rests + changes[..., tops.shape[-1] :]

    # A fit that is too bright at grazing angles would be scaled down at all others as well.
    fitted = limited(found.x, found.rests, nearest_within)
    smooth = interpolant(found.x, np.moveaxis(fitted, 1, 0), norm)

    def rests_at(x: np.ndarray) -> np.ndarray:
        """Rests (C, k, K) at coordinates (k, d)."""
        return limited(x, np.moveaxis(smooth(x), 1, 0), limit_albedo)

    shape = node_counts(norm, rests_at, len(own), NODES // len(fitted))
    nodes = np.array([*np.ndindex(*shape)], float) / (np.array(shape) - 1.0)

    def slope(k: int) -> np.ndarray:
        """Slopes (C, N, K) by an axis or a constant."""
        if k >= len(own):
            values = np.moveaxis(found.slopes[k - len(own)], 1, 0)
            return np.moveaxis(interpolant(found.x[::SPARSE], values, norm)(nodes), 1, 0)
        beside = np.repeat(nodes[:, None], 3, axis=1)
        middle = np.clip(nodes[:, k], DIFFERENCE, 1 - DIFFERENCE)
        beside[..., k] = middle[:, None] + np.array([-1, 0, 1]) * DIFFERENCE
        weights = slope_weights(own[k].values(beside[..., k]), own[k].values(nodes[:, k]))
        rests = rests_at(beside.reshape(-1, len(own)))
        return np.einsum("kn,cknj->ckj", weights, rests.reshape(len(rests), *weights.shape, -1))

    def slopes(chosen: Sequence[int]) -> np.ndarray:
        channels, _, size = found.rests.shape
        result = np.empty((channels, len(nodes), len(chosen), size), np.float32)
        for place, k in enumerate(chosen):
            result[:, :, place] = slope(k)
        return result

    return Baked(
        model=model,
        functions=found.functions,
        axes=own,
        shape=shape,
        channels=len(found.rests),
        lobes=found.lobes(nodes)[None],
        rests=partial(rests_at, nodes),
        slopes=slopes,
        faint=FAINT,
        constants=tuple(constants),
    )


def node_counts(
    norm: np.ndarray, rests_at: Callable[[np.ndarray], np.ndarray], dimensions: int, most: int
) -> tuple[int, ...]:
    """Numbers of nodes, one of `COUNTS` for each axis, by the curvature of rests along it.

    norm: (K, K) of the basis. rests_at: (C, k, K) at coordinates (k, d). most: nodes of all axes.
    """
    rng, curvatures = np.random.default_rng(0), []
    lines = LINES if dimensions > 1 else 1  # a sole axis is one line
    for axis in range(dimensions):
        x = np.repeat(rng.random((lines, 1, dimensions)), STEPS + 1, axis=1)
        x[..., axis] = np.linspace(0, 1, STEPS + 1)
        found = rests_at(x.reshape(-1, dimensions)).reshape(-1, lines, STEPS + 1, len(norm))
        bent = np.diff(found, n=2, axis=2) @ norm
        curvatures.append(np.sqrt(np.quantile(np.square(bent).sum(axis=-1), 0.9)))
    steps, counts = np.array(curvatures) / 8 * STEPS**2, np.zeros(dimensions, int)
    growing = np.ones(dimensions, bool)
    while growing.any():
        errors = np.where(growing, steps / (np.take(COUNTS, counts) - 1) ** 2, 0)
        axis = int(errors.argmax())
        more = counts + (np.arange(dimensions) == axis)
        enough = errors[axis] < SMOOTH or more[axis] == len(COUNTS)
        if enough or np.prod(np.take(COUNTS, more)) > most:
            growing[axis] = False
        else:
            counts = more
    return tuple(np.take(COUNTS, counts).tolist())
