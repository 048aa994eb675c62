"""The medium of a coat from what people see of it: its colour, its body and its thickness.

A medium is described by `albedo` and `sigma_t`, or by the following in place of both. A clear dye
absorbs; pigment, the body of a paint, scatters and absorbs. With T the share of diffuse light that
a layer passes:

    absorption of the dye           a = -1/2 ln(color)                                          (1)
    reduced depth of the pigment    p = 4/3 body / (1 - body)                                   (2)
    similarity parameter            body_color = (1 - s) (1 - 0.139 s) / (1 + 1.17 s)           (3)
    albedo of the pigment           w = (1 - s^2) / (1 - g s^2)                                 (4)
    medium                          sigma_t = thickness (a + p / (1 - w g)),
                                    albedo = w p / (1 - w g) / (a + p / (1 - w g))              (5)

(1) is OpenPBR's coat_color: the share of light that returns to the eye at normal incidence, having
passed the coat twice at thickness 1. (2) is solved from T = 1 / (1 + 3/4 p), the two-stream limit
of a layer that only scatters: `body` is the share of diffuse light that a white pigment keeps from
passing, at thickness 1. (3) is the diffuse reflectance of an infinitely deep medium without an
interface (van de Hulst 1980), so that an opaque body looks like a Lambertian bottom of
`body_color`. (4) and (5) keep the appearance for every g (similarity, ibid.).
"""

from collections.abc import Container, Iterable
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.core.namespace import NUMPY, Namespace
from urushi.errors import ParameterError

#: The parameters of a medium by its appearance, and their defaults: clear. A medium with a
#: `body_color` has a `body` of 1.
LOOK = {"color": 1.0, "body": 0.0, "body_color": 0.8}

#: The parameters that a look replaces.
PHYSICAL = ("albedo", "sigma_t")

#: Path of light through a medium over its depth: from outside and diffuse; and the share of
#: isotropic scattering that turns light back.
REFRACTED, DIFFUSE, BACKWARDS = 1.15, 2.0, 0.5

#: Directions at which pi f estimates what a surface reflects diffusely, away from its mirror lobe.
WI, WO = (0.6, 0.0, 0.8), (0.0, 0.6, 0.8)

#: Least colour: its depth is 6.9, from which nothing returns. Greatest body: its depth is 132.
LEAST_COLOR, MOST_BODY = 1e-6, 0.99


def look_of(given: Container[str], where: str) -> dict[str, float]:
    """`LOOK`, if one of its names is among those that a caller gives; otherwise nothing.

    where: begins errors, for example "the coat's".
    """
    looks = [name for name in LOOK if name in given]
    physical = [name for name in PHYSICAL if name in given]
    if looks and physical:
        raise ParameterError(
            f"{where} {' and '.join(looks)} and {' and '.join(physical)} are both given; give "
            "color, body and body_color, or albedo and sigma_t"
        )
    return LOOK | ({"body": 1.0} if "body_color" in looks else {}) if looks else {}


def optical_depth(color: Any, xp: Namespace = NUMPY) -> Any:
    """The depth of a dye at thickness 1, equation 1, zero or more.

    color: in [0, 1]; below `LEAST_COLOR` it counts as `LEAST_COLOR`.
    """
    return xp.absolute(0.5 * xp.log(xp.clip(color, LEAST_COLOR, 1)))


def medium(look: Iterable[Any], g: Any, xp: Namespace = NUMPY) -> tuple[Any, Any]:
    """Albedo and optical depth of a medium of thickness 1, equations 1 to 5.

    look: color, body and body_color, clipped to [0, 1], and body to at most `MOST_BODY`. g: the
        asymmetry, in (-1, 1). All are numbers or arrays that broadcast.
    """
    color, body, body_color = look
    reflected = xp.named("reflected", xp.clip(body_color, 0, 1))
    opaque = xp.named("opaque", xp.clip(body, 0, MOST_BODY))
    linear = xp.named("linear", 1.139 + 1.17 * reflected)
    s = xp.named("s", (linear - xp.sqrt(linear * linear - 0.556 * (1 - reflected))) / 0.278)
    albedo = xp.named("albedo", (1 - s * s) / (1 - g * s * s))
    pigment = xp.named("pigment", 4 / 3 * opaque / (1 - opaque) / (1 - albedo * g))
    depth = xp.named("depth", optical_depth(color, xp) + pigment)
    return albedo * (pigment / xp.maximum(depth, 1e-6)), depth


def described(
    where: str, *, g: npt.ArrayLike, thickness: npt.ArrayLike, **given: npt.ArrayLike | None
) -> tuple[np.ndarray, np.ndarray]:
    """Checked albedo and optical depth, each () or (3,), of a coat's medium as a caller gives it.

    Args:
        where: begins errors, for example "the coat's".
        g, thickness: of the medium; the thickness is one number.
        given: `PHYSICAL` and `LOOK` by name; None: not given.

    Raises:
        ParameterError: a value is out of range, or both descriptions are given.
    """
    known = {name: value for name, value in given.items() if value is not None}
    scale = checks.thickness(thickness, f"{where} thickness")
    if look := look_of(known, where):
        shares = (checks.share(v, f"{where} {n}") for n, v in (look | known).items())
        albedo, depth = medium(shares, checks.g(g, f"{where} g"))
    else:
        albedo = checks.albedo(known.get("albedo", checks.DEFAULT_COAT.albedo), f"{where} albedo")
        depth = checks.sigma_t(known.get("sigma_t", 0.0), f"{where} sigma_t")
    return albedo, checks.sigma_t(scale * depth, f"{where} thickness times sigma_t")


def coated_albedo(coat: checks.CoatParameters, reflectance: Any, xp: Namespace) -> Any:
    """The share of the light that enters a coat over a Lambertian reflectance and leaves again.

    An estimate for a medium (Kubelka and Munk 1931) under a smooth interface (Saunderson 1942).
    """

    def without_interface(label: str, path: Any) -> Any:
        scattered = coat.sigma_t * coat.albedo
        absorption = xp.named(f"{label}_absorption", path * (coat.sigma_t - scattered))
        scattering = xp.named(f"{label}_scattering", path * BACKWARDS * scattered * (1 - coat.g))
        both = absorption + scattering
        root = xp.named(f"{label}_root", xp.sqrt(absorption * (both + scattering) + 1e-6))
        faint = xp.named(f"{label}_faint", xp.exp(-2 * root))
        decay = xp.named(f"{label}_decay", root * (1 + faint) / (1 - faint))
        divisor = both - reflectance * scattering + decay
        return (scattering - reflectance * (both - decay)) / divisor

    kept_inside = xp.named("kept_inside", xp.maximum(1 - 1 / (coat.eta * coat.eta), 0))
    entering = REFRACTED + (DIFFUSE - REFRACTED) * coat.albedo  # what is scattered is diffuse
    share = (1 - kept_inside) * without_interface("entering", entering)
    return share / (1 - kept_inside * without_interface("diffuse", DIFFUSE))


def coated_color(coat: checks.CoatParameters, reflectance: Any, xp: Namespace) -> Any:
    """Albedo of a coat over a Lambertian reflectance, its surface included, at normal incidence."""
    root = (coat.eta - 1) / (coat.eta + 1)
    f0 = root * root
    return f0 + (1 - f0) * coated_albedo(coat, reflectance, xp)
