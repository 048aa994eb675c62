"""The fuzz: the reflection of a layer of fibres, a linearly transformed cosine.

Source: Zeltner, Burley and Chiang 2022, Practical multiple-scattering sheen using linearly
transformed cosines, with the rational fits to their tables that MaterialX evaluates.
"""

import math
from typing import Any

#: Least roughness that the fits cover.
MIN_ROUGHNESS = 0.01


def albedo(cosine: Any, roughness: Any, xp: Any) -> Any:
    """Share of the light that the fuzz reflects, for a colour of one.

    Args:
        cosine: of the direction from which it is seen, in [0, 1].
        roughness: fuzz_roughness.
        xp: the module of the arrays' functions, NumPy or drjit.
    """
    x, y = cosine, xp.clip(roughness, MIN_ROUGHNESS, 1)
    s = y * (0.0206607 + 1.58491 * y) / (0.0379424 + y * (1.32227 + y))
    m = y * (-0.193854 + y * (-1.14885 + y * (1.7932 - 0.95943 * y * y))) / (0.046391 + y)
    o = y * (0.000654023 + y * (-0.0207818 + 0.119681 * y)) / (1.26264 + y * (-1.92021 + y))
    t = (x - m) / s
    value = xp.exp(-0.5 * t * t) / (s * math.sqrt(2 * math.pi)) + o
    return xp.clip(value, 0, 1)


def transform(cosine: Any, roughness: Any, xp: Any) -> tuple[Any, Any]:
    """Numbers a, c of the inverse transform [[a, 0, b], [0, a, 0], [0, 0, 1]]; b is c times the
    sine of the direction from which the fuzz is seen."""
    x, y = cosine, xp.clip(roughness, MIN_ROUGHNESS, 1)
    a = (2.58126 * x + 0.813703 * y) * y / (1 + 0.310327 * x * x + 2.60994 * x * y)
    # The fit of b has the factor sqrt(1 - x), the sine over sqrt(1 + x).
    c = (y - 1) * y * y * y / xp.sqrt(1 + x)
    return a, c / (2.54053e-5 + 1.71228 * x - 1.71506 * x * y + 1.34174 * y * y)


def density(cosine: Any, up: Any, across: Any, roughness: Any, xp: Any) -> Any:
    """The lobe over its cosine: a density over the upper hemisphere is `up` times it [1/sr].

    Args:
        cosine: of the given direction.
        up: cosine of the other.
        across: product of both sines and of the cosine between the azimuths. It takes no azimuth,
            which the normal does not have.
        roughness: fuzz_roughness.
        xp: the module of the arrays' functions, NumPy or drjit.
    """
    a, c = transform(cosine, roughness, xp)
    b2 = c * c * (1 - cosine * cosine)
    length2 = a * a * (1 - up * up) + up * (2 * a * c * across + (1 + b2) * up)
    ratio = a / length2
    return ratio * ratio / math.pi
