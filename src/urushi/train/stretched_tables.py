"""Training data of two GGX widths by light transport.

A stack is a bottom with at most one coat. Both levels have values at coarse nodes of the stretched
coordinates (`core.stretched`), at a few azimuths of the stretched half vector for every node. These
alone are what the basis is fitted to. Further random coats lie over the codes of all levels in this
basis: the layering network learns from them.
"""

import functools
from collections.abc import Sequence
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core import table
from urushi.core.directions import turned
from urushi.core.namespace import NUMPY, Components
from urushi.core.probe_pairs import ANISOTROPIC_PROBES, pair_measure, probe_pairs
from urushi.core.stretched import stretched
from urushi.material.coated_values import coated_g
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.nets import weights
from urushi.nets.code_fit import log_stretch
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.mlp import Params
from urushi.nets.networks import Architecture
from urushi.nets.transmittance import remainder
from urushi.train import distribution
from urushi.train.distribution import bottom_lobes
from urushi.walk.table import StackTable

#: Bottoms of stacks, with their shares. Mixtures have GGX lobes.
SHARES_OF_TWO = {
    "conductor": 0.3,
    "conductor_complex": 0.15,
    "dielectric": 0.12,
    "diffuse": 0.13,
    "mixture": 0.3,
}

#: Coarse nodes of u, v and w, and azimuths of the stretched half vector at each.
NODES, TURNS = (33, 17, 8), 2

#: The coat (6,) of a bare bottom.
NONE = 1.0, 1.0, 0.0, 0.0, 0.0, 1.0


class Nodes(NamedTuple):
    """Pairs at the azimuths T and nodes P."""

    pairs: tuple[np.ndarray, np.ndarray]  # float32 (T, P, 3)
    measure: np.ndarray  # float32 (T, P) shares in integrals over pairs of cosine density
    factors: np.ndarray  # float32 (`core.stretched.FACTORS`, T, P)


def nodes_of(stretch: float, seed: Sequence[int]) -> Nodes:
    """The nodes of a material with ln s = stretch.

    The azimuths are random, one in each of T parts of the quadrant. The measure is the solid angles
    of a cell of nodes times both cosines.
    """
    rng, axes = np.random.default_rng(seed), [np.linspace(0, 1, count) for count in NODES]
    u, v, w = (x.ravel() for x in np.meshgrid(*axes, indexing="ij"))
    psi = (np.arange(TURNS)[:, None] + rng.random((len(u), TURNS)).T) * (0.5 * np.pi / TURNS)
    mirror = np.where(rng.random((len(u), TURNS)).T < 0.5, -1, 1)
    s, tangent = np.exp(stretch), np.sqrt(_tan2(u))
    x, y = tangent * np.cos(psi) / s, tangent * np.sin(psi) * s
    tan2 = x * x + y * y
    sides, half = [], table.log_tangent(tan2, NUMPY)
    for side in table.node_directions(half, *np.broadcast_arrays(v, w, psi)[:2]):
        side[..., 1] *= mirror
        side[..., 2] = np.maximum(side[..., 2], table.MIN_COSINE)
        side /= np.linalg.norm(side, axis=-1, keepdims=True)
        sides.append(turned(side, np.arctan2(y, x)).astype(np.float32))
    steps = [0.5 / (count - 1) for count in NODES]
    (low_u, high_u), (low_v, high_v), ends = (
        (np.maximum(x - h, 0), np.minimum(x + h, 1)) for x, h in zip((u, v, w), steps, strict=True)
    )
    cos_h, cos_d = 1 / np.sqrt(1 + tan2), 1 - v * v
    both = np.sqrt((1 - cos_h * cos_h) * (1 - cos_d * cos_d))
    reach = np.minimum(cos_h * cos_d / np.maximum(both, 1e-12), 1)
    azimuths = [np.arccos((1 - (1 - w) ** 2) * reach) for w in ends]
    measure = (_tan2(high_u) - np.where(low_u > 0, _tan2(low_u), 0)) * cos_h**3
    measure *= (1 - low_v * low_v) ** 2 - (1 - high_v * high_v) ** 2
    measure *= np.maximum(azimuths[0] - azimuths[1], 1e-9) * sides[0][..., 2] * sides[1][..., 2]
    both, apart = (
        Components(*np.moveaxis(x.astype(float), -1, 0))
        for x in (sides[0] + sides[1], sides[0] - sides[1])
    )
    around = stretched(both, apart, s * s, NUMPY)[1]
    shares = (measure / measure.sum()).astype(np.float32)
    return Nodes((sides[0], sides[1]), shares, np.stack(around).astype(np.float32))


def _tan2(u: np.ndarray) -> np.ndarray:
    return np.maximum(table.squared_tangent(u), 1e-9)


