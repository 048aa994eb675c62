"""The parameters of a coat and its bottom that vary over a surface, as axes.

Their values come from Mitsuba's own textures at the shading point, and so does every filter, wrap,
transform, mesh attribute and volume. A parameter that carries a gradient is an axis too, over all
the values that it may take. Parameters that follow from one texture share an axis.
"""

from collections.abc import Callable, Mapping, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA, MIN_INDEX_STEP, finite_number, nonnegative
from urushi.core.appearance import LOOK, PHYSICAL
from urushi.core.namespace import NUMPY
from urushi.material.layer import DEEPEST, WIDEST
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.changed import numbers_of
from urushi.mitsuba.reading.grid import not_over_uv, parts, varying_textures
from urushi.mitsuba.reading.parameters import TWO_WIDTHS, CoatTextures
from urushi.mitsuba.reading.ranges import INDICES, range_of, texel_centres
from urushi.mitsuba.reading.wavelengths import WAVELENGTH
from urushi.mitsuba.snapshot import has_gradients, is_attached, writable
from urushi.textures import axes
from urushi.textures.axes import Axis, Changes, Leader, Varying

#: All values of a parameter, by its scale.
RANGES = {
    axes.WIDTH: (MIN_ALPHA, 1.0),
    axes.DEPTH: (0.0, DEEPEST),
    axes.REFLECTANCE: (0.0, 1.0),
    axes.ALBEDO: (0.0, 1.0),
    axes.LINEAR: (0.0, 1.0),
}

#: Name of the axis of the index inside a coat relative to air.
INSIDE = "inside"

#: Scales of a coat's parameters, and the textures on which each depends; those of an appearance
#: depend on g, too.
COAT: dict[str, tuple[str, tuple[str, ...]]] = {
    "alpha": (axes.WIDTH, ("alpha",)),
    "alpha_u": (axes.WIDTH, ("alpha_u",)),
    "alpha_v": (axes.WIDTH, ("alpha_v",)),
    "eta": (axes.INDEX, INDICES),
    "albedo": (axes.ALBEDO, ("albedo", *LOOK)),
    "sigma_t": (axes.DEPTH, ("sigma_t", *LOOK, "thickness")),
    "g": (axes.LINEAR, ("g",)),
    INSIDE: (axes.LINEAR, ("int_ior",)),
}

#: Range of g in which light transport is accurate, and relative indices on both sides of one.
ASYMMETRIES, ABOVE, BELOW = (-0.95, 0.95), (1 + 2 * MIN_INDEX_STEP, 3.0), (0.4, 0.995)

#: Changes of constants by which slopes are found: a share of the value, and a number.
CHANGES = {
    axes.WIDTH: (0.05, 0.0),
    axes.DEPTH: (0.05, 0.02),
    axes.REFLECTANCE: (0.04, 0.0005),
    axes.ALBEDO: (0.0, 0.01),
    axes.LINEAR: (0.0, 0.02),
    axes.INDEX: (0.0, 0.005),
}

#: Largest change of one of two widths that carries a gradient, until codes are baked again.
NEAR = 1.3

#: Parts of an axis, and points at which parameters of the same texture are compared.
PARTS, POINTS = 512, 1 << 14

#: Within a part, the mean and the largest change of the coordinate of what follows from it.
MEAN, MOST = 0.01, 0.1

#: Start of the names of a bottom's parameters.
BOTTOM = "bottom."

#: Parameters of `principled` that depend on the base colour over its luminance, which is a
#: parameter of its own: end of its name, and largest value.
TINTS, TINT, MOST_TINT = ("spec_tint", "sheen_tint"), "/luminance", 14.0

#: Range of tints below which a texture is grey.
GREY = 1e-3

#: Luminance below which a colour is black and has no tint.
LEAST_LUMINANCE = 1e-6


def varying_parameters(
    coat: CoatTextures,
    bottom: "mi.BSDF",
    known: Sequence[Varying] | None = None,
    relative: bool = False,
) -> list[Varying]:
    """The parameters of a coat and a bottom that vary or carry gradients.

    known: those of a bottom that has codes over axes; None: they are read. relative: whether the
    bottom depends on the index inside the coat, which is a parameter where `eta` does not tell it.
    """
    if known is None:
        below = _of_bottom(bottom, coat.where) + _numbers_of_bottom(bottom)
    else:
        below = [x._replace(axis=x.axis._replace(name=_below(x.axis.name))) for x in known]
    inside = [INSIDE] if relative and all(coat.changing_indices) else []
    found = *of_coat(coat, [*coat.names, *inside]), *below
    return list({x.axis.name: x for x in found}.values())


def _below(name: str) -> str:
    """The name of a parameter of a nested coat."""
    return name if name == WAVELENGTH else BOTTOM + name


