"""Random parameters of single surfaces: widths, indices of refraction and bottoms.

`urushi.data.distribution` makes stacks of them.
"""

import numpy as np

from urushi.checks import MIN_ALPHA, TRAINED_WIDTH_RATIO, Widths
from urushi.walk.bottoms import LOBE_PARAMETERS


def draw_alpha(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """U(0.01^(1/3), 1)^3, in [0.01, 1]."""
    return np.maximum(rng.uniform(MIN_ALPHA ** (1 / 3), 1.0, shape) ** 3, MIN_ALPHA)


def draw_widths(rng: np.random.Generator, mean: np.ndarray) -> Widths:
    """Two widths in [0.01, 1] of this geometric mean, see `distribution.Anisotropic`."""
    limit = np.log(TRAINED_WIDTH_RATIO)
    quotient = np.exp(rng.uniform(-limit, limit, np.shape(mean)))
    quotient = np.where(rng.random(np.shape(mean)) < 0.2, 1.0, quotient)
    root = np.sqrt(quotient)
    return Widths(np.clip(mean * root, MIN_ALPHA, 1.0), np.clip(mean / root, MIN_ALPHA, 1.0))


def common_eta(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """U(1.05, 2), as in Table 2."""
    return rng.uniform(1.05, 2.0, shape)


def whole_eta(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """Indices in [0.5, 3], those of coats on air or on a denser or thinner medium.

    55 % are U(1.05, 2), 10 % U(2, 3), 25 % U(0.5, 0.96). In the last 10 %, |eta - 1| is log-uniform
    in [0.004, 0.05], on either side of 1.
    """
    near = np.exp(rng.uniform(np.log(0.004), np.log(0.05), shape))
    near = 1 + np.where(rng.integers(2, size=shape) == 0, -near, near)
    parts = (
        rng.uniform(1.05, 2.0, shape),
        rng.uniform(2.0, 3.0, shape),
        rng.uniform(0.5, 0.96, shape),
        near,
    )
    which = rng.choice(len(parts), shape, p=(0.55, 0.1, 0.25, 0.1))
    return np.choose(which, parts)


def low_eta(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    """U(0.5, 0.96): every interface is to a thinner medium, with total reflection from above."""
    return rng.uniform(0.5, 0.96, shape)


#: Indices of refraction by name: functions of a generator and a shape.
DRAW_ETA = {"common": common_eta, "whole": whole_eta, "low": low_eta}


def mixture(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """A diffuse term, a GGX lobe and a Beckmann lobe, with weights that add up to at most one.

    A quarter are Beckmann conductors alone. A quarter are plastics of either distribution (a lobe
    of low R0 = U(0.02, 0.1) over a diffuse term). In the other half all three weights are
    Dirichlet(1/2) times U(0, 1)^(1/3), so that one or two of them often dominate.
    """
    kind = rng.integers(4, size=n)
    weights = rng.dirichlet((0.5, 0.5, 0.5), n) * rng.uniform(0, 1, (n, 1)) ** (1 / 3)
    r0 = rng.uniform(0.0, 1.0, (n, 2))
    which = rng.integers(2, size=n)
    plastic = np.stack([rng.uniform(0, 0.9, n), which == 0, which == 1], axis=-1)
    weights = np.where((kind == 0)[:, None], [0.0, 0.0, 1.0], weights)
    weights = np.where((kind == 1)[:, None], plastic, weights)
    r0 = np.where((kind == 1)[:, None], rng.uniform(0.02, 0.1, (n, 1)), r0)
    return {
        "diffuse": weights[:, 0],
        "ggx_weight": weights[:, 1],
        "ggx_alpha": draw_alpha(rng, n),
        "ggx_r0": r0[:, 0],
        "beckmann_weight": weights[:, 2],
        "beckmann_alpha": draw_alpha(rng, n),
        "beckmann_r0": r0[:, 1],
    }


def measured_like(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """Columns of "measured_like" bottoms: a quarter like paints, a quarter like metals.

    Paints have the same R0 = U(0.02, 0.1) in both lobes, and weights of the lobes that add up to 1.
    Metals have a diffuse term below 0.01. The other half has weights Dirichlet(1/2) times
    U(0, 1)^(1/3) and R0 = U(0, 1). The exponents gamma are log-uniform in [0.6, 8] without 0.97 to
    1.03. The least width is 0.004 for gamma = 2. The width of masking is alpha^U(0.4, 1).
    """
    kind = rng.integers(4, size=n)[:, None]
    weights = rng.dirichlet((0.5, 0.5, 0.5), n) * rng.uniform(0, 1, (n, 1)) ** (1 / 3)
    split = rng.uniform(0, 1, (n, 1))
    paint = np.concatenate([rng.uniform(0, 0.9, (n, 1)) ** 2, split, 1 - split], axis=1)
    dark = 0.01 * rng.uniform(0, 1, (n, 1)) ** 2
    brightness = rng.uniform(0.2, 1, (n, 1))
    metal = np.concatenate([dark, split * brightness, (1 - split) * brightness], axis=1)
    weights = np.select([kind == 0, kind == 1], [paint, metal], weights)
    r0 = np.where(kind == 0, rng.uniform(0.02, 0.1, (n, 1)), rng.uniform(0, 1, (n, 2)))
    gamma = np.exp(rng.uniform(np.log(0.6), np.log(8.0), (n, 2)))
    gamma = np.where(np.abs(gamma - 1) < 0.03, 1.03, gamma)
    alpha = rng.uniform(0.004 ** (1 / 3), 0.98 ** (1 / 3), (n, 2)) ** 3
    alpha = np.clip(alpha, 0.004 * np.sqrt(gamma / 2), 0.98)
    masking = alpha ** rng.uniform(0.4, 1.0, (n, 2))
    columns = {
        "diffuse": weights[:, 0],
        "roughness": rng.uniform(0, 1, n),
        "sheen": np.where(rng.integers(2, size=n) == 0, 0.0, rng.uniform(0, 1, n) ** 3),
    }
    for k in (0, 1):
        lobe = (weights[:, 1 + k], alpha[:, k], gamma[:, k], r0[:, k], masking[:, k])
        columns |= {f"{name}_{k + 1}": x for name, x in zip(LOBE_PARAMETERS, lobe, strict=True)}
    return columns


#: Columns of bottoms by kind: functions of a generator and a number of bottoms.
DRAW_BOTTOM = {
    "conductor": lambda rng, n: {"alpha": draw_alpha(rng, n), "r0": rng.uniform(0.0, 1.0, n)},
    "conductor_complex": lambda rng, n: {
        "alpha": draw_alpha(rng, n),
        "eta": rng.uniform(0.05, 3.5, n),
        "k": rng.uniform(0.5, 8.0, n),
    },
    "diffuse": lambda rng, n: {"reflectance": rng.uniform(0.0, 1.0, n)},
    "mixture": mixture,
    "measured_like": measured_like,
}
