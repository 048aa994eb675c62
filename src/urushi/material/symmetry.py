"""Averages that give a BRDF the symmetry of materials, and what they change.

Materials are reciprocal. With one width they do not change if both directions are rotated
about the normal. With two they are symmetric about the xz and the yz plane.
"""

import functools
from collections.abc import Iterator
from typing import NamedTuple

import numpy as np

from urushi.core.direction_sets import cosine_pairs
from urushi.core.directions import rotated
from urushi.core.error_metrics import energy_weight
from urushi.material.source import Source

#: Number of common rotations of a pair about the normal over which a BRDF is averaged: twice an odd
#: number, see `rotated_pairs`. With fewer, the narrow lobe of a brushed metal leaves separate
#: peaks, unlike any material.
AZIMUTHS = 62

#: The rotation, as a fraction of a full turn, by which isotropy is tested. It is no simple
#: fraction, because some BRDFs are invariant under such rotations.
TEST_ROTATION = 0.155

#: Anisotropy E above which a source gets codes of two widths.
KEPT_ANISOTROPY = 0.02

#: Differences up to which two values are equal: relative, for single precision in steep lobes, and
#: absolute [1/sr].
RELATIVE_TOLERANCE, ABSOLUTE_TOLERANCE = 1e-3, 1e-5

#: Number of pairs of cosine density at which the asymmetry is measured.
ASYMMETRY_PAIRS = 1024

#: Deviations above these cause a warning: the error E of an asymmetry, and a share of the light.
WARNED_ASYMMETRY, WARNED_SHARE = 0.1, 0.01


