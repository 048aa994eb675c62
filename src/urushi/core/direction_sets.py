"""Random sets of direction pairs for training and for the errors E and P.

Every set is drawn in double precision from a generator that the caller seeds, and returned as
float32 unit vectors wi, wo of shape (n, 3), z the normal, both above the horizon.
"""

import functools
from collections.abc import Callable

import numpy as np

from urushi.core.directions import directions_at_tangent, turned
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.errors import ParameterError

#: Least cosine of training pairs. Pairs below it carry no energy, and the feature
#: 0.5 ln(cos_i cos_o) of a few pairs would outweigh all other pairs.
LOWEST_COSINE = 0.004

#: Range of tan(theta_h) in training pairs, wider than that of the error P.
HALF_ANGLE_RANGE = (5e-4, 8.0)

#: Share of the training pairs of that range that are near the mirror direction instead.
MIRROR_SHARE = 1 / 8

#: Largest tan(theta_h) of the pairs near the mirror direction; half of them have exactly zero.
MIRROR_TANGENT = 1e-3

#: Range of tan(theta_h) for the error P.
METRIC_HALF_ANGLE_RANGE = (1e-3, 4.0)

Pairs = tuple[np.ndarray, np.ndarray]


def _tangents(u: np.ndarray, low: float, high: float, mirror_share: float) -> np.ndarray:
    """tan(theta_h) of uniform numbers u: log-uniform, or for a share near the mirror direction."""
    tangent = np.exp(low + (high - low) * (u - mirror_share) / (1 - mirror_share))
    if mirror_share == 0:
        return tangent
    mirrored = MIRROR_TANGENT * np.maximum(0.0, 2 * u / mirror_share - 1)
    return np.where(u < mirror_share, mirrored, tangent)


def half_angle_pairs(
    rng: np.random.Generator,
    n: int,
    *,
    tangents: tuple[float, float] = METRIC_HALF_ANGLE_RANGE,
    lowest_cosine: float = 0.0,
    mirror_share: float = 0.0,
    slopes: bool = False,
) -> Pairs:
    """Pairs with ln tan(theta_h) uniform about difference directions over the whole hemisphere.

    The half vector h lies in the xz plane with ln tan(theta_h) uniform in ln `tangents`; about it
    wi has the difference angles theta_d uniform in [0, pi/2) and phi_d uniform (Rusinkiewicz 1998);
    wo is the mirror image of wi about h. Pairs with a cosine below `lowest_cosine` are drawn
    again, so that the accepted pairs have this density, cut off there.

    A share of the pairs, `mirror_share` in [0, 1), is near the mirror direction instead:
    tan(theta_h) is zero for half of them, and uniform in [0, `MIRROR_TANGENT`] for the others.

    slopes: whether half vectors have every azimuth, for anisotropic BRDFs. It is uniform for half
        of the pairs. The half vectors of the others have independent slopes h_x / h_z and
        h_y / h_z, log-uniform in `tangents`, so that there are pairs near both axes of a lobe
        whatever its two widths are.
    """
    low, high = np.log(tangents)

    def draw(count: int) -> Pairs:
        u = rng.random((5 if slopes else 3, count))
        tangent, turn = _tangents(u[0], low, high, mirror_share), np.zeros(count)
        if slopes:
            across = np.exp(low + (high - low) * u[3])
            radial = (u[4] < 0.5) | (u[0] < mirror_share)
            turn = np.where(radial, 2 * np.pi * u[3], np.arctan2(across, tangent))
            turn += np.where(radial, 0.0, 0.5 * np.pi * np.floor(8 * (u[4] - 0.5)))
            tangent = np.where(radial, tangent, np.hypot(tangent, across))
        wi, wo = directions_at_tangent(tangent, 0.5 * np.pi * u[1], 2 * np.pi * u[2])
        return (turned(wi, turn), turned(wo, turn)) if slopes else (wi, wo)

    return _accepted(draw, n, lowest_cosine)


def _independent(
    cosine_i: Callable[[np.ndarray], np.ndarray],
    cosine_o: Callable[[np.ndarray], np.ndarray],
    rng: np.random.Generator,
    n: int,
    *,
    lowest_cosine: float = 0.0,
) -> Pairs:
    """Pairs of independent directions; the cosine of each is a function of uniform numbers."""

    def draw(count: int) -> Pairs:
        cosines = cosine_i, cosine_o
        wi, wo = (_direction(f(rng.random(count)), rng.random(count)) for f in cosines)
        return wi, wo

    return _accepted(draw, n, lowest_cosine)


#: `half_angle_pairs` for anisotropic BRDFs.
slope_pairs = functools.partial(half_angle_pairs, slopes=True)

#: Pairs of independent directions, both of density cos(theta) / pi, as for the error E.
cosine_pairs = functools.partial(_independent, np.sqrt, np.sqrt)

#: Pairs of independent directions, both uniform over the hemisphere.
uniform_pairs = functools.partial(_independent, np.positive, np.positive)

#: ln cos(theta_i) uniform down to the least cosine of training pairs, wo of cosine density.
_one_grazing = functools.partial(_independent, lambda u: LOWEST_COSINE**u, np.sqrt)


