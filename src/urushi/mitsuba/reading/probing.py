"""Evaluation of Mitsuba BSDFs at pairs of directions."""

from typing import NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

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
from urushi.mitsuba.reading.known import known_surface

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

#: Greatest number of evaluations of a pair in one kernel.
KERNEL_EVALUATIONS = 4


def interaction(
    wi: np.ndarray, uv: np.ndarray, repeat: float | np.ndarray = 0.0
) -> "mi.SurfaceInteraction3f":
    """Surface interactions (M) seen from wi (M, 3) at uv (M, 2), in the frame of the coordinates.

    repeat: the time, one number or (M,). BSDFs that draw random numbers draw others at another
        time.
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
        values = bsdf_channels(bsdf, si, out)
        dr.eval(values)
        channels = [channel.numpy() for channel in values]
        parts.append(np.stack(np.broadcast_arrays(*channels, wi[rows, 0])[:-1], axis=-1))
    return np.concatenate(parts)


def bsdf_channels(bsdf: "mi.BSDF", si, wo: "mi.Vector3f") -> list:
    """f [1/sr] of each channel of a BSDF at a surface interaction, as Dr.Jit floats."""
    return spectrum.at_bands(
        si, lambda: spectrum.to_channels(bsdf.eval(mi.BSDFContext(), si, wo) / wo.z)
    )


class Averaging(NamedTuple):
    """An average of a BSDF that has the symmetry of a material and is free of noise.

    Pairs are turned about the normal as by `symmetry.rotated_pairs`; 0 azimuths stand for the
    mirror images of `symmetry.mirrored_pairs`.
    """

    azimuths: int = 1  # number of common rotations of a pair
    exchanged: bool = False  # whether wi and wo are exchanged as well
    repeats: int = 1  # evaluations of each pair, for BSDFs that draw random numbers

    def pairs(self, wi: np.ndarray, wo: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
        """The pairs whose values are averaged for pairs (P, 3), without their exchange."""
        if self.azimuths == 0:
            return mirrored_pairs(wi, wo)
        return list(rotated_pairs(wi, wo, self.azimuths))


def texel_values(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, average: Averaging
) -> np.ndarray:
    """f float32 (M, C, P) [1/sr] at points uv (M, 2) for pairs (P, 3) above the horizon."""
    most = max(CHUNK // len(wi), 1)
    result = np.empty((len(uv), spectrum.channel_count(), len(wi)), np.float32)
    for start in range(0, len(uv), most):
        part = result[start : start + most]
        channels = averaged_channels(bsdf, wi, wo, uv[start : start + most], average)
        for channel, value in enumerate(channels):
            values = np.broadcast_to(value.numpy(), len(part) * len(wi))
            part[:, channel] = values.reshape(len(part), len(wi))
    return result


def averaged_channels(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, average: Averaging
) -> list:
    """`texel_values` of each channel (M * P), point by point, as Dr.Jit floats."""
    index = dr.arange(mi.UInt32, len(uv) * len(wi))
    texel = index // len(wi)
    pair = index - texel * len(wi)
    where = dr.gather(mi.Point2f, mi.Point2f(np.ascontiguousarray(uv.T, np.float32)), texel)
    averaged = average.pairs(wi, wo)
    if average.exchanged:
        averaged += [sides[::-1] for sides in averaged]
    tables = [[_vector(w) for w in sides] for sides in averaged]
    count = average.repeats * len(tables)
    total = [mi.Float(0)] * spectrum.channel_count()
    for repeat in range(average.repeats):
        for table in tables:
            a, b = (dr.gather(mi.Vector3f, w, pair) for w in table)
            channels = bsdf_channels(bsdf, _interaction(a, where, float(repeat)), b)
            total = [x + y for x, y in zip(total, channels, strict=True)]
            if count > KERNEL_EVALUATIONS:
                dr.eval(total)
    return [value / count for value in total]


def needed_averaging(
    bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, uv: np.ndarray, where: str, widths: int = 1
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
        texel_values(bsdf, *pair, uv, Averaging()) for pair in ((wi, wo), (wo, wi), *tests)
    )
    reciprocal = nearly_equal(once, exchanged)
    if all(nearly_equal(once, other) for other in others):
        return Averaging(1, not reciprocal)
    if widths == 2:
        return Averaging(0, not reciprocal)
    mean = texel_values(bsdf, wi, wo, uv, Averaging(LEAST_AZIMUTHS))
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


def known_lobes(bsdf: "mi.BSDF", uv: np.ndarray) -> np.ndarray | None:
    """The lobes float32 (M, C, 6 or 7) of a BSDF at points uv (M, 2); None: they are not known."""
    known = known_surface(bsdf)
    si = interaction(np.tile([0.0, 0.0, 1.0], (len(uv), 1)), uv)
    channels = spectrum.at_bands(si, lambda: known.lobes(si) or ())
    if not channels:
        return None
    return spectrum.stacked(channels, len(uv))


def _vector(w: np.ndarray) -> "mi.Vector3f":
    return mi.Vector3f(np.ascontiguousarray(w.T, np.float32))
