"""The parameters of a coat and its bottom that vary over a surface, as axes.

Their values come from Mitsuba's own textures at the shading point, and so does every filter, wrap,
transform, mesh attribute and volume. A parameter that carries a gradient is an axis too, over all
the values that it may take.
"""

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA, MIN_INDEX_STEP, finite_number, nonnegative
from urushi.core.appearance import LOOK, PHYSICAL
from urushi.material.layer import DEEPEST, WIDEST
from urushi.mitsuba import spectrum
from urushi.mitsuba.latents.axes import Varying
from urushi.mitsuba.reading.changed import numbers_of
from urushi.mitsuba.reading.grid import ELSEWHERE, parts, varying_textures
from urushi.mitsuba.reading.parameters import CHECKS, TWO_WIDTHS, CoatTextures
from urushi.mitsuba.snapshot import has_gradients, is_attached, writable
from urushi.textures.axes import ALBEDO, DEPTH, INDEX, LINEAR, REFLECTANCE, WIDTH, Axis, Changes
from urushi.textures.store import from_texture

#: All values of a parameter, by its scale.
RANGES = {
    WIDTH: (MIN_ALPHA, 1.0),
    DEPTH: (0.0, DEEPEST),
    REFLECTANCE: (0.0, 1.0),
    ALBEDO: (0.0, 1.0),
    LINEAR: (0.0, 1.0),
}

#: Textures of indices of refraction.
INDICES = ("int_ior", "ext_ior")

#: Scales of a coat's parameters, and the textures on which each depends; those of an appearance
#: depend on g, too.
COAT: dict[str, tuple[str, tuple[str, ...]]] = {
    "alpha": (WIDTH, ("alpha",)),
    "alpha_u": (WIDTH, ("alpha_u",)),
    "alpha_v": (WIDTH, ("alpha_v",)),
    "eta": (INDEX, INDICES),
    "albedo": (ALBEDO, ("albedo", *LOOK)),
    "sigma_t": (DEPTH, ("sigma_t", *LOOK, "thickness")),
    "g": (LINEAR, ("g",)),
}

#: Range of g in which light transport is accurate, and relative indices on both sides of one.
ASYMMETRIES, ABOVE, BELOW = (-0.95, 0.95), (1 + 2 * MIN_INDEX_STEP, 3.0), (0.4, 0.995)

#: Changes of constants by which slopes are found: a share of the value, and a number.
CHANGES = {
    WIDTH: (0.05, 0.0),
    DEPTH: (0.05, 0.02),
    REFLECTANCE: (0.04, 0.0005),
    ALBEDO: (0.0, 0.01),
    LINEAR: (0.0, 0.02),
    INDEX: (0.0, 0.005),
}

#: Largest change of one of two widths that carries a gradient, until codes are baked again.
NEAR = 1.3

#: Points of uv of what is no bitmap, along each side, and those for more than one texture.
SIDE, POINTS = 256, 1 << 14

#: Name of the axis of wavelengths, of the wavelengths on it [nm], and start of the names of a
#: bottom's parameters.
WAVELENGTH, NANOMETRES, BOTTOM = "wavelength", "nm", "bottom."


def varying_parameters(
    coat: CoatTextures,
    bottom: "mi.BSDF",
    known: Sequence[Varying] | None = None,
) -> list[Varying]:
    """The parameters of a coat and a bottom that vary or carry gradients.

    known: those of a bottom that has codes over axes; None: they are read.
    """
    below = [x._replace(axis=x.axis._replace(name=_below(x.axis.name))) for x in known or ()]
    if known is None:
        below = _of_bottom(bottom, coat.where)
    found = [*_of_coat(coat), *below]
    return list({x.axis.name: x for x in found}.values())


def _below(name: str) -> str:
    """The name of a parameter of a nested coat."""
    return name if name == WAVELENGTH else BOTTOM + name


def _of_coat(coat: CoatTextures) -> list[Varying]:
    found = []
    for name, (scale, sources) in COAT.items():
        if name in PHYSICAL and "color" in coat.textures:
            sources = *sources, "g"
        own = [coat.textures[x] for x in sources if x in coat.textures]
        indices = coat.indices if name == "eta" else ()
        gradient = any(map(has_gradients, own)) or any(map(is_attached, indices))
        if name not in coat.names or not (gradient or any(map(varying_textures, own))):
            continue

        def read(si, active, name=name) -> list:
            return coat.at(si, active)[name]

        whole = _whole(coat, name, scale)
        ends = range_of(lambda si, read=read: read(si, True), own, whole, own == _named(coat, name))
        if scale == WIDTH:
            ends = max(ends[0], MIN_ALPHA), max(ends[1], MIN_ALPHA)
        coloured = name in ("albedo", "sigma_t", "g", *coat.coloured) and any(map(_coloured, own))
        axis = Axis(name, scale, *ends, coloured)
        found += _varying(axis, whole if gradient else None, read, own)
    return found


