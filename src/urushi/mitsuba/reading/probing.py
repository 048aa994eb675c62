"""What Mitsuba's BSDFs tell: values at pairs of directions, and for a coat above them, their lobes.

Of Mitsuba's own, `roughconductor` with the GGX distribution is a lobe and nothing else,
`roughplastic` and an isotropic `pplastic` have one, and `diffuse` has none. All are read from their
parameters. Others are known by their values alone.
"""

import itertools
from collections.abc import Mapping
from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MAX_INDEX, MIN_ALPHA
from urushi.errors import ParameterError
from urushi.material.symmetry import (
    AZIMUTHS,
    WARNED_ASYMMETRY,
    Deviations,
    isotropy_test_pairs,
    mirrored_pairs,
    nearly_equal,
    rotated_pairs,
)
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading.grid import nested_objects
from urushi.mitsuba.surface import KnownSurface, surface_of
from urushi.nets.lobe import NO_LOBE

#: Greatest number of evaluations in one launch: bounds memory.
CHUNK = 1 << 21

#: Evaluations of a BSDF that draws random numbers: for each pair, and at most for all pairs of all
#: texels together.
REPEATS, BUDGET = 4096, 1 << 26

#: Points at which a textured BSDF is tested for asymmetry.
TESTED = 64

#: Least number of rotations about the normal over which an anisotropic textured BSDF is averaged;
#: twice an odd number, see `symmetry.rotated_pairs`.
LEAST_AZIMUTHS = 6

#: Greatest number of evaluations of an anisotropic textured BSDF, about a minute: large textures
#: are averaged over fewer rotations than `symmetry.AZIMUTHS`.
ANISOTROPIC_BUDGET = 1 << 32

#: The line of a BSDF's description that names its distribution, which it does not list
#: among its parameters.
GGX = "distribution = ggx"

#: All channels.
ALL = slice(None)

#: Mitsuba's rough plastics.
PLASTICS = ("RoughPlastic", "PolarizedPlastic")


def interaction(wi: Any, uv: Any, repeat: float | np.ndarray = 0.0) -> "mi.SurfaceInteraction3f":
    """Surface interactions (M) seen from wi at uv, in the frame of the coordinates.

    Args:
        wi, uv: arrays (M, 3) and (M, 2), or vectors of Mitsuba's.
        repeat: the time, one number or (M,). BSDFs that draw random numbers draw others at another
            time.
    """
    wi = _vector(wi)
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wi))
    si.wi, si.uv = wi, _vector(uv, mi.Point2f)
    si.time = mi.Float(repeat)
    dr.make_opaque(si.time)  # a constant would make another kernel each time
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Vector3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    if mi.is_spectral:
        si.wavelengths = mi.Spectrum([*spectrum.RGB, spectrum.RGB[-1]])
    return si


def bsdf_values(
    bsdf: "mi.BSDF",
    wi: np.ndarray,
    wo: np.ndarray,
    uv: np.ndarray,
    repeat: float | np.ndarray = 0.0,
) -> np.ndarray:
    """f (M, C) [1/sr] of a BSDF for wi, wo (M, 3) above the horizon at uv (M, 2)."""
    parts = []
    for start in range(0, len(wi), CHUNK):
        rows = slice(start, start + CHUNK)
        time = repeat[rows] if isinstance(repeat, np.ndarray) else repeat
        si = interaction(wi[rows], uv[rows], time)
        out = _vector(wo[rows])
        values = bsdf_channels(bsdf, si, out)
        dr.eval(values)
        channels = [channel.numpy() for channel in values]
        parts.append(np.stack(np.broadcast_arrays(*channels, wi[rows, 0])[:-1], axis=-1))
    return np.concatenate(parts)


def mean_values(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, repeats: int = 1) -> np.ndarray:
    """f float64 (M, C) [1/sr] in the middle of uv, as the mean of `repeats` evaluations."""
    a, b = (np.tile(w, (repeats, 1)) for w in (wi, wo))
    time = np.repeat(np.arange(repeats, dtype=np.float32), len(wi))
    f = bsdf_values(bsdf, a, b, np.full((len(a), 2), 0.5), time)
    return f.reshape(repeats, len(wi), -1).sum(axis=0).astype(np.float64) / repeats


def bsdf_channels(bsdf: "mi.BSDF", si, wo: "mi.Vector3f") -> list:
    """f [1/sr] of each channel of a BSDF at a surface interaction, as Dr.Jit floats."""
    return spectrum.at_bands(si, lambda: bsdf.eval(mi.BSDFContext(), si, wo) / wo.z)


