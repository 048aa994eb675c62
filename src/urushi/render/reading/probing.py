"""Reading a Mitsuba BSDF at pairs of directions, as the encoder wants to see it."""

from typing import NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError
from urushi.render import spectrum
from urushi.render.reading.parameters import check_bottom
from urushi.textures.grid import TexelGrid

#: Evaluations that are traced at once: bounds memory.
CHUNK = 1 << 21

#: Rotations about the normal over which an anisotropic BSDF is averaged, and the relative deviation
#: between them from which on the user is told. They are odd in number: most BSDFs are as before
#: after half a turn, and so averaged over twice as many. Fewer leave a narrow lobe in pieces, which
#: are like nothing that the encoder knows.
AZIMUTHS, ANISOTROPIC = 63, 0.05

#: Evaluations at every pair of a BSDF that draws random numbers, and of all pairs together, which
#: leaves fewer for each texel.
REPEATS, BUDGET = 4096, 1 << 26

#: Points at which a textured BSDF is asked whether it needs averaging, over how many rotations, and
#: the relative deviation from its averages up to which it does not.
TESTED_TEXELS, LEAST_ROTATIONS, SAME = 64, 5, 1e-3

#: Evaluations of an anisotropic textured BSDF in all: large textures are averaged over fewer
#: rotations. So many evaluations take about a minute.
ANISOTROPIC_BUDGET = 1 << 32

#: Evaluations of a pair that are traced in one kernel, at most.
KERNEL_EVALUATIONS = 4


def interaction(
    wi: np.ndarray, uv: np.ndarray, repeat: float | np.ndarray = 0.0
) -> "mi.SurfaceInteraction3f":
    """Surface interactions (M) seen from wi (M, 3) at uv (M, 2), with a frame that has no tilt.

    `repeat`, one number or (M,), goes into the time: BSDFs that draw random numbers then draw
    others.
    """
    return _interaction(_vector(wi), mi.Point2f(np.ascontiguousarray(uv.T, np.float32)), repeat)


def _interaction(
    wi: "mi.Vector3f", uv: "mi.Point2f", repeat: float | np.ndarray
) -> "mi.SurfaceInteraction3f":
    si = dr.zeros(mi.SurfaceInteraction3f, dr.width(wi))
    si.wi, si.uv = wi, uv
    si.time = mi.Float(repeat)
    dr.make_opaque(si.time)  # a constant would make another kernel each time
    si.n = mi.Normal3f(0, 0, 1)
    si.sh_frame = mi.Frame3f(mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0), mi.Vector3f(0, 0, 1))
    si.dp_du, si.dp_dv = mi.Vector3f(1, 0, 0), mi.Vector3f(0, 1, 0)
    spectrum.set_bands(si)
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
        si = interaction(wi[rows], uv[rows], repeat)
        out = _vector(wo[rows])
        f = bsdf.eval(mi.BSDFContext(), si, out) / out.z
        dr.eval(f)
        channels = [channel.numpy() for channel in spectrum.to_channels(f)]
        parts.append(np.stack(np.broadcast_arrays(*channels, wi[rows, 0])[:-1], axis=-1))
    return np.concatenate(parts)


def all_round(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, repeat: float = 0.0) -> np.ndarray:
    """f (2, AZIMUTHS, P, C) at the middle of uv for pairs (P, 3), given and exchanged, turned."""
    turns = [i / AZIMUTHS for i in range(AZIMUTHS)]
    a, b = (np.concatenate([rotated(w, turn) for turn in turns]) for w in (wi, wo))
    uv = np.full((len(a), 2), 0.5)
    both = [bsdf_values(bsdf, *pair, uv, repeat) for pair in ((a, b), (b, a))]
    return np.stack(both).reshape(2, AZIMUTHS, len(wi), -1)


class Averaging(NamedTuple):
    """What a BSDF is averaged over, to be isotropic, reciprocal and without noise.

    Attributes:
        azimuths: common rotations of a pair about the normal.
        exchanged: whether over the exchange of wi and wo as well.
        repeats: evaluations of each, for BSDFs that draw random numbers.
    """

    azimuths: int = 1
    exchanged: bool = False
    repeats: int = 1