def of_coat(coat: CoatTextures, names: Sequence[str]) -> list[Varying]:
    """The parameters of a coat that vary or carry gradients, among some."""
    found = []
    for name in names:
        scale, sources = COAT[name]
        if name in PHYSICAL and "color" in coat.textures:
            sources = *sources, "g"
            if name == "albedo" and _is_dye(coat.textures["body"]):
                continue
        own = [coat.textures[x] for x in sources if x in coat.textures]
        indices = {"eta": coat.indices, INSIDE: [coat.opaque_eta]}.get(name, [])
        gradient = any(map(has_gradients, own)) or any(map(is_attached, indices))
        if not (gradient or varying_textures(*own)):
            continue

        def read(si, active, name=name) -> list:
            return [coat.inside(si, active)] if name == INSIDE else coat.at(si, active)[name]

        whole = _whole(coat, name, scale, read, own)
        ends = range_of(read, own, whole, own == [coat.textures.get(name)])
        coloured = name in ("albedo", "sigma_t", "g", *coat.coloured) and any(map(_coloured, own))
        axis = Axis(name, scale, *ends, coloured)
        found += parameter_along(axis, whole if gradient else None, read, own)
    return found


def _is_dye(body: "mi.Texture") -> bool:
    """Whether a medium of this body only absorbs, whatever its colour is."""
    if varying_textures(body) or has_gradients(body):
        return False
    return not spectrum.channels_at(spectrum.MIDDLE, body.eval).any()


def _of_bottom(bottom: "mi.BSDF", where: str) -> list[Varying]:
    """The textures of a bottom that vary or carry gradients."""
    found, textures = list[Varying](), parts(bottom)
    for name, texture in textures.items():
        if not isinstance(texture, mi.Texture) or any(x.texture is texture for x in found):
            continue
        gradient = has_gradients(texture)
        if not (gradient or varying_textures(texture)):
            continue
        last = name.rpartition(".")[2]
        coloured = "reflectance" in last or "color" in last or last in ("eta", "k")
        scale = axes.WIDTH if last.startswith("alpha") else axes.LINEAR
        if coloured or last == "base_weight":
            scale = axes.REFLECTANCE
        whole = (0.0, np.inf) if last in ("eta", "k") else RANGES[scale]
        if last in TWO_WIDTHS:
            whole = _one_of_two(textures, name)

        def read(si, active, texture=texture, coloured=coloured) -> list:
            return [*texture.eval(si, active)] if coloured else [texture.eval_1(si, active)]

        ends = range_of(read, [texture], whole, True)
        check = finite_number if scale == axes.LINEAR else nonnegative
        check(ends, f"{where}: a texel of the nested BSDF's {name}", any_shape=True)
        axis = Axis(BOTTOM + name, scale, *ends, coloured and _coloured(texture))
        found += parameter_along(axis, whole if gradient else None, read, [texture], texture)
        if axis.own and varying_textures(texture) and _is_tinted(textures, name):
            found += _tint(found[-1], gradient)
    return found


def _is_tinted(textures: Mapping[str, Any], name: str) -> bool:
    """Whether a bottom depends on its colour of that name over the luminance, too."""
    beside = (textures.get(name.replace("base_color", tint)) for tint in TINTS)
    return any(
        varying_textures(x)
        or has_gradients(x)
        or spectrum.channels_at(spectrum.MIDDLE, x.eval).any()
        for x in beside
        if isinstance(x, mi.Texture) and x is not textures[name]
    )


def _tint(color: Varying, gradient: bool) -> list[Varying]:
    """The parameter that is a varying colour over its luminance; 1 where it is black."""
    axis, texture = color.axis, color.texture

    def read(si, active) -> list:
        channels = texture.eval(si, active)
        luminance = spectrum.luminance(channels, si.wavelengths)
        whole = dr.maximum(luminance, LEAST_LUMINANCE)
        return [dr.select(luminance > LEAST_LUMINANCE, x / whole, 1) for x in channels]

    whole = (0.0, MOST_TINT)
    ends = range_of(read, [texture], whole, False)
    own = axis._replace(name=axis.name + TINT, scale=axes.WIDTH, least=ends[0], most=ends[1])
    if not gradient and np.ptp(ends) < GREY:
        return []
    return parameter_along(own, whole if gradient else None, read, [texture], texture)


def _numbers_of_bottom(bottom: "mi.BSDF") -> list[Varying]:
    """The plain numbers of a bottom that carry gradients."""
    found, parameters = [], mi.traverse(bottom)
    for key, value in writable(bottom):
        last, owner = key.rpartition(".")[2], parameters.properties[key][2]
        if not is_attached(value) or last not in numbers_of(owner):
            continue

        def read(si, active, owner=owner, last=last) -> list:
            return [mi.Float(mi.traverse(owner)[last])]

        scale, now = axes.WIDTH if last == "alpha" else axes.LINEAR, float(np.ravel(value)[0])
        whole = RANGES[axes.WIDTH] if scale == axes.WIDTH else (0.0, np.inf)
        found += parameter_along(Axis(BOTTOM + key, scale, now, now), whole, read, [])
    return found