class Averaging(NamedTuple):
    """An average of a BSDF that has the symmetry of a material and is free of noise.

    Pairs are turned about the normal as by `symmetry.rotated_pairs`; 0 azimuths stand for the
    mirror images of `symmetry.mirrored_pairs`.
    """

    azimuths: int = 1  # number of common rotations of a pair
    exchanged: bool = False  # whether wi and wo are exchanged as well
    repeats: int = 1  # evaluations of each pair, for BSDFs that draw random numbers

    def pairs(self, wi: np.ndarray, wo: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """The pairs whose values are averaged for pairs (P, 3)."""
        turned = rotated_pairs(wi, wo, self.azimuths) if self.azimuths else mirrored_pairs(wi, wo)
        found = list(turned)
        return found + [sides[::-1] for sides in found] if self.exchanged else found


#: A single evaluation.
ONCE = Averaging()


def texel_values(
    bsdf: "mi.BSDF",
    wi: np.ndarray,
    wo: np.ndarray,
    uv: np.ndarray,
    average: Averaging = ONCE,
    kept: slice = ALL,
) -> np.ndarray:
    """f float32 (M, C, P) [1/sr] at points uv (M, 2) for pairs (P, 3) above the horizon.

    kept: of the channels, which C are.
    """
    tables = [[_vector(w) for w in sides] for sides in average.pairs(wi, wo)]
    count, most = average.repeats * len(tables), max(CHUNK // len(wi), 1)
    channel_count = len(range(spectrum.channel_count())[kept])
    result = np.empty((len(uv), channel_count, len(wi)), np.float32)
    for start in range(0, len(uv), most):
        part = result[start : start + most]
        index = dr.arange(mi.UInt32, len(part) * len(wi))
        texel = index // len(wi)
        pair = index - texel * len(wi)
        where = dr.gather(mi.Point2f, _vector(uv[start : start + most], mi.Point2f), texel)
        total = [mi.Float(0)] * part.shape[1]
        for repeat, table in itertools.product(range(average.repeats), tables):
            a, b = (dr.gather(mi.Vector3f, w, pair) for w in table)
            channels = bsdf_channels(bsdf, interaction(a, where, float(repeat)), b)[kept]
            total = [x + y for x, y in zip(total, channels, strict=True)]
            dr.eval(total)
        for channel, value in enumerate(total):
            values = np.broadcast_to((value / count).numpy(), len(part) * len(wi))
            part[:, channel] = values.reshape(len(part), len(wi))
    return result


def needed_averaging(
    bsdf: "mi.BSDF",
    wi: np.ndarray,
    wo: np.ndarray,
    uv: np.ndarray,
    where: str,
    widths: int = 1,
    kept: slice = ALL,
) -> Averaging:
    """The averaging that gives a BSDF the symmetry of a material at uv (M, 2) and pairs (P, 3).

    A BSDF that has it at `TESTED` of the points is taken to have it everywhere.

    where: begins warnings. widths: of the material's codes.
    """
    points = len(uv)
    count = needed_repeats(bsdf, wi, wo, points)
    if count > 1:
        return Averaging(2 if widths == 1 else 0, True, count)
    uv = uv[np.random.default_rng(0).integers(points, size=TESTED)]
    tests = [isotropy_test_pairs(wi, wo)] if widths == 1 else mirrored_pairs(wi, wo)[1:3]
    once, exchanged, *others = (
        texel_values(bsdf, *pair, uv, kept=kept) for pair in ((wi, wo), (wo, wi), *tests)
    )
    reciprocal = nearly_equal(once, exchanged)
    if all(nearly_equal(once, other) for other in others):
        return Averaging(1, not reciprocal)
    if widths == 2:
        return Averaging(0, not reciprocal)
    mean = texel_values(bsdf, wi, wo, uv, Averaging(LEAST_AZIMUTHS), kept)
    spread = np.abs(once - mean).sum() / max(mean.sum(), 1e-30)
    if spread > WARNED_ASYMMETRY:
        mi.Log(mi.LogLevel.Warn, f"{where}: " + Deviations(anisotropy=spread).warnings()[0])
    most = ANISOTROPIC_BUDGET // (points * len(wi) * (1 if reciprocal else 2))
    odd = (min(max(most, LEAST_AZIMUTHS), AZIMUTHS) // 2 - 1) // 2 * 2 + 1
    return Averaging(2 * odd, not reciprocal)


def check_values(f: np.ndarray, where: str) -> np.ndarray:
    """Return f; refuse a value that is negative or not finite."""
    if not (np.isfinite(f) & (f >= 0)).all():
        raise ParameterError(
            f"{where}: the nested BSDF returns a negative or non-finite value; "
            "a BRDF must be finite and at least 0"
        )
    return f


def needed_repeats(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, points: int) -> int:
    """Number of evaluations to average over at `points` texels: 1 unless the BSDF is random."""
    uv = np.random.default_rng(0).random((len(wi), 2))  # a mask may hide what is random
    first, second = (bsdf_values(bsdf, wi, wo, uv, time) for time in (0.0, 1.0))
    if np.array_equal(first, second):
        return 1
    return max(min(REPEATS, BUDGET // (points * len(wi))) // (2 * AZIMUTHS), 1)


def _vector(w: Any, kind: Any = None) -> Any:
    """An array (M, 3) as `mi.Vector3f`, or as another kind; a vector of Mitsuba's as it is."""
    if not isinstance(w, np.ndarray):
        return w
    return (kind or mi.Vector3f)(np.ascontiguousarray(w.T, np.float32))


def known_surface(bsdf: "mi.BSDF") -> KnownSurface:
    """What is known of a BSDF, or of the front side of Mitsuba's `twosided`."""
    surface = surface_of(bsdf)
    if surface is not None:
        return surface.known()
    while bsdf.class_name() == "TwoSidedBRDF":
        bsdf = nested_objects(bsdf)["brdf_0"]
    if bsdf.class_name() == "SmoothDiffuse":
        lobes = [[*map(mi.Float, NO_LOBE)]] * dr.size_v(mi.Spectrum)
        return KnownSurface(lobes=lambda si: lobes)
    plastic = bsdf.class_name() in PLASTICS and "alpha_u" not in nested_objects(bsdf)
    if plastic and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_plastic_lobes, bsdf), table_source=lambda: bsdf)
    if bsdf.class_name() == "RoughConductor" and GGX in str(bsdf):
        return KnownSurface(lobes=partial(_conductor_lobes, nested_objects(bsdf)), lobe_only=True)
    return KnownSurface()


def known_lobes(bsdf: "mi.BSDF", uv: np.ndarray) -> np.ndarray | None:
    """The lobes float32 (M, C, 6 or 7) of a BSDF at points uv (M, 2); None: they are not known."""
    known = known_surface(bsdf)
    si = interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    channels = spectrum.at_bands(si, lambda: known.lobes(si) or ())
    if not channels:
        return None
    dr.eval(channels)
    rows = [[np.broadcast_to(x.numpy(), len(uv)) for x in lobe] for lobe in channels]
    return np.moveaxis(np.array(rows, np.float32), -1, 0)


def _conductor_lobes(textures: Mapping[str, "mi.Texture"], si) -> list[list]:
    """The lobes of a conductor: six or seven Dr.Jit floats for each channel."""
    names = ("alpha_u", "alpha_v") if "alpha_u" in textures else ("alpha",)
    given = (textures[name].eval_1(si) for name in names)
    # The derivative passes the bound, so that an optimiser can leave it.
    alpha, *across = (dr.replace_grad(dr.maximum(x, MIN_ALPHA), x) for x in given)
    columns = [_channels(textures, x, si) for x in ("specular_reflectance", "eta", "k")]
    found = []
    for reflectance, eta, k in zip(*columns, strict=True):
        # Mitsuba's metal "none" has the index 0 and reflects all light.
        exact = eta > 0
        schlick = dr.select(exact, 0, reflectance)
        eta, k = (dr.minimum(x, MAX_INDEX) for x in (eta, k))
        index = dr.select(exact, eta, NO_LOBE[4]), dr.select(exact, k, 0)
        factors = schlick, schlick, dr.select(exact, reflectance, 0)
        found.append([alpha, *factors, *index, *across])
    return found


def _plastic_lobes(plastic: "mi.BSDF", si) -> list[list]:
    """The lobes of a plastic: six Dr.Jit floats for each channel."""
    given, textures, zero = mi.traverse(plastic), nested_objects(plastic), mi.Float(0)
    alpha, eta = (
        textures[name].eval_1(si) if name in textures else mi.Float(given[name])
        for name in ("alpha", "eta")
    )
    alpha = dr.replace_grad(dr.maximum(alpha, MIN_ALPHA), alpha)
    tints = _channels(textures, "specular_reflectance", si)
    return [[alpha, zero, zero, tint, eta, zero] for tint in tints]


def _channels(textures: Mapping[str, "mi.Texture"], name: str, si) -> list:
    """The channels of a texture; ones if it is missing."""
    if name in textures:
        return [*textures[name].eval(si)]
    return [mi.Float(1)] * dr.size_v(mi.Spectrum)
