"""Inputs of the layering network: normalised features of a coat."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core.namespace import Namespace, arrays, stacked


class Normalisation:
    """Normalisation of features, by which they have about mean 0 and variance 1."""

    def __init__(self, table: Sequence[tuple[str, float, float]]) -> None:
        """table: name, mean and scale of every column."""
        self.constants = [(mean, 1.0 / scale) for _, mean, scale in table]

    def __call__(self, columns: Sequence[Any]) -> Any:
        """Normalised features (..., C) of columns (...), which broadcast against each other."""
        features = stacked(columns)
        means, factors = np.array(self.constants, features.real.dtype).T  # the columns' precision
        return (features - means) * factors


#: Features of a coat: formula, mean, scale. Of its interface, whose index may be above or below
#: one, with s = (eta - 1) / (eta + 1); and of its medium, with m = 1 - exp(-sigma_t). All terms
#: with albedo or g vanish with sigma_t.
COAT_TABLE = (
    ("ln alpha", -1.45, 1.3),
    ("alpha", 0.4, 0.3),
    ("eta", 1.4, 0.4),
    ("s", 0.13, 0.17),
    ("s^2", 0.047, 0.04),
    ("ln(s^2 + 1e-4)", -4.0, 1.6),
    ("max(1 - eta^2, 0)", 0.08, 0.2),
    ("m", 0.75, 0.33),
    ("exp(-4 sigma_t)", 0.14, 0.33),
    ("ln(1 + sigma_t)", 1.2, 0.67),
    ("m albedo", 0.5, 0.33),
    ("m sqrt(1 - albedo)", 0.37, 0.29),
    ("m g", 0.0, 0.29),
    ("m g^2", 0.09, 0.17),
    ("m albedo g", 0.0, 0.21),
    ("ln(1 + sigma_t albedo)", 0.9, 0.63),
    ("ln(1 + sigma_t (1 - albedo))", 0.52, 0.54),
    ("ln(1 + sigma_t (1 - albedo g))", 1.15, 0.69),
)

#: Normalisations of the features, of one GGX width or two, and their numbers. The second width has
#: the first two features once more.
COATS = {1: Normalisation(COAT_TABLE), 2: Normalisation(COAT_TABLE + COAT_TABLE[:2])}
COAT_FEATURES = {widths: len(own.constants) for widths, own in COATS.items()}


def coat_features(alpha: Any, eta: Any, albedo: Any, sigma_t: Any, g: Any) -> Any:
    """Return the features (..., C) of coats; the parameters broadcast against each other.

    alpha in [0.01, 1], or two `Widths`, eta in [0.5, 3], albedo in [0, 1], sigma_t >= 0, g in
    (-1, 1). C is `COAT_FEATURES` of one width or two. For sigma_t = 0 the features do not depend on
    albedo and g.
    """
    widths = 1 + isinstance(alpha, Widths)
    return COATS[widths](coat_columns(alpha, eta, albedo, sigma_t, g, arrays(eta)))


def coat_columns(
    alpha: Any, eta: Any, albedo: Any, sigma_t: Any, g: Any, xp: Namespace
) -> list[Any]:
    """The features of a coat before normalisation, by `COATS`."""
    named = xp.named
    along, *across = (alpha.u, alpha.v) if isinstance(alpha, Widths) else (alpha,)
    s = named("s", (eta - 1.0) / (eta + 1.0))
    s2 = named("s2", s * s)
    m, absorbed = named("m", 1.0 - xp.exp(-sigma_t)), 1.0 - albedo
    m_albedo, m_g = m * albedo, m * g
    columns = [
        xp.log(along),
        along,
        eta,
        s,
        s2,
        xp.log(s2 + 1e-4),
        xp.positive(1.0 - eta * eta),
        m,
        xp.exp(-4.0 * sigma_t),
        xp.log1p(sigma_t),
        m_albedo,
        m * xp.sqrt(absorbed),
        m_g,
        m_g * g,
        m_albedo * g,
        xp.log1p(sigma_t * albedo),
        xp.log1p(sigma_t * absorbed),
        xp.log1p(sigma_t * (1.0 - albedo * g)),
    ]
    return columns + [column for width in across for column in (xp.log(width), width)]