class Deviations(NamedTuple):
    """Deviations of a source from what a material can represent."""

    # E between the source and its mean over the azimuth, or over mirror images for a material of
    # two widths. No isotropic BRDF is much closer than the mean. None: the source is noisy.
    anisotropy: float | None = 0.0
    reciprocity: float | None = 0.0  # E of the mean over the exchange of wi and wo
    transmitted: float = 0.0  # as in `Source`, as the next two
    mirrored: float = 0.0
    textured: bool = False
    widths: int = 1  # of the material

    def warnings(self) -> list[str]:
        """Sentences for the user about deviations that are not small."""
        sentences = []
        if (self.anisotropy or 0.0) > WARNED_ASYMMETRY and self.widths == 2:
            sentences.append(
                f"the BRDF is not symmetric about its tangent: it differs by {self.anisotropy:.0%} "
                "from its mean over the mirror images at the xz and the yz plane, which is encoded"
            )
        elif (self.anisotropy or 0.0) > WARNED_ASYMMETRY:
            sentences.append(
                f"the BRDF is anisotropic: it differs by {self.anisotropy:.0%} from its mean over "
                "the azimuth, which is encoded, because these weights are for isotropic materials"
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
            sentences.append("the BSDF is textured: its value in the middle of uv is encoded")
        return sentences


def symmetrise(
    source: Source, wi: np.ndarray, wo: np.ndarray, widths: int = 1
) -> tuple[np.ndarray, Deviations]:
    """Values of a source with the symmetry of a material, and how much that changed them.

    A source that shows no asymmetry gives its own values. The values of any other are means over
    `rotated_pairs`, or `mirrored_pairs` for materials of two widths, and over the exchange of wi
    and wo.

    Args:
        source: the BRDF; f returns float32 (N, C).
        wi, wo: float32 (N, 3), above the horizon.
        widths: of the material's codes.

    Returns:
        float32 (N, C), and the deviations.
    """
    if source.symmetric and source.widths <= widths:
        return source.f(wi, wo), deviations_of(source, widths=widths)
    count = len(wi)
    wi, wo = (np.concatenate(sides) for sides in zip((wi, wo), asymmetry_pairs(), strict=True))
    once, noisy = source.f(wi, wo), source.noisy
    pairs = (
        mirrored_pairs(wi, wo)
        if widths == 2
        else list(rotated_pairs(wi, wo, 2 if source.isotropic else AZIMUTHS))
    )
    if not noisy:
        tests = pairs[1:3] if widths == 2 else [isotropy_test_pairs(wi, wo)]
        if all(nearly_equal(once, source.f(*pair)) for pair in [*tests, (wo, wi)]):
            return once[:count], deviations_of(source, widths=widths)
        noisy = not np.array_equal(once, source.f(wi, wo))
    # (exchange, azimuth, N, C)
    every = np.stack([[source.f(a, b) for a, b in pairs], [source.f(b, a) for a, b in pairs]])
    isotropic = every.mean(axis=1)
    mean = isotropic.mean(axis=0)
    if noisy:
        return mean[:count], deviations_of(source, None, None, widths)
    anisotropy = _error(every[..., count:, :], isotropic[:, None, count:])
    reciprocity = _error(isotropic[:, count:], mean[count:])
    return mean[:count], deviations_of(source, anisotropy, reciprocity, widths)


def is_anisotropic(source: Source) -> bool:
    """Whether a source differs by E > `KEPT_ANISOTROPY` from its mean over the azimuth.

    A noisy source counts as isotropic unless its `widths` are 2.
    """
    if source.symmetric or source.isotropic or source.noisy:
        return source.widths == 2
    none = asymmetry_pairs()[0][:0]
    _, deviations = symmetrise(source, none, none)
    return (deviations.anisotropy or 0.0) > KEPT_ANISOTROPY


def mirrored_pairs(wi: np.ndarray, wo: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """A pair (N, 3), and its mirror images at the xz plane, at the yz plane, and at both."""
    signs = np.array([[1, 1, 1], [1, -1, 1], [-1, 1, 1], [-1, -1, 1]], np.float32)
    return [(wi * sign, wo * sign) for sign in signs]


def rotated_pairs(
    wi: np.ndarray, wo: np.ndarray, count: int
) -> Iterator[tuple[np.ndarray, np.ndarray]]:
    """A pair (N, 3) rotated about the normal by `count` angles; every second one is mirrored.

    Half a turn or mirroring leaves most anisotropic BRDFs the same. No angle counts twice for them:
    modulo half a turn, an odd number of rotations is evenly spaced, and the mirrored pairs are
    rotated by the angles halfway between.

    count: 1, for the pair itself, or twice an odd number.
    """
    if count == 1:
        yield wi, wo
        return
    odd = count // 2
    for k in range(odd):
        for mirrored in (False, True):
            turn = (k + 0.25 * mirrored) / odd
            yield rotated(wi, turn, mirrored), rotated(wo, turn, mirrored)


def isotropy_test_pairs(wi: np.ndarray, wo: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """The pairs (N, 3) at which an isotropic BRDF has the same values as at wi, wo."""
    return rotated(wi, TEST_ROTATION, True), rotated(wo, TEST_ROTATION, True)


def nearly_equal(a: np.ndarray, b: np.ndarray) -> bool:
    """Whether two arrays of values [1/sr] are equal up to rounding."""
    tolerance = RELATIVE_TOLERANCE * np.maximum(a, b) + ABSOLUTE_TOLERANCE
    return bool((np.abs(a - b) <= tolerance).all())


@functools.cache
def asymmetry_pairs() -> tuple[np.ndarray, np.ndarray]:
    """Two fixed arrays (`ASYMMETRY_PAIRS`, 3), high enough for an exact half vector."""
    return cosine_pairs(np.random.default_rng(0), ASYMMETRY_PAIRS, lowest_cosine=0.01)


def deviations_of(
    source: Source, anisotropy: float | None = 0.0, reciprocity: float | None = 0.0, widths: int = 1
) -> Deviations:
    """The deviations of a source of this asymmetry."""
    shares = source.transmitted, source.mirrored
    return Deviations(anisotropy, reciprocity, *shares, source.textured, widths)


def _error(f: np.ndarray, mean: np.ndarray) -> float:
    """E of values (..., `ASYMMETRY_PAIRS`, C) against their mean (broadcast), over all channels."""
    wi, wo = asymmetry_pairs()
    weight = energy_weight(wi[:, 2], wo[:, 2])[:, None]
    energy = float((np.broadcast_to(mean, f.shape) * weight).sum())
    return float((np.abs(f - mean) * weight).sum()) / energy if energy > 0 else 0.0