def _named(coat: CoatTextures, name: str) -> list:
    """The texture that is a parameter of a coat by itself."""
    return [coat.textures[name]] if name in coat.textures else []


def _varying(
    axis: Axis,
    whole: tuple[float, float] | None,
    read: Callable,
    sources: Sequence[Any],
    texture: Any = None,
) -> list[Varying]:
    """A parameter if it varies or carries gradients.

    whole: all the values that it may take, if it carries gradients.
    """
    if whole is not None and not any(map(varying_textures, sources)):
        changes = _changes(axis, whole)
        return [Varying(axis, read, sources, texture, differentiable=True, changes=changes)]
    if whole is not None:
        axis = axis._replace(least=min(axis.least, whole[0]), most=max(axis.most, whole[1]))
    found = Varying(axis, read, sources, texture, whole is not None)
    return [found] if axis.least < axis.most else []


def _changes(axis: Axis, whole: tuple[float, float]) -> Changes:
    """The changes of a constant by which its slopes are found: on both sides, if there are."""
    part, least = CHANGES[axis.scale]
    size = part * axis.most + least
    if axis.least - size < whole[0]:
        return 0.0, size, 2 * size
    if axis.most + size > whole[1]:
        return 0.0, -size, -2 * size
    return -size, 0.0, size


def check_coat(coat: CoatTextures) -> None:
    """Check all values of a coat's textures; the walk clips those on meshes and in space."""
    given = {name: [texture] for name, texture in coat.textures.items() if name not in INDICES}
    given["eta"] = [coat.textures[name] for name in INDICES if name in coat.textures]
    for name, textures in given.items():
        label = "int_ior / ext_ior" if name == "eta" else name
        if follows := [x for texture in textures for x in getattr(texture, "sources", ())]:
            label += f", which follows from {', '.join(follows)},"
        varying = [x for texture in textures for x in varying_textures(texture)]
        if varying := varying or [x for x in textures if x.is_spatially_varying()]:
            label = f"a texel of {label}"

        def read(si, name=name, textures=textures) -> list:
            if name in coat.names and name not in PHYSICAL:  # those are without the thickness
                return coat.at(si)[name]
            if name in (*LOOK, *PHYSICAL):
                return spectrum.to_channels(textures[0].eval(si))
            return [textures[0].eval_1(si)]

        ends = np.array(range_of(read, textures, (np.nan, np.nan), name != "eta"))
        if np.isnan(ends).all() and _elsewhere(textures):
            continue
        ends = ends.astype(np.float64).round(6)
        if varying and CHECKS[name] is CHECKS["alpha"]:  # dark texels of a map, as in the walk
            ends = np.where((ends >= 0) & (ends < MIN_ALPHA), MIN_ALPHA, ends)
        CHECKS[name](ends, f"{coat.where}: {label}", any_shape=True)


def _whole(coat: CoatTextures, name: str, scale: str) -> tuple[float, float]:
    """All values of a parameter of a coat, as far as its codes reach."""
    if name == "g":
        return ASYMMETRIES
    sources = [coat.textures[x] for x in COAT[name][1] if x in coat.textures]
    if name == "eta" and _elsewhere(sources):
        in_air = coat.above is None and coat.outside == 1
        return (1.0 if in_air else BELOW[0]), ABOVE[1]
    if name in TWO_WIDTHS and _elsewhere(sources):
        return _beside(coat.textures[TWO_WIDTHS[name == TWO_WIDTHS[0]]])
    with dr.suspend_grad():
        si = dr.zeros(mi.SurfaceInteraction3f)
        si.uv = mi.Point2f(0.5)
        now = float(coat.at(si, True)[name][0].numpy()[0])
    if name == "eta":
        return ABOVE if now >= 1 else BELOW
    return _near(now) if name in TWO_WIDTHS else RANGES[scale]


def _near(width: float) -> tuple[float, float]:
    """Values about one of two widths, whose ratio is bounded."""
    return max(width / NEAR, MIN_ALPHA), min(width * NEAR, 1.0)


def _elsewhere(textures: Sequence["mi.Texture"]) -> bool:
    """Whether a texture is given on a mesh or in space, so that its values are not known here."""
    return any(x.class_name() in ELSEWHERE for own in textures for x in varying_textures(own))


def _beside(other: "mi.Texture") -> tuple[float, float]:
    """All values of one of two widths beside the other one, whose ratio is bounded."""
    if _elsewhere([other]):
        return 1 / WIDEST, 1.0
    least, most = range_of(lambda si: [other.eval_1(si)], [other], (0.0, 1.0), plain=True)
    return max(most / WIDEST, MIN_ALPHA), min(least * WIDEST, 1.0)


