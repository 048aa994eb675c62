"""Parameters that follow from one texture, along one axis."""

from collections.abc import Sequence

import mitsuba as mi
import numpy as np

from urushi.core.namespace import NUMPY
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import Leader, Varying
from urushi.mitsuba.reading.axes import texel_centres
from urushi.mitsuba.reading.grid import ELSEWHERE, varying_textures
from urushi.textures.axes import Axis

#: Parts of an axis, and points at which parameters are compared.
PARTS, POINTS = 512, 1 << 14

#: Within a part, the mean and the largest change of the coordinate of what follows from it.
MEAN, MOST = 0.01, 0.1


def joined(parameters: Sequence[Varying]) -> list[Varying]:
    """The parameters; of those that vary by the same texture, the later ones follow the first.

    A coat's index and the index of the base below it are an example, or the albedo and the depth of
    a pigment of textured colour. Along axes of their own, most combinations would not occur.
    """
    result: list[Varying] = []
    leaves = [_only_source(own) for own in parameters]
    for own, leaf in zip(parameters, leaves, strict=True):
        before = zip(result, leaves, strict=False)
        same = [x for x, other in before if leaf and other is leaf and x.leader is None]
        relations = ((x.axis.name, _relation(x, own, leaf)) for x in same)
        found = (Leader(name, *relation) for name, relation in relations if relation is not None)
        result.append(own._replace(leader=next(found, None)))
    return result


def agree(former: Varying, now: Varying) -> bool:
    """Whether a parameter follows its leader as it did before, at the values that it has now."""
    old, new, axis = former.leader, now.leader, former.axis
    if old is None or new is None or old.name != new.name or not axis.contains(now.axis):
        return False
    away = np.abs(_coordinates(axis, old.at(new.values)) - _coordinates(axis, new.own))
    return bool(away.mean() < MEAN and away.max() < MOST)


def _only_source(parameter: Varying) -> "mi.Texture | None":
    """The only texture by which a parameter varies, if its values are known at points of uv."""
    if parameter.differentiable or parameter.places is not None:
        return None
    found = {id(x): x for source in parameter.sources for x in varying_textures(source)}
    alone = next(iter(found.values())) if len(found) == 1 else None
    return None if alone is None or alone.class_name() in ELSEWHERE else alone


def _relation(
    first: Varying, own: Varying, leaf: "mi.Texture"
) -> tuple[np.ndarray, np.ndarray] | None:
    """Ascending values (N,) of the first parameter, and those of the other one beside them.

    None: the other one is not a function of it.
    """
    if first.axis.own != own.axis.own:
        return None
    centres = texel_centres(leaf)
    uv = [centres[:: -(-len(centres) // POINTS)], np.random.default_rng(0).random((POINTS, 2))]
    si = spectrum.points(np.concatenate(uv))
    with spectrum.reading_at(spectrum.FINE):
        x, y = (_values(parameter, si) for parameter in (first, own))
    part = np.minimum(_coordinates(first.axis, x) * PARTS, PARTS - 1).astype(int)
    order = np.argsort(part, kind="stable")
    starts = np.flatnonzero(np.diff(part[order], prepend=-1))
    counts, along = np.diff(starts, append=len(part)), _coordinates(own.axis, y)[order]
    spread = np.maximum.reduceat(along, starts) - np.minimum.reduceat(along, starts)
    if np.average(spread, weights=counts) > MEAN or spread.max() > MOST:
        return None
    means = (np.add.reduceat(values[order], starts) / counts for values in (x, y))
    return next(means), next(means)


def _values(parameter: Varying, si: "mi.SurfaceInteraction3f") -> np.ndarray:
    """The values (N,) of all channels at interactions."""
    found = spectrum.at_bands(si, lambda: parameter.read(si, True))
    return np.concatenate([x.numpy() for x in found]).astype(np.float64)


def _coordinates(axis: Axis, values: np.ndarray) -> np.ndarray:
    return np.asarray(axis.coordinate(values, NUMPY))
