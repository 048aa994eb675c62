"""Directional albedo of a stack: the hemispherical integral of the walk's f cos."""

from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.physics import microfacet
from urushi.physics.frame import reflect, square_to_cosine_hemisphere
from urushi.reference import walk
from urushi.reference.bottoms import Bottom
from urushi.reference.launch import average, per_channel
from urushi.reference.stack import Stack


def albedo(
    stack: Stack, wi: npt.ArrayLike, *, walks: int = 1 << 16, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate which fraction of the light from `wi` a stack reflects, through its BRDF.

    Every walk goes to another wo, drawn from a mixture of the top interface's lobe, a wider one
    and a cosine lobe.

    Args:
        stack: what to simulate (`urushi.coat`).
        wi: (N, 3) unit vectors.
        walks: random walks per direction and channel, at least 2.
        seed: any integer; the same seed gives the same numbers on the same backend.

    Returns:
        (albedo, se): float64 (N, 3); zero where wi is at or below the horizon.

    Raises:
        ParameterError: wrong shapes, directions that are not unit vectors, too few walks.
        PlatformError: no libLLVM that Dr.Jit can use.
    """
    return per_channel(
        stack,
        (checks.direction(wi, "wi"),),
        lambda table, row, wi: average(table, row, (wi,), _reflected, walks=walks, seed=seed),
    )


def _reflected(layers: Any, bottom: Bottom, wi: Any, rng: Any) -> Any:
    """One estimate of the integral of f cos over wo."""
    wo, pdf = _sample_outgoing(layers, wi, rng)
    valid = (wi.z > 0) & (wo.z > 0) & (pdf > 0)
    f = walk.estimate(layers, bottom, wi, wo, rng, type(wi.z), valid)
    f += walk.top_reflection(layers, wi, wo)
    return dr.select(valid, f * wo.z / pdf, 0)


def _sample_outgoing(layers: Any, wi: Any, rng: Any) -> tuple[Any, Any]:
    """Draw wo by one of three techniques; returns (wo, density [1/sr] of the mixture)."""
    choice, u1, u2 = rng.next_float32(), rng.next_float32(), rng.next_float32()
    alpha, _ = layers.interface(dr.uint32_array_t(type(wi.z))(0))
    # Light that scattered below comes back in a lobe wider than the top's; the root spans the gap
    # between a sharp top and the cosine lobe.
    widths = alpha, dr.sqrt(alpha)
    width = dr.select(choice < 1 / 3, *widths)
    m = microfacet.sample_visible_normal(wi, width, u1, u2)
    cosine = square_to_cosine_hemisphere(type(wi), u1, u2)
    wo = dr.select(choice < 2 / 3, reflect(wi, m), cosine)
    m = dr.normalize(wi + wo)
    pdf = dr.maximum(wo.z, 0) * dr.inv_pi
    for width in widths:
        pdf += microfacet.visible_normal_pdf(wi, m, width) / (4 * dr.dot(wi, m))
    return wo, pdf / 3