def training_pairs(
    rng: np.random.Generator,
    n: int,
    first: Callable[..., Pairs] = half_angle_pairs,
    last: Callable[..., Pairs] = uniform_pairs,
) -> Pairs:
    """Half of the pairs log-uniform in the half angle, a quarter cosine, a quarter uniform.

    They are interleaved with a period of four, so that any run of pairs has the same mixture:
    `first`, cosine, `first`, `last`.

    Of the pairs that are log-uniform in the half angle, `MIRROR_SHARE` are at the exact mirror
    direction or within `MIRROR_TANGENT` of it. Without them a network extrapolates below the range
    of tan(theta_h), and f of the sharpest lobes was wrong by 6 to 14 % at their peaks. Exact
    mirror directions fix the value there, and the pairs beside them join it to the range.

    n: number of pairs, a multiple of 4.
    """
    half_angles = {"tangents": HALF_ANGLE_RANGE, "mirror_share": MIRROR_SHARE}
    parts = (
        first(rng, n // 2, lowest_cosine=LOWEST_COSINE, **half_angles),
        cosine_pairs(rng, n // 4, lowest_cosine=LOWEST_COSINE),
        last(rng, n // 4, lowest_cosine=LOWEST_COSINE),
    )
    wi, wo = np.empty((n, 3), np.float32), np.empty((n, 3), np.float32)
    places = slice(0, None, 2), slice(1, None, 4), slice(3, None, 4)
    for (part_wi, part_wo), place in zip(parts, places, strict=True):
        wi[place], wo[place] = part_wi, part_wo
    return wi, wo


#: As `training_pairs`, but in the last quarter wi has a log-uniform cosine, mostly grazing, so that
#: the pairs sample the directional albedo of every wi.
grazing_pairs = functools.partial(training_pairs, last=_one_grazing)

#: As `training_pairs`, with the half vectors of `slope_pairs`.
anisotropic_pairs = functools.partial(training_pairs, first=slope_pairs)

#: Sets by name whose pairs may be divided among stacks; data specifications use the names.
DIRECTION_SETS: dict[str, Callable[[np.random.Generator, int], Pairs]] = {
    "training": training_pairs,
    "grazing": grazing_pairs,
    "cosine": cosine_pairs,
    "half_angle": half_angle_pairs,
    "anisotropic": anisotropic_pairs,
    "slopes": slope_pairs,
}


def stratified_pairs(rng: np.random.Generator, n: int) -> Pairs:
    """One pair in each of n = k^4 strata: k intervals for theta and phi of both directions.

    All four angles are uniform in their stratum (Fan et al. 2022, section 4.1), so that pairs are
    denser towards the normal than in solid angle.
    """
    k = round(n**0.25)
    cells = np.stack(np.unravel_index(np.arange(n), (k, k, k, k)))
    u = (cells + rng.random((4, n))) / k
    wi, wo = (_direction(np.cos(0.5 * np.pi * u[i]), u[i + 1]).astype(np.float32) for i in (0, 2))
    return wi, wo


def probed_pairs(rng: np.random.Generator, n: int) -> Pairs:
    """The `PROBES` probe pairs, then training pairs."""
    return _joined([probe_pairs(PROBES), training_pairs(rng, n - PROBES)])


#: Further sets by name; every stack has each of them complete.
COMPLETE_SETS = {"stratified": stratified_pairs, "probed": probed_pairs}


def check_set(name: str, pairs: int, where: str) -> None:
    """Raise a ParameterError that begins with `where` if a set cannot have this number of pairs."""
    names = DIRECTION_SETS | COMPLETE_SETS
    if name not in names:
        raise ParameterError(f"{where} has directions = {name!r}; choose one of {', '.join(names)}")
    if name == "stratified" and round(pairs**0.25) ** 4 != pairs:
        raise ParameterError(f"{where} has {pairs} {name} pairs; give a fourth power, such as 625")
    if name == "probed" and pairs <= PROBES:
        raise ParameterError(
            f"{where} has {pairs} {name} pairs; give more than the {PROBES} probe pairs"
        )


def draw_pairs(name: str, rng: np.random.Generator, stacks: int, pairs: int) -> Pairs:
    """The pairs of several stacks, one after the other: (stacks * pairs, 3) twice."""
    if name not in COMPLETE_SETS:
        return DIRECTION_SETS[name](rng, stacks * pairs)
    return _joined([COMPLETE_SETS[name](rng, pairs) for _ in range(stacks)])


def _joined(parts: list[Pairs]) -> Pairs:
    return np.concatenate([wi for wi, _ in parts]), np.concatenate([wo for _, wo in parts])


def _accepted(draw: Callable[[int], Pairs], n: int, lowest_cosine: float) -> Pairs:
    """Draw until `n` pairs have both cosines above `lowest_cosine`, in the order drawn."""
    wi, wo = np.empty((0, 3), np.float32), np.empty((0, 3), np.float32)
    while len(wi) < n:
        new_wi, new_wo = (direction.astype(np.float32) for direction in draw(n))
        keep = np.minimum(new_wi[:, 2], new_wo[:, 2]) > lowest_cosine
        wi, wo = np.concatenate([wi, new_wi[keep]]), np.concatenate([wo, new_wo[keep]])
    return wi[:n], wo[:n]


def _direction(cosine: np.ndarray, u: np.ndarray) -> np.ndarray:
    """Unit vectors (n, 3) of the given cosine, at azimuth 2 pi u."""
    sine = np.sqrt(np.maximum(0.0, 1 - cosine * cosine))
    return np.stack([sine * np.cos(2 * np.pi * u), sine * np.sin(2 * np.pi * u), cosine], -1)
