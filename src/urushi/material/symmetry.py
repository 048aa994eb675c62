"""Making BRDFs isotropic and reciprocal, as materials are, and measuring what that changes."""

import functools
from collections.abc import Callable, Iterator
from typing import Any, NamedTuple

import numpy as np

from urushi.geometry.direction_sets import cosine_pairs
from urushi.geometry.error_metrics import energy_weight

#: Common turns of a pair about the normal over which a BRDF is averaged: twice an odd number, see
#: `_turns`. Fewer leave the narrow lobe of a brushed metal in pieces, which are like nothing that
#: encoders know.
AZIMUTHS = 62

#: The turn, as a fraction of a whole one, that tells whether a BRDF needs averaging: not a simple
#: one, for the sake of BRDFs that repeat themselves after such.
TEST_ROTATION = 0.155

#: Relative difference up to which values count as the same: single precision in steep lobes.
RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 1e-3, 1e-5

#: Pairs of cosine density at which the asymmetry is measured.
ASYMMETRY_PAIRS = 1024

#: Findings above these are worth a warning: an error E for asymmetries, a share of the light.
WARNED_ASYMMETRY, WARNED_SHARE = 0.1, 0.01

#: An evaluated BRDF: f(wi, wo) -> (N, 3), (N, C) or (N,) [1/sr] for float32 unit vectors (N, 3).
Brdf = Callable[[np.ndarray, np.ndarray], Any]


class Source(NamedTuple):
    """A BRDF to be encoded.

    Attributes:
        f: evaluates it at pairs above the horizon.
        symmetric: whether it is known to be isotropic and reciprocal.
        noisy: whether it is known to draw random numbers, so that its asymmetry cannot be told
            from noise.
        transmitted, mirrored: shares of the light, in [0, 1], that it lets through or reflects
            without any roughness: neither is in f.
        textured: whether f is that of one point of a texture.
    """

    f: Brdf
    symmetric: bool = False
    noisy: bool = False
    transmitted: float = 0.0
    mirrored: float = 0.0
    textured: bool = False


class Deviations(NamedTuple):
    """How a source differs from what a material can be.

    Attributes:
        anisotropy: E between the source and its mean over the azimuth: none is 0, and no isotropic
            BRDF is much closer to the source. None where noise forbids to tell.
        reciprocity: the same for the mean over the exchange of wi and wo.
        transmitted, mirrored, textured: as of `Source`.
    """

    anisotropy: float | None = 0.0
    reciprocity: float | None = 0.0
    transmitted: float = 0.0
    mirrored: float = 0.0
    textured: bool = False

    def warnings(self) -> list[str]:
        """What a user should know, a sentence each."""
        sentences = []
        if (self.anisotropy or 0.0) > WARNED_ASYMMETRY:
            sentences.append(
                f"the BRDF is anisotropic: it differs by {self.anisotropy:.0%} from its mean over "
                "the azimuth, which is encoded, because materials are isotropic"
            )
        if (self.reciprocity or 0.0) > WARNED_ASYMMETRY:
            sentences.append(
                f"the BRDF is not reciprocal: it differs by {self.reciprocity:.0%} from its mean "
                "over the exchange of wi and wo, which is encoded"
            )
        if self.transmitted > WARNED_SHARE:
            sentences.append(
                f"the BSDF lets {self.transmitted:.0%} of the light through: only what it reflects "
                "is encoded, and the material is opaque"
            )
        if self.mirrored > WARNED_SHARE:
            sentences.append(
                f"the BSDF reflects {self.mirrored:.0%} of the light by a perfectly smooth "
                "surface, which is left out; give its rough variant"
            )
        if self.textured:
            sentences.append("the BSDF is textured: it is encoded as it is in the middle of uv")
        return sentences


