"""Inputs of the networks: normalised features of a pair of directions and of a coat."""

from collections.abc import Sequence
from typing import Any

import numpy as np

from urushi.checks import Widths
from urushi.core.namespace import Namespace, arrays, components
from urushi.core.table import MIN_COSINE


def stacked(columns: Sequence[Any]) -> Any:
    """Columns (...), which broadcast against each other, as an array (..., C)."""
    xp = columns[0].__array_namespace__()
    if xp is not np:
        return xp.stack(xp.broadcast_arrays(*columns), axis=-1)
    # For a few rows, the calls of `np.stack` would take longer than all that they stack.
    shape = np.broadcast(*columns).shape
    result = np.empty((*shape, len(columns)), np.result_type(*columns))
    for place, column in enumerate(columns):
        result[..., place] = column
    return result


class Normalisation:
    """Means and scales of features, by which they have about mean 0 and variance 1."""

    def __init__(self, table: Sequence[tuple[Any, float, float]]):
        """table: name, mean and scale of every column."""
        _, means, scales = zip(*table, strict=True)
        self._means, self._factors = np.array(means), 1.0 / np.array(scales)
        self._of_type: dict[Any, tuple[np.ndarray, np.ndarray]] = {}

    def __call__(self, columns: Sequence[Any]) -> Any:
        """Normalised features (..., C) of columns (...), which broadcast against each other."""
        features = stacked(columns)
        dtype = features.real.dtype  # the precision of the columns
        if dtype not in self._of_type:
            self._of_type[dtype] = self._means.astype(dtype), self._factors.astype(dtype)
        means, factors = self._of_type[dtype]
        features -= means  # in place where arrays can be changed
        features *= factors
        return features

    def each(self, columns: Sequence[Any]) -> list[Any]:
        """Columns of any kind, normalised in the same way, as a list."""
        constants = zip(columns, self._means.tolist(), self._factors.tolist(), strict=True)
        return [(column - mean) * factor for column, mean, factor in constants]


#: Features of a pair of directions: formula, mean, scale. Normalisation by mean and scale gives
#: about mean 0 and variance 1 over pairs that are spread half in the logarithm of the half angle
#: and half over the hemisphere.
DIRECTION_TABLE = (
    ("ln(tan^2 theta_h + 1e-6)", -3.2, 4.6),
    ("(sin^2 theta_h)^(1/4)", 0.55, 0.34),
    ("cos theta_h", 0.8, 0.24),
    ("cos theta_d", 0.73, 0.24),
    ("(1 - cos theta_d)^5", 0.04, 0.2),
    ("1/2 ln(cos_i cos_o)", -0.78, 0.65),
    ("ln(cos_i + cos_o)", 0.0, 0.56),
    ("min(cos_i, cos_o)", 0.47, 0.3),
)

#: Further features of a pair of directions for anisotropic BRDFs, all of them the same for the
#: mirror images of a pair at the xz or the yz plane. x and y are components of unit vectors, h of
#: the half vector.
AZIMUTH_TABLE = (
    ("ln(h_x^2 / h_z^2 + 1e-6)", -5.0, 4.3),
    ("ln(h_y^2 / h_z^2 + 1e-6)", -5.0, 4.3),
    ("ln(x_i^2 + x_o^2 + 1e-3)", -0.9, 1.3),
    ("ln(y_i^2 + y_o^2 + 1e-3)", -0.9, 1.3),
    ("x_i x_o", -0.1, 0.3),
    ("y_i y_o", -0.1, 0.3),
)

#: Number of features of a pair of directions, for networks of one GGX width or two.
DIRECTION_FEATURES = {1: len(DIRECTION_TABLE), 2: len(DIRECTION_TABLE + AZIMUTH_TABLE)}

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

#: Number of features of a coat, for networks of one GGX width or two; the second width has the
#: first two features once more.
COAT_FEATURES = {1: len(COAT_TABLE), 2: len(COAT_TABLE) + 2}


#: Normalisations of the features, for networks of one GGX width or two.
DIRECTIONS = {1: Normalisation(DIRECTION_TABLE), 2: Normalisation(DIRECTION_TABLE + AZIMUTH_TABLE)}
COATS = {1: Normalisation(COAT_TABLE), 2: Normalisation(COAT_TABLE + COAT_TABLE[:2])}


def direction_features(wi: Any, wo: Any, widths: int = 1) -> Any:
    """Return the features (..., D) of unit vectors wi, wo (..., 3), z the normal.

    D is `DIRECTION_FEATURES` of `widths`. With widths = 1 the features are the same if both
    directions are turned about the normal.

    wi and wo enter only through commutative operations (sum, product, minimum). Exchanging them
    gives the same bits, which makes the decoder reciprocal by construction. All angles are computed
    from wi + wo without normalising it (theta_h: half vector to normal; theta_d: half vector to
    either direction; Rusinkiewicz 1998), so that small half angles keep their digits in float32.
    The features are finite for every pair; cosines are clamped to at least `MIN_COSINE`.
    """
    columns = direction_columns(components(wi), components(wo), widths, arrays(wi))
    return DIRECTIONS[widths](columns)


def direction_columns(wi: Any, wo: Any, widths: int, xp: Namespace) -> list[Any]:
    """The features of two directions before normalisation, by `DIRECTIONS`."""
    named = xp.named
    cos_i = named("cos_i", xp.maximum(wi.z, MIN_COSINE))
    cos_o = named("cos_o", xp.maximum(wo.z, MIN_COSINE))
    x, y = named("sum_x", wi.x + wo.x), named("sum_y", wi.y + wo.y)
    z = named("sum_z", cos_i + cos_o)
    x2, y2, z2 = x * x, y * y, named("sum_z2", z * z)
    across = named("sum_xy2", x2 + y2)  # |h|^2 sin^2 theta_h, h = wi + wo
    squared = named("sum2", across + z2)
    length = named("sum_size", xp.sqrt(squared))  # 2 cos theta_d for unit vectors
    cos_d = named("cos_d", xp.minimum(0.5 * length, 1.0))
    opposite = named("opposite", 1.0 - cos_d)
    opposite2 = named("opposite2", opposite * opposite)
    columns = [
        xp.log(across / z2 + 1e-6),
        xp.safe_sqrt(xp.safe_sqrt(across / squared)),
        z / length,
        cos_d,
        opposite2 * opposite2 * opposite,
        0.5 * xp.log(cos_i * cos_o),
        xp.log(z),
        xp.minimum(cos_i, cos_o),
    ]
    if widths == 2:
        columns += [
            xp.log(x2 / z2 + 1e-6),
            xp.log(y2 / z2 + 1e-6),
            xp.log(wi.x * wi.x + wo.x * wo.x + 1e-3),
            xp.log(wi.y * wi.y + wo.y * wo.y + 1e-3),
            wi.x * wo.x,
            wi.y * wo.y,
        ]
    return columns


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
