"""BRDF and directional albedo of stacks by random walks: the reference."""

import functools
from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import Widths
from urushi.core import microfacet
from urushi.core.frame import reflect, square_to_cosine_hemisphere
from urushi.errors import ParameterError
from urushi.walk import walk
from urushi.walk.bottoms import Bottom
from urushi.walk.monte_carlo import average, backend, per_channel
from urushi.walk.stack import Stack
from urushi.walk.table import StackTable, TableLayers


def simulate(
    stack: Stack,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike,
    *,
    walks: int = 4096,
    seed: int = 0,
    progress: bool = True,
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the BRDF of a layered stack without bias, by position-free Monte Carlo.

    Deep lossless media are within 0.1 %, see `urushi.walk.medium`.

    Args:
        stack: what to simulate (`urushi.coat`).
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal.
        walks: random walks per pair and channel, at least 2.
        seed: any integer; the same seed gives the same numbers on the same backend.
        progress: show a progress bar (on a terminal only).

    Returns:
        (f, se): float32 (N, 3) each, the BRDF [1/sr] without cosine and its standard error; both
        are zero where a direction is at or below the horizon.

    Raises:
        ParameterError: wrong shapes, directions that are not unit vectors, too few walks.
        PlatformError: no libLLVM that Dr.Jit can use.

    Source: Guo, Hasan & Zhao 2018, section 4: one walk with next-event estimation and MIS.
    """
    if not isinstance(stack, Stack):
        raise ParameterError(
            f"simulate needs a Stack from urushi.coat(...), not {type(stack).__name__}"
        )
    walk_all = functools.partial(walk_pairs, walks=walks, seed=seed, progress=progress)
    return per_channel(stack, checks.directions(wi, wo), walk_all)


def walk_pairs(
    table: StackTable,
    row: np.ndarray,
    wi: np.ndarray,
    wo: np.ndarray,
    *,
    walks: int,
    seed: int,
    progress: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate f of row[i] of `table` at (wi[i], wo[i]) for every i.

    Args:
        table: S monochrome stacks.
        row: (M,) unsigned integers below S.
        wi, wo: float32 (M, 3) unit vectors.
        walks: random walks per pair, at least 2.
        seed: any integer.
        progress: show a progress bar (on a terminal only).

    Returns:
        (f, se): float32 (M,), mean [1/sr] and standard error.
    """
    mean, se = average(table, row, (wi, wo), _estimate, walks=walks, seed=seed, progress=progress)
    mean += top_reflection(table, row, wi, wo)
    return mean.astype(np.float32), se.astype(np.float32)


def _estimate(layers: Any, bottom: Bottom, wi: Any, wo: Any, rng: Any) -> Any:
    """One walk's f of one channel, without the reflection of the topmost interface."""
    return walk.estimate(layers, bottom, wi, wo, rng, type(wi.z))


def top_reflection(
    table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """The reflection of the topmost interface, (M,) [1/sr]."""
    if not len(row):
        return np.zeros(0, np.float32)
    device = backend()
    rows = device.UInt32(np.ascontiguousarray(row, np.uint32))
    wi, wo = (device.Array3f(np.ascontiguousarray(w.T)) for w in (wi, wo))
    return walk.top_reflection(TableLayers(device, table, rows), wi, wo).numpy()


def albedo(
    stack: Stack, wi: npt.ArrayLike, *, walks: int = 1 << 16, seed: int = 0
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the fraction of the light from `wi` that a stack reflects, from its BRDF.

    Every walk has its own wo, drawn from a mixture of the top interface's lobe, a wider lobe and a
    cosine lobe.

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
    # Light that was scattered below leaves in a lobe wider than the top interface's. The root of
    # alpha lies between a narrow lobe and the cosine lobe.
    wider = alpha.map(dr.sqrt) if isinstance(alpha, Widths) else dr.sqrt(alpha)
    widths = alpha, wider
    width = dr.select(choice < 1 / 3, *widths)
    m = microfacet.sample_visible_normal(wi, width, u1, u2)
    cosine = square_to_cosine_hemisphere(type(wi), u1, u2)
    wo = dr.select(choice < 2 / 3, reflect(wi, m), cosine)
    m = dr.normalize(wi + wo)
    pdf = dr.maximum(wo.z, 0) * dr.inv_pi
    for width in widths:
        pdf += microfacet.visible_normal_pdf(wi, m, width) / (4 * dr.dot(wi, m))
    return wo, pdf / 3