def symmetrise(
    source: Source, wi: np.ndarray, wo: np.ndarray, check: Callable[[Any, int], np.ndarray]
) -> tuple[np.ndarray, Deviations]:
    """Values of a source, made isotropic and reciprocal, and what that has changed.

    A source that shows no asymmetry gives its own values. Any other's are means over `AZIMUTHS`
    turns of the pair about the normal, every second one mirrored, each with wi and wo exchanged.

    Args:
        source: what is evaluated.
        wi, wo: float32 (N, 3), above the horizon.
        check: makes of what the source gives, for so many pairs, an array float32 (N, C).

    Returns:
        float32 (N, C), and the findings.
    """
    if source.symmetric:
        return check(source.f(wi, wo), len(wi)), _deviations(source, 0.0, 0.0)
    count = len(wi)
    wi, wo = (np.concatenate(sides) for sides in zip((wi, wo), asymmetry_pairs(), strict=True))

    def values(a: np.ndarray, b: np.ndarray) -> np.ndarray:
        return check(source.f(a, b), len(a))

    once, noisy = values(wi, wo), source.noisy
    if not noisy:
        asked = values(*(rotated(w, TEST_ROTATION, True) for w in (wi, wo)))
        if nearly_equal(once, asked) and nearly_equal(once, values(wo, wi)):
            return once[:count], _deviations(source, 0.0, 0.0)
        noisy = not np.array_equal(once, values(wi, wo))
    pairs = list(rotated_pairs(wi, wo))
    # (exchange, azimuth, N, C)
    every = np.stack([[values(a, b) for a, b in pairs], [values(b, a) for a, b in pairs]])
    isotropic = every.mean(axis=1)
    mean = isotropic.mean(axis=0)
    if noisy:
        return mean[:count], _deviations(source, None, None)
    anisotropy = _error(every[..., count:, :], isotropic[:, None, count:])
    reciprocity = _error(isotropic[:, count:], mean[count:])
    return mean[:count], _deviations(source, anisotropy, reciprocity)


def azimuthal_mean(f: Callable[..., np.ndarray], wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """The mean of f(wi, wo) over the azimuth alone."""
    return np.mean([f(*pair) for pair in rotated_pairs(wi, wo)], axis=0)


def rotated(w: np.ndarray, turn: float, mirrored: bool = False) -> np.ndarray:
    """Directions (N, 3) turned about the normal by a part of a whole turn, then y negated."""
    cos, sin = np.cos(2 * np.pi * turn), np.sin(2 * np.pi * turn)
    sign = -1.0 if mirrored else 1.0
    return (w @ np.array([[cos, sign * sin, 0], [-sin, sign * cos, 0], [0, 0, 1]])).astype(
        np.float32
    )


def nearly_equal(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays of values [1/sr] are equal but for rounding."""
    return bool((np.abs(a - b) <= RELATIVE_TOLERANCE * np.maximum(a, b) + ABSOLUTE_TOLERANCE).all())


@functools.cache
def asymmetry_pairs() -> tuple[np.ndarray, np.ndarray]:
    """The `JUDGED` pairs, the same always; none so low that a half vector is lost to rounding."""
    return cosine_pairs(np.random.default_rng(0), ASYMMETRY_PAIRS, lowest_cosine=0.01)


def rotated_pairs(wi: np.ndarray, wo: np.ndarray) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """The pairs that f is averaged over: turned, and every second one mirrored.

    Most anisotropic BRDFs are as before after half a turn, and as their mirror image. They too are
    seen from `AZIMUTHS` sides: an odd number of turns lies evenly over half a turn, and those of
    the mirrored pairs lie in the middle between them.
    """
    odd = AZIMUTHS // 2
    for k in range(odd):
        for mirrored in (False, True):
            turn = (k + 0.25 * mirrored) / odd
            yield rotated(wi, turn, mirrored), rotated(wo, turn, mirrored)


def _deviations(source: Source, anisotropy: float | None, reciprocity: float | None) -> Deviations:
    return Deviations(anisotropy, reciprocity, source.transmitted, source.mirrored, source.textured)


def _error(f: np.ndarray, mean: np.ndarray) -> float:
    """E of values (..., JUDGED, C) against their mean (broadcast), all channels together."""
    wi, wo = asymmetry_pairs()
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    energy = float((np.broadcast_to(mean, f.shape) * weight).sum())
    return float((np.abs(f - mean) * weight).sum()) / energy if energy > 0 else 0.0
