"""How the bottoms' parameters are drawn: over the whole domain, or mostly at its edges."""

from collections.abc import Callable, Mapping

import numpy as np

from urushi.nets.features import MIN_ALPHA
from urushi.reference.measured_like import LOBE_PARAMETERS

#: Columns of a table by the parameters' names.
Draw = Callable[[np.random.Generator, int], dict[str, np.ndarray]]


def alpha(rng: np.random.Generator, shape: int | tuple[int, ...]) -> np.ndarray:
    return np.maximum(rng.uniform(MIN_ALPHA ** (1 / 3), 1.0, shape) ** 3, MIN_ALPHA)


def _mixture(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """A diffuse term, a GGX and a Beckmann lobe, of weights that add up to one or less.

    A quarter each are bare Beckmann conductors and plastics of either distribution (a lobe of low
    R0 = U(0.02, 0.1) over a diffuse term); in the other half all three weights are Dirichlet(1/2)
    times U(0, 1)^(1/3), so that one or two of them often rule.
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
        "ggx_alpha": alpha(rng, n),
        "ggx_r0": r0[:, 0],
        "beckmann_weight": weights[:, 2],
        "beckmann_alpha": alpha(rng, n),
        "beckmann_r0": r0[:, 1],
    }


def _measured_like(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """`reference.measured_like`: a quarter like paints and plastics, a quarter like metals.

    Paints: both lobes with one R0 = U(0.02, 0.1) and weights that add up to 1; metals: a diffuse
    term below 0.01. The other half has weights Dirichlet(1/2) times U(0, 1)^(1/3) and R0 =
    U(0, 1). Exponents are log-uniform in [0.6, 8] (without 0.97 to 1.03), widths down to 0.004
    for gamma = 2, masking alpha^U(0.4, 1).
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


#: By kind of bottom: from a generator and a number n, its parameters by name, float64 (n,).
UNIFORM: Mapping[str, Draw] = {
    "conductor": lambda rng, n: {"alpha": alpha(rng, n), "r0": rng.uniform(0.0, 1.0, n)},
    "conductor_complex": lambda rng, n: {
        "alpha": alpha(rng, n),
        "eta": rng.uniform(0.05, 3.5, n),
        "k": rng.uniform(0.5, 8.0, n),
    },
    "diffuse": lambda rng, n: {"reflectance": rng.uniform(0.0, 1.0, n)},
    "dielectric": lambda rng, n: {"alpha": alpha(rng, n), "eta": rng.uniform(1.05, 2.0, n)},
    "mixture": _mixture,
    "measured_like": _measured_like,
}


def log_uniform(
    rng: np.random.Generator, low: float, high: float, shape: int | tuple[int, ...]
) -> np.ndarray:
    """Numbers whose logarithm is uniform between those of `low` and `high`."""
    return np.exp(rng.uniform(np.log(low), np.log(high), shape))


def _edge_alpha(rng: np.random.Generator, n: int) -> np.ndarray:
    return np.maximum(log_uniform(rng, MIN_ALPHA, 1.0, n), MIN_ALPHA)


def _edge_share(rng: np.random.Generator, n: int) -> np.ndarray:
    """Reflectances in (0, 1): half nearly black, half nearly white."""
    small = log_uniform(rng, 1e-3, 1.0, n)
    return np.where(rng.integers(2, size=n) == 0, small, 1 - small)


def _edge_mixture(rng: np.random.Generator, n: int) -> dict[str, np.ndarray]:
    """`_mixture` with more of narrow lobes: half are plastics, smooth ones mostly."""
    columns = _mixture(rng, n)
    ggx = rng.integers(2, size=n) == 0
    plastic = rng.integers(2, size=n) == 0
    r0 = rng.uniform(0.02, 0.1, n)
    values = {
        "diffuse": 0.9 * _edge_share(rng, n),
        "ggx_weight": ggx.astype(float),
        "beckmann_weight": 1.0 - ggx,
        "ggx_r0": r0,
        "beckmann_r0": r0,
    }
    for name, value in values.items():
        columns[name] = np.where(plastic, value, columns[name])
    return columns | {name: _edge_alpha(rng, n) for name in ("ggx_alpha", "beckmann_alpha")}


#: The same with logarithmic parameters: narrow lobes, nearly black and vanishing reflectors.
EDGES: Mapping[str, Draw] = {
    "conductor": lambda rng, n: {"alpha": _edge_alpha(rng, n), "r0": _edge_share(rng, n)},
    "conductor_complex": lambda rng, n: {
        **UNIFORM["conductor_complex"](rng, n),
        "alpha": _edge_alpha(rng, n),
    },
    "diffuse": lambda rng, n: {"reflectance": _edge_share(rng, n)},
    "dielectric": lambda rng, n: {
        "alpha": _edge_alpha(rng, n),
        "eta": 1 + log_uniform(rng, 0.05, 1.0, n),
    },
    "mixture": _edge_mixture,
}
