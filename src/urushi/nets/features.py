"""What the networks see of a pair of directions and of a coat, normalised by fixed constants."""

from typing import Any

#: Cosines to the normal are raised to this: f is taken as constant closer to the horizon.
MIN_COSINE = 5e-3

#: Of each feature of a pair of directions: its name, and the mean and scale that bring it to about
#: mean zero and variance one (pairs half spread in log half angle, half over the hemisphere).
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
DIRECTION_FEATURES = len(DIRECTION_TABLE)

#: eta - 1 below this counts as this in the logarithm: networks are trained above it, and a
#: vanishing interface must not send them where they know nothing.
MIN_INDEX_STEP = 0.04

#: Interfaces of a lower eta - 1 vanish with its square, as what they reflect does.
PRESENT_STEP = 0.05

#: The least width of a microfacet lobe: a mirror, as far as light sources resolve it.
MIN_ALPHA = 0.01

#: The same for a coat; m = 1 - exp(-sigma_t). Whatever holds albedo or g vanishes with sigma_t.
COAT_TABLE = (
    ("ln alpha", -1.45, 1.3),
    ("alpha", 0.4, 0.3),
    ("ln(eta - 1)", -0.85, 0.7),
    ("eta - 1", 0.52, 0.27),
    ("((eta - 1) / (eta + 1))^2", 0.047, 0.034),
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
COAT_INPUTS = len(COAT_TABLE)
#: Columns of `coat_features`: the network's inputs and the coat's presence.
COAT_FEATURES = COAT_INPUTS + 1


def _normalised(columns: list[Any], table: tuple[tuple[str, float, float], ...]) -> Any:
    xp = columns[0].__array_namespace__()
    scaled = [
        (column - mean) * (1.0 / scale)
        for column, (_, mean, scale) in zip(columns, table, strict=True)
    ]
    return xp.stack(xp.broadcast_arrays(*scaled), axis=-1)


def direction_features(wi: Any, wo: Any) -> Any:
    """Return the features (..., 8) of unit vectors wi, wo (..., 3), z the normal.

    Exchanging wi and wo gives the same bits, because only commutative sums, products and minima
    join the two: this makes the decoder reciprocal by construction. All angles come from the sum
    of the vectors without normalising it (theta_h: half vector to normal; theta_d: half vector to
    either direction; Rusinkiewicz 1998), so that small half angles keep their digits in float32.
    Finite for every pair; cosines below `MIN_COSINE` count as that.
    """
    xp = wi.__array_namespace__()
    cos_i = xp.maximum(wi[..., 2], MIN_COSINE)
    cos_o = xp.maximum(wo[..., 2], MIN_COSINE)
    x = wi[..., 0] + wo[..., 0]
    y = wi[..., 1] + wo[..., 1]
    z = cos_i + cos_o
    across = x * x + y * y  # |h|^2 sin^2 theta_h, h = wi + wo
    squared = across + z * z
    length = xp.sqrt(squared)  # 2 cos theta_d for unit vectors
    cos_d = xp.minimum(0.5 * length, 1.0)
    opposite = 1.0 - cos_d
    opposite2 = opposite * opposite
    columns = [
        xp.log(across / (z * z) + 1e-6),
        xp.sqrt(xp.sqrt(across / squared)),
        z / length,
        cos_d,
        opposite2 * opposite2 * opposite,
        0.5 * xp.log(cos_i * cos_o),
        xp.log(z),
        xp.minimum(cos_i, cos_o),
    ]
    return _normalised(columns, DIRECTION_TABLE)


def coat_features(alpha: Any, eta: Any, albedo: Any, sigma_t: Any, g: Any) -> Any:
    """Return the features (..., 16 + 1) of coats; the parameters broadcast against each other.

    alpha in [0.01, 1], eta in (1, 3], albedo in [0, 1], sigma_t >= 0, g in (-1, 1). A medium of
    sigma_t = 0 gives the same features whatever its albedo and g.

    The last is no input but the coat's presence in [0, 1], a factor of what it changes: 0 only
    where there is neither an index step nor a medium nor, as rough facets mask each other whatever
    their index, more than the least roughness. It is above 0.6 wherever eta > 1.05.
    """
    xp = alpha.__array_namespace__()
    above = eta - 1.0
    ratio = above / (eta + 1.0)
    m = 1.0 - xp.exp(-sigma_t)
    columns = [
        xp.log(alpha),
        alpha,
        xp.log(xp.maximum(above, MIN_INDEX_STEP)),
        above,
        ratio * ratio,
        m,
        xp.exp(-4.0 * sigma_t),
        xp.log1p(sigma_t),
        m * albedo,
        m * xp.sqrt(1.0 - albedo),
        m * g,
        m * g * g,
        m * albedo * g,
        xp.log1p(sigma_t * albedo),
        xp.log1p(sigma_t * (1.0 - albedo)),
        xp.log1p(sigma_t * (1.0 - albedo * g)),
    ]
    step = above * xp.minimum(above * (1.0 / PRESENT_STEP), 1.0)
    presence = 1.0 - xp.exp(-20.0 * step - 4.0 * sigma_t - 10.0 * (alpha - MIN_ALPHA))
    features = _normalised(columns, COAT_TABLE)
    presence = xp.broadcast_to(presence[..., None], (*features.shape[:-1], 1))
    return xp.concat([features, presence], axis=-1)