def _of_bottom(bottom: "mi.BSDF", where: str) -> list[Varying]:
    found, seen = [], set[int]()
    for name, texture in parts(bottom).items():
        if not isinstance(texture, mi.Texture) or id(texture) in seen:
            continue
        seen.add(id(texture))
        gradient = has_gradients(texture)
        if not (gradient or varying_textures(texture)):
            continue
        last = name.rpartition(".")[2]
        coloured = "reflectance" in last or "color" in last or last in ("eta", "k")
        scale = WIDTH if last.startswith("alpha") else REFLECTANCE if coloured else LINEAR
        whole = (0.0, np.inf) if last in ("eta", "k") else RANGES[scale]
        if last in TWO_WIDTHS and _elsewhere([texture]):
            whole = _beside(parts(bottom)[name[:-1] + ("v" if last == TWO_WIDTHS[0] else "u")])
        elif last in TWO_WIDTHS:
            with dr.suspend_grad():
                whole = _near(float(texture.eval_1(spectrum.points(spectrum.MIDDLE)).numpy()[0]))

        def read(si, active, texture=texture, coloured=coloured) -> list:
            if not coloured:
                return [texture.eval_1(si, active)]
            return spectrum.to_channels(texture.eval(si, active))

        ends = range_of(lambda si, read=read: read(si, True), [texture], whole, True)
        check = finite_number if scale == LINEAR else nonnegative
        check(ends, f"{where}: a texel of the nested BSDF's {name}", any_shape=True)
        axis = Axis(BOTTOM + name, scale, *ends, coloured and _coloured(texture))
        found += _varying(axis, whole if gradient else None, read, [texture], texture)
    return found + _numbers_of_bottom(bottom)


def _numbers_of_bottom(bottom: "mi.BSDF") -> list[Varying]:
    """The plain numbers of a bottom that carry gradients."""
    found, parameters = [], mi.traverse(bottom)
    for key, value in writable(bottom):
        last, owner = key.rpartition(".")[2], parameters.properties[key][2]
        if not is_attached(value) or last not in numbers_of(owner):
            continue

        def read(si, active, owner=owner, last=last) -> list:
            return [mi.Float(mi.traverse(owner)[last])]

        scale = WIDTH if last == "alpha" else LINEAR
        now = float(np.ravel(value)[0])
        axis = Axis(BOTTOM + key, scale, now, now)
        changes = _changes(axis, RANGES[WIDTH] if scale == WIDTH else (0.0, np.inf))
        found.append(Varying(axis, read, differentiable=True, changes=changes))
    return found


def _coloured(texture: "mi.Texture") -> bool:
    """Whether a texture may have another value in each channel."""
    if mi.is_monochromatic or texture.class_name() == "UniformSpectrum":
        return False
    if not texture.class_name().startswith("BitmapTexture"):
        return True
    return mi.traverse(texture)["data"].shape[-1] != 1


def range_of(
    read: Callable[..., list],
    textures: Sequence["mi.Texture"],
    whole: tuple[float, float],
    plain: bool,
) -> tuple[float, float]:
    """The least and the largest value that a parameter has on a surface.

    It is known at the texels of a bitmap. What is given on a mesh or in space has all values.

    Args:
        read: from surface interactions to the values.
        textures: on which it depends.
        whole: all values.
        plain: whether it is the value of the only texture.
    """
    low, high = np.inf, -np.inf
    varying = [x for texture in textures for x in varying_textures(texture)]
    if not varying:
        si = spectrum.points(spectrum.MIDDLE)
        values = [x.numpy() for x in spectrum.at_bands(si, lambda: read(si))]
        return float(np.min(values)), float(np.max(values))
    if any(x.class_name() in ELSEWHERE for x in varying):
        return whole
    only = varying[0]
    bitmap = only.class_name().startswith("BitmapTexture")
    if bitmap and plain and only is textures[0] and not mi.is_spectral:
        data = mi.traverse(only)["data"].numpy()
        return float(data.min()), float(data.max())
    places = [texel_centres(x) for x in varying]
    if len(places) > 1:  # a function of several textures may be extreme between their texels
        places.append(np.random.default_rng(0).random((POINTS, 2)))
    for uv in places:
        si = spectrum.points(uv)
        with spectrum.reading_at(spectrum.FINE):
            for x in spectrum.at_bands(si, lambda si=si: read(si)):
                values = x.numpy()
                low, high = np.minimum(low, values.min()), np.maximum(high, values.max())
    return float(low), float(high)


def texel_centres(texture: "mi.Texture") -> np.ndarray:
    """The uv (M, 2) of the centres of a texture's texels, or of a grid."""
    parameters, (width, height) = mi.traverse(texture), texture.resolution()
    if width * height <= 1:
        width = height = SIDE
    index = np.arange(width * height)
    x = np.stack([index % width + 0.5, index // width + 0.5], axis=-1) / (width, height)
    if "to_uv" not in parameters:
        return x
    matrix = np.asarray(parameters["to_uv"].matrix.numpy(), np.float64).reshape(3, 3)
    return from_texture(tuple(map(tuple, matrix[:2].tolist())), x)
