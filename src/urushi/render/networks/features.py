"""What the decoder and the proposal see of directions: the Dr.Jit twin of `nets.features`."""

import drjit as dr

from urushi.nets.features import DIRECTION_TABLE, MIN_COSINE


def direction_features(wi, wo):
    """The decoder's eight features of unit vectors wi and wo (z the normal), as a list.

    Exchanging wi and wo gives the same bits, see `nets.features.direction_features`.
    """
    cos_i, cos_o = dr.maximum(wi.z, MIN_COSINE), dr.maximum(wo.z, MIN_COSINE)
    x, y, z = wi.x + wo.x, wi.y + wo.y, cos_i + cos_o
    across = x * x + y * y
    squared = across + z * z
    length = dr.sqrt(squared)
    cos_d = dr.minimum(0.5 * length, 1)
    opposite = 1 - cos_d
    opposite2 = opposite * opposite
    columns = [
        dr.log(across / (z * z) + 1e-6),
        dr.sqrt(dr.sqrt(across / squared)),
        z / length,
        cos_d,
        opposite2 * opposite2 * opposite,
        0.5 * dr.log(cos_i * cos_o),
        dr.log(z),
        dr.minimum(cos_i, cos_o),
    ]
    return [
        (column - mean) * (1 / scale)
        for column, (_, mean, scale) in zip(columns, DIRECTION_TABLE, strict=True)
    ]


def sampler_features(cos_i):
    """The proposal network's two features of the cosine of wi, as a list."""
    raised = dr.maximum(cos_i, MIN_COSINE)
    return [(raised - 0.5) * 3, dr.log(raised) + 1]
