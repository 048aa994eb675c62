"""BSDF and directional albedo of stacks by random walks: the reference.

The option `energy_compensation` of coats gives light back that a rough surface loses. A surface
scatters light once; light that meets a second facet is lost. L(w) is the share that the topmost
surface loses over a white base (`core.anisotropic_albedos.surface_loss`). The lobe
C L(wi) L(wo) / (pi L_mean) gives it back (Kulla and Conty 2017). C is the colour of coat and
bottom. A mirror loses less than a Lambertian base: its light leaves the coat as steeply as it
entered. The plugins have the same lobe (`mitsuba.plugins.compensation`).
"""

import functools
from collections.abc import Callable
from dataclasses import replace
from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import CoatParameters, Widths
from urushi.core import anisotropic_albedos, appearance
from urushi.core.appearance import coated_color
from urushi.core.backend import backend, shared
from urushi.core.microfacet import of_widths, pair
from urushi.core.mixture import Mixture
from urushi.core.namespace import NUMPY
from urushi.errors import ParameterError
from urushi.walk import slabs, walk
from urushi.walk.bottoms import Bottom
from urushi.walk.bottoms.dielectric import Dielectric, Reflector
from urushi.walk.interface import flip
from urushi.walk.monte_carlo import average, per_channel
from urushi.walk.stack import Coat, Stack
from urushi.walk.table import StackTable, TableLayers