def parameter_along(
    axis: Axis,
    whole: tuple[float, float] | None,
    read: Callable,
    sources: Sequence[Any],
    texture: Any = None,
) -> list[Varying]:
    """A parameter if it varies or carries gradients.

    whole: all the values that it may take, if it carries gradients.
    """
    if axis.scale == axes.WIDTH:  # smaller widths than the least are that one
        least, most = max(axis.least, MIN_ALPHA), max(axis.most, MIN_ALPHA)
        axis = axis._replace(least=least, most=most)
    if whole is None:
        return [Varying(axis, read, sources, texture)] if axis.least < axis.most else []
    if not varying_textures(*sources):
        return [Varying(axis, read, sources, texture, True, changes=_changes(axis, whole))]
    axis = axis._replace(least=min(axis.least, whole[0]), most=max(axis.most, whole[1]))
    return [Varying(axis, read, sources, texture, True)]


def _changes(axis: Axis, whole: tuple[float, float]) -> Changes:
    """The changes of a constant by which its slopes are found: on both sides, if there are."""
    part, least = CHANGES[axis.scale]
    size = part * axis.most + least
    if axis.least - size < whole[0]:
        return 0.0, size, 2 * size
    if axis.most + size > whole[1]:
        return 0.0, -size, -2 * size
    return -size, 0.0, size


def _whole(
    coat: CoatTextures, name: str, scale: str, read: Callable, own: Sequence[Any]
) -> tuple[float, float]:
    """All values of a parameter of a coat, as far as its codes reach."""
    if name == "g":
        return ASYMMETRIES
    if name in TWO_WIDTHS:
        return _one_of_two(coat.textures, name)
    if name not in ("eta", INSIDE):
        return RANGES[scale]
    if not_over_uv(*own):
        in_air = coat.above is None and coat.outside == 1
        return (1.0 if in_air else BELOW[0]), ABOVE[1]
    return ABOVE if _in_the_middle(read) >= 1 else BELOW


def _one_of_two(textures: Mapping[str, Any], name: str) -> tuple[float, float]:
    """All values of one of two widths, whose ratio is bounded.

    textures: of both, by names that end with "u" and "v".
    """
    own, other = textures[name], textures[name[:-1] + ("v" if name[-1] == "u" else "u")]
    if not_over_uv(own) is None:
        width = _in_the_middle(lambda si, active: [own.eval_1(si, active)])
        return max(width / NEAR, MIN_ALPHA), min(width * NEAR, 1.0)
    if not_over_uv(other):
        return 1 / WIDEST, 1.0
    least, most = range_of(lambda si, active: [other.eval_1(si, active)], [other], (0.0, 1.0), True)
    return max(most / WIDEST, MIN_ALPHA), min(least * WIDEST, 1.0)


def _in_the_middle(read: Callable) -> float:
    """A number, which all channels share, in the middle of uv."""
    return float(spectrum.channels_at(spectrum.MIDDLE, read)[0, 0])


def _coloured(texture: "mi.Texture") -> bool:
    """Whether a texture may have another value in each channel."""
    if mi.is_monochromatic or texture.class_name() == "UniformSpectrum":
        return False
    if not texture.class_name().startswith("BitmapTexture"):
        return True
    return mi.traverse(texture)["data"].shape[-1] != 1


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
    away = np.abs(axis.coordinate(old.at(new.values), NUMPY) - axis.coordinate(new.own, NUMPY))
    return bool(away.mean() < MEAN and away.max() < MOST)


def _only_source(parameter: Varying) -> "mi.Texture | None":
    """The only texture by which a parameter varies, if its values are known at points of uv."""
    if parameter.differentiable or parameter.places is not None:
        return None
    found = {id(x): x for x in varying_textures(*parameter.sources)}
    return None if len(found) != 1 or not_over_uv(*found.values()) else next(iter(found.values()))


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
    with spectrum.reading_at(spectrum.FINE):
        x, y = (
            spectrum.channels_at(np.concatenate(uv), z.read).ravel().astype(np.float64)
            for z in (first, own)
        )
    part = np.minimum(first.axis.coordinate(x, NUMPY) * PARTS, PARTS - 1).astype(int)
    order = np.argsort(part, kind="stable")
    starts = np.flatnonzero(np.diff(part[order], prepend=-1))
    counts, along = np.diff(starts, append=len(part)), own.axis.coordinate(y, NUMPY)[order]
    spread = np.maximum.reduceat(along, starts) - np.minimum.reduceat(along, starts)
    if np.average(spread, weights=counts) > MEAN or spread.max() > MOST:
        return None
    means = (np.add.reduceat(values[order], starts) / counts for values in (x, y))
    return next(means), next(means)