def texel_values(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, average: Averaging
) -> np.ndarray:
    """f float32 (M, C, P) [1/sr] at points uv (M, 2) for pairs (P, 3) above the horizon."""
    pairs = len(wi)
    most = max(CHUNK // pairs, 1)
    result = np.empty((len(uv), spectrum.channel_count(), pairs), np.float32)
    turns = [i / average.azimuths for i in range(average.azimuths)]
    lit = [tuple(rotated(w, turn) for w in (wi, wo)) for turn in turns]
    if average.exchanged:
        lit += [pair[::-1] for pair in lit]
    tables = [tuple(_vector(w) for w in pair) for pair in lit]
    count = average.repeats * len(tables)
    for start in range(0, len(uv), most):
        part = uv[start : start + most]
        texel, pair = _outer(len(part), pairs)
        where = dr.gather(mi.Point2f, mi.Point2f(np.ascontiguousarray(part.T, np.float32)), texel)
        total = [mi.Float(0)] * result.shape[1]
        for repeat in range(average.repeats):
            for table in tables:
                a, b = (dr.gather(mi.Vector3f, w, pair) for w in table)
                si = _interaction(a, where, float(repeat))
                channels = spectrum.to_channels(bsdf.eval(mi.BSDFContext(), si, b) / b.z)
                total = [x + y for x, y in zip(total, channels, strict=True)]
                if count > KERNEL_EVALUATIONS:
                    dr.eval(total)
        for channel, value in enumerate(total):
            values = np.broadcast_to((value / count).numpy(), len(part) * pairs)
            result[start : start + most, channel] = values.reshape(len(part), pairs)
    return result


def _outer(rows: int, columns: int) -> tuple["mi.UInt32", "mi.UInt32"]:
    """Row and column of every entry of a matrix, row by row."""
    index = dr.arange(mi.UInt32, rows * columns)
    row = index // columns
    return row, index - row * columns


def needed_averaging(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, grid: TexelGrid, where: str
) -> Averaging:
    """What the values of a BSDF at pairs (P, 3) have to be averaged over, for all of a grid.

    A BSDF that is isotropic and reciprocal at some of its texels is believed to be so everywhere.

    where: begins warnings.
    """
    count = needed_repeats(bsdf, wi, wo, grid.texels)
    if count > 1:
        return Averaging(2, True, count)
    texels = np.random.default_rng(0).integers(grid.texels, size=TESTED_TEXELS)
    some = np.concatenate([grid.uv(texel, texel + 1) for texel in texels])
    once, turned, exchanged = (
        texel_values(bsdf, wi, wo, some, average)
        for average in (Averaging(), Averaging(LEAST_ROTATIONS), Averaging(1, True))
    )
    reciprocal = bool((np.abs(once - exchanged) <= SAME * exchanged + 1e-5).all())
    if (np.abs(once - turned) <= SAME * turned + 1e-5).all():
        return Averaging(1, not reciprocal)
    _warn_anisotropic(np.abs(once - turned).sum() / max(turned.sum(), 1e-30), where)
    most = ANISOTROPIC_BUDGET // (grid.texels * len(wi) * (1 if reciprocal else 2))
    return Averaging(min(max(most, LEAST_ROTATIONS), AZIMUTHS) // 2 * 2 + 1, not reciprocal)


def read_constant(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, where: str) -> np.ndarray:
    """f (P, C) [1/sr] at pairs (P, 3) at the middle of uv, made isotropic and reciprocal.

    Every value is the mean over `AZIMUTHS` common rotations of the pair about the normal, over the
    exchange of wi and wo, and, for BSDFs that draw random numbers, over evaluations.

    where: begins errors and warnings.

    Raises:
        ParameterError: the BSDF transmits, is perfectly smooth, or is negative or not finite.
    """
    check_bottom(bsdf, where)
    count = needed_repeats(bsdf, wi, wo, 1)
    f = all_round(bsdf, wi, wo)
    for repeat in range(1, count):
        f += all_round(bsdf, wi, wo, float(repeat))
    f /= count
    if count == 1:
        _warn_anisotropic(np.abs(f[0] - f[0].mean(axis=0)).sum() / max(f[0].sum(), 1e-30), where)
    return check_values(f.mean(axis=(0, 1)), where)


def _warn_anisotropic(spread: float, where: str) -> None:
    """Warn of a BSDF that varies so much over the azimuth, relatively, if that is much."""
    if spread > ANISOTROPIC:
        mi.Log(
            mi.LogLevel.Warn,
            f"{where}: the nested BSDF is anisotropic ({spread:.0%} over the azimuth), but "
            "Urushi's materials are isotropic: it is averaged over the azimuth",
        )


def check_values(f: np.ndarray, where: str) -> np.ndarray:
    """Return f if it could be a BRDF's.

    Raises:
        ParameterError: it is negative or not finite somewhere.
    """
    if not (np.isfinite(f) & (f >= 0)).all():
        raise ParameterError(
            f"{where}: the nested BSDF gives a negative or not finite value; "
            "a BRDF must be finite and at least 0"
        )
    return f


def needed_repeats(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, points: int) -> int:
    """How often to repeat evaluations: once, unless the answer differs from time to time."""
    uv = np.full((len(wi), 2), 0.5)
    first, second = (bsdf_values(bsdf, wi, wo, uv, time) for time in (0.0, 1.0))
    if np.array_equal(first, second):
        return 1
    return max(min(REPEATS, BUDGET // (points * len(wi))) // (2 * AZIMUTHS), 1)


def rotated(w: np.ndarray, turn: float) -> np.ndarray:
    """Directions (M, 3) turned about the normal by a fraction of a full turn."""
    cos, sin = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    rotation = np.array([[cos, sin, 0], [-sin, cos, 0], [0, 0, 1]])
    return (w @ rotation).astype(np.float32)


def _vector(w: np.ndarray) -> "mi.Vector3f":
    return mi.Vector3f(np.ascontiguousarray(w.T, np.float32))
