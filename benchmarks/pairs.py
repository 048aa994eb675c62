"""Random pairs of directions whose half vectors have slopes of all sizes, for the error P."""

import functools

import numpy as np

from urushi.core.direction_sets import Pairs, accepted
from urushi.core.directions import directions_at_tangent, turned

#: Range of tan(theta_h) for the error P.
HALF_ANGLE_RANGE = (1e-3, 4.0)


def half_angle_pairs(rng: np.random.Generator, n: int, *, slopes: bool = False) -> Pairs:
    """Pairs with ln tan(theta_h) uniform about difference directions over the whole hemisphere.

    The half vector h lies in the xz plane, tan(theta_h) log-uniform in `HALF_ANGLE_RANGE`; about it
    wi has the difference angles theta_d uniform in [0, pi/2) and phi_d uniform (Rusinkiewicz 1998);
    wo is the mirror image of wi about h. Pairs below the horizon are drawn again, so that the
    accepted pairs have this density, cut off there.

    slopes: whether half vectors have every azimuth, for anisotropic BRDFs. It is uniform for half
        of the pairs. The half vectors of the others have independent slopes h_x / h_z and
        h_y / h_z, log-uniform in this range, so that there are pairs near both axes of a lobe
        whatever its two widths are.
    """
    low, high = np.log(HALF_ANGLE_RANGE)

    def draw(count: int) -> Pairs:
        u = rng.random((5 if slopes else 3, count))
        tangent, turn = np.exp(low + (high - low) * u[0]), np.zeros(count)
        if slopes:
            across = np.exp(low + (high - low) * u[3])
            radial = u[4] < 0.5
            turn = np.where(radial, 2 * np.pi * u[3], np.arctan2(across, tangent))
            turn += np.where(radial, 0.0, 0.5 * np.pi * np.floor(8 * (u[4] - 0.5)))
            tangent = np.where(radial, tangent, np.hypot(tangent, across))
        wi, wo = directions_at_tangent(tangent, 0.5 * np.pi * u[1], 2 * np.pi * u[2])
        return (turned(wi, turn), turned(wo, turn)) if slopes else (wi, wo)

    return accepted(draw, n, 0.0)


#: `half_angle_pairs` for anisotropic BRDFs.
slope_pairs = functools.partial(half_angle_pairs, slopes=True)