def simulate(
    stack: Stack,
    wi: npt.ArrayLike,
    wo: npt.ArrayLike,
    *,
    walks: int = 4096,
    seed: int = 0,
    progress: bool = True,
    mode: str = "radiance",
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the BSDF of a layered stack without bias, by position-free Monte Carlo.

    Deep lossless media are within 0.1 %, see `urushi.walk.medium`.

    Args:
        stack: what to simulate (`urushi.coat`, `urushi.slab`).
        wi, wo: (N, 3) unit vectors pointing away from the surface; z is the normal. Those of slabs
            may be on either side.
        walks: random walks per pair and channel, at least 2.
        seed: any integer; the same seed gives the same numbers on the same backend.
        progress: show a progress bar (on a terminal only).
        mode: Mitsuba's `TransportMode`, "radiance" or "importance". They differ for light that
            slabs transmit to another index. f of importance integrates over wo's cosine to the
            share of the power from wi that is transmitted. It is eta^2 times f of radiance, with
            eta the index on wo's side over the index on wi's side.

    Returns:
        (f, se): float32 (N, 3) each, the BSDF [1/sr] without cosine and its standard error. Both
        are zero where a direction is at the horizon or, of stacks over opaque bottoms, below it.
        Without the delta of unscattered light through a slab whose indices are all 1, of the share
        exp(-sigma_t / cos).

    Raises:
        ParameterError: wrong shapes, directions that are not unit vectors, too few walks, another
            mode.
        PlatformError: no libLLVM that Dr.Jit can use.

    Source: Guo, Hasan & Zhao 2018, section 4: one walk with next-event estimation and MIS.
    """
    if not isinstance(stack, Stack):
        raise ParameterError(
            f"simulate needs a Stack from urushi.coat(...), not {type(stack).__name__}"
        )
    if mode not in ("radiance", "importance"):
        raise ParameterError(f"mode is {mode!r}; give 'radiance' or 'importance'")
    wi, wo = checks.directions(wi, wo)
    options: dict[str, Any] = dict(walks=walks, seed=seed, progress=progress)
    if not isinstance(stack.bottom, Dielectric):
        f, se = per_channel(stack, (wi, wo), functools.partial(walk_pairs, **options))
        if stack.coats[0].energy_compensation:
            f += Compensation.of_stack(stack).f(wi, wo).astype(np.float32)
        return f, se

    f, se = per_channel(
        stack, (wi, wo), lambda table, row, *w: average(table, row, w, slabs.estimate, **options)
    )
    if mode == "radiance":
        side = np.sign(wi[:, 2:]) - np.sign(wo[:, 2:])  # 2: down through the slab, -2: up
        f, se = (x * stack.index**-side for x in (f, se))
    return f.astype(np.float32), se.astype(np.float32)


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
    """Estimate f of row[i] of `table` at (wi[i], wo[i]), float32 (M, 3), for every i.

    The other arguments are those of `monte_carlo.average`.

    Returns:
        (f, se): float32 (M,), mean [1/sr] and standard error.
    """
    options: dict[str, Any] = dict(walks=walks, seed=seed, progress=progress)
    mean, se = average(table, row, (wi, wo), walk.estimate, **options)
    mean += top_reflection(table, row, wi, wo)
    return mean.astype(np.float32), se.astype(np.float32)


def top_reflection(
    table: StackTable, row: np.ndarray, wi: np.ndarray, wo: np.ndarray
) -> np.ndarray:
    """The reflection of the topmost interface, (M,) [1/sr]."""
    if not len(row):
        return np.zeros(0, np.float32)
    device = backend()
    rows = shared(device.UInt32, row.astype(np.uint32))
    wi, wo = (device.Array3f(np.ascontiguousarray(w.T)) for w in (wi, wo))
    return walk.top_reflection(TableLayers(device, table, rows), wi, wo).numpy()


def albedo(
    stack: Stack,
    wi: npt.ArrayLike,
    *,
    walks: int = 1 << 16,
    seed: int = 0,
    transmitted: bool = False,
) -> tuple[np.ndarray, np.ndarray]:
    """Estimate the share of the light from `wi` that a stack reflects or transmits, from its BSDF.

    Every walk has its own wo, drawn from a mixture of the top interface's lobe, a wider lobe and a
    cosine lobe. Where light is transmitted, the lobes lie about its refracted direction.

    Args:
        stack: what to simulate (`urushi.coat`, `urushi.slab`).
        wi: (N, 3) unit vectors; those of slabs may be on either side.
        walks: random walks per direction and channel, at least 2.
        seed: any integer; the same seed gives the same numbers on the same backend.
        transmitted: estimate the light that a slab transmits, not the light that is reflected.

    Returns:
        (albedo, se): float64 (N, 3); zero where wi is at the horizon or, of stacks over opaque
        bottoms, below it. Without the delta that `simulate` leaves out.

    Raises:
        ParameterError: wrong shapes, directions that are not unit vectors, too few walks, or an
            opaque bottom and `transmitted`.
        PlatformError: no libLLVM that Dr.Jit can use.
    """
    is_slab = isinstance(stack.bottom, Dielectric)
    if transmitted and not is_slab:
        raise ParameterError(
            f"a {type(stack.bottom).__name__} bottom is opaque; only urushi.slab(...) transmits"
        )
    walk_one = functools.partial(_slab_albedo, transmitted) if is_slab else _reflected
    wi = checks.direction(wi, "wi")
    found, se = per_channel(
        stack,
        (wi,),
        lambda table, row, wi: average(table, row, (wi,), walk_one, walks=walks, seed=seed),
    )
    if stack.coats[0].energy_compensation:
        found += np.where(wi[:, 2:] > 0, Compensation.of_stack(stack).albedo(wi), 0)
    return found, se


def _slab_albedo(transmitted: bool, coats: Any, lowest: Reflector, wi: Any, rng: Any) -> Any:
    """One estimate of the integral of a slab's f cos over wo, on one side."""
    turned = (wi.z > 0) == transmitted
    layers = slabs.Slab(coats, lowest, turned)
    wi = dr.select(turned, flip(wi), wi)
    return _reflected(layers, layers.bottom, wi, rng, layers.entry if transmitted else None)


def _reflected(layers: Any, bottom: Bottom, wi: Any, rng: Any, entry: Bottom | None = None) -> Any:
    """One estimate of the integral of f cos over wo above the horizon; entry: wi is below it."""
    about, lit, narrow = wi, wi.z > 0, 1.0
    if entry is not None:  # two refractions of glass are about half as wide as a reflection
        about, lit, narrow = slabs.straight(wi, 1 / layers.index), wi.z < 0, 0.5
    alpha, _ = layers.interface(dr.uint32_array_t(type(wi.z))(0))
    # Light that was scattered below leaves in a lobe wider than the top interface's. The root of
    # alpha lies between a narrow lobe and the cosine lobe.
    widths = [of_widths(width, alpha) for width in (lambda alpha: narrow * alpha, dr.sqrt)]
    mixture = Mixture([1 / 3] * 3, widths)
    choice, *u = rng.next_float32(), rng.next_float32(), rng.next_float32()
    wo = mixture.sample(about, choice, u)
    pdf = mixture.pdf(about, wo)
    valid = lit & (wo.z > 0) & (pdf > 0)
    f = walk.estimate(layers, bottom, wi, wo, rng, active=valid, entry=entry)
    f += walk.top_reflection(layers, wi, wo)
    return dr.select(valid, f * wo.z / pdf, 0)


class Compensation:
    """The lobe of the light that the topmost surface loses."""

    def __init__(self, coat: CoatParameters, below: np.ndarray, f: np.ndarray):
        """The lobe of a coat, whose parameters are () or (C,), over a material.

        below: the material's directional albedo (C,) at the normal.
        f: the material's f (C,) [1/sr] at `appearance.WI` and `WO`; f pi is the part of the albedo
            that is not mirrored.
        """
        mirrored = float(np.clip(1 - np.pi * f.mean() / max(below.mean(), 1e-6), 0, 1))
        self._color = coated_color(coat, below, NUMPY)
        columns = np.broadcast_arrays(*pair(coat.alpha), coat.eta, below)[:3]
        self._losses = [
            anisotropic_albedos.surface_loss(Widths(*map(float, widths)), float(index), mirrored)
            for *widths, index in zip(*columns, strict=True)
        ]

    @classmethod
    def of_stack(cls, stack: Stack) -> "Compensation":
        """The lobe of a stack's topmost coat; walks measure what lies below it."""
        first, *others = stack.coats[1:] or (Coat(eta=1.0),)
        rest = Stack((replace(first, energy_compensation=False), *others), stack.bottom)
        below = albedo(rest, [[0.0, 0.0, 1.0]], walks=1 << 14)[0][0]
        f, _ = simulate(rest, [appearance.WI], [appearance.WO], walks=1 << 14, progress=False)
        return cls(stack.coats[0].parameters, below, f)

    def albedo(self, wi: np.ndarray) -> np.ndarray:
        """What the lobe adds to the directional albedo at unit vectors (N, 3), (N, 3)."""
        return self._color * self._by_channel(lambda lost, _: lost(wi))

    def f(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The lobe [1/sr] (N, 3) for unit vectors (N, 3); 0 below the horizon."""
        lobes = self._by_channel(lambda lost, mean: lost(wi) * lost(wo) / max(np.pi * mean, 1e-5))
        above = (wi[:, 2:] > 0) & (wo[:, 2:] > 0)
        return np.where(above, self._color * lobes, 0)

    def _by_channel(self, values: Callable[..., np.ndarray]) -> np.ndarray:
        """Values (N, C) of a function of a loss and its mean; those of equal channels once."""
        found = {loss: values(*loss) for loss in set(self._losses)}
        return np.stack([found[loss] for loss in self._losses], axis=-1)