def levels(probes: int, seed: int, number: int) -> list[dict[str, Any]]:
    """The rows of one stack: arrays as of `tables.TableStore` without "over" and "coated", and

    - probes: float32 (N,), ln g of `nets.transmittance` at the probe pairs;
    - stretch: float32, ln s.

    "table" is ln g at the azimuths and nodes, one after another, and "coat" has six numbers.
    """
    rng = np.random.default_rng([seed, number])
    stack = distribution.draw_stack(rng, SHARES_OF_TWO, most=1)
    bottom, lobe = draw_bottom(rng, stack)

    def row(level: int, coat: np.ndarray, lobe: np.ndarray, rest: Any) -> dict[str, Any]:
        """rest: from directions (N, 3) to g (N, 1)."""
        probed = rest(*probe_pairs(probes, 2)).T
        stretch = log_stretch(probed, pair_measure(probes))[0]
        pairs = (w.reshape(-1, 3) for w in nodes_of(stretch, [number, level]).pairs)
        values = logs(rest(*pairs)[:, 0]).astype(np.float16)
        own = row_of(stack, number, level, coat, lobe, values)
        return own | {"probes": logs(probed[0]), "stretch": stretch}

    def bare(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return remainder(bottom.f(wi, wo)[:, 0], lobe, wi, wo)[:, None]

    rows = [row(0, np.array(NONE, np.float32), lobe, bare)]
    for coat in distribution.with_two_widths(rng, distribution.coats_of(stack)):  # at most one
        own = CoatParameters.of_columns(coat.astype(float))
        top = lobes.of_coat(*CoatParameters.of_columns(coat)[:2])
        rows.append(row(1, coat, top, functools.partial(coated_g, Substrate.of(bottom), own)))
    return rows


def row_of(
    stack: StackTable, number: int, level: int, coat: np.ndarray, lobe: np.ndarray, values: Any
) -> dict[str, Any]:
    """The row of a level of a stack with this number, by names; values: of the table."""
    return {
        "table": values,
        "lobe": lobe,
        "stack": np.int32(number),
        "kind": np.int32(list(distribution.SHARES).index(stack.kind)),
        "level": np.int32(level),
        "coat": coat.astype(np.float32),
    }


def logs(f: np.ndarray) -> np.ndarray:
    """ln f float32 (...) of values [1/sr], at least `MIN_LOG`."""
    return np.log(np.maximum(f, np.exp(table.MIN_LOG))).astype(np.float32)


def draw_bottom(rng: np.random.Generator, stack: StackTable) -> tuple[Reflector, np.ndarray]:
    """The bottom of a stack with two widths in place of each, and its lobe (7,)."""
    known = {name: float(column[0]) for name, column in stack.bottom.items()}
    if stack.kind == "mixture":
        factors = [
            [known[f"{k}_{x}"] for x in ("alpha", "weight", "r0")] for k in ("ggx", "beckmann")
        ]
        parts = np.array([[alpha, w * r0, w, 0, 1.5, 0] for alpha, w, r0 in factors])
    else:
        parts = bottom_lobes(stack.kind, stack.bottom)
    parts = distribution.with_two_widths(rng, parts, distribution.LEAST_WIDTH)
    white = known.get("diffuse", known.get("reflectance", 0)) / np.pi
    bottom = Reflector.of_logs(logs(np.full((*table.SHAPE, 1), white)), parts[None], np.ones(1))
    if stack.kind != "mixture":
        return bottom, parts[0]
    return bottom, fit_lobes(bottom.f(*probe_pairs(ANISOTROPIC_PROBES, 2)).T, 2)[0]


def coats_over(
    arch: Architecture, params: Params, spec: Any, task: tuple[int, np.ndarray, np.ndarray]
) -> dict[str, np.ndarray]:
    """Random coats over codes: "over" (R, C, 6) and "coated" as of `tables.TableStore`.

    spec: the `TableSpec`. task: number of the shard, "stack" (R,) and "bottom" (R, L) of its rows.
    """
    shard, stack, bottom = task
    rng, model = np.random.default_rng([spec.seed, shard]), weights.Model.of(arch, params, {})
    pairs = model.networks.pairs()
    over = np.stack([distribution.draw_coats_of_two(rng, spec.coats) for _ in bottom])
    coated = np.empty((len(bottom), spec.coats, len(pairs[0])), np.float32)
    for code, coats, result in zip(bottom, over, coated, strict=True):
        below = Material(np.tile(code, (spec.coats, 1)), model)
        coat = CoatParameters.of_columns(coats.T.astype(float))
        result[:] = logs(coated_g(below, coat, *pairs)).T
    return {"stack": stack, "bottom": bottom, "over": over, "coated": coated}
