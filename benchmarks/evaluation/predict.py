"""Materials of held-out stacks, encoded and layered by the public operations."""

from dataclasses import replace

import numpy as np
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Samples

from urushi.checks import CoatParameters
from urushi.core.microfacet import of_widths
from urushi.core.probe_pairs import PROBES, probe_pairs
from urushi.core.table import node_pairs, table_of_values
from urushi.material import Material
from urushi.material.layer import layer_material, transported_codes
from urushi.material.source import STACK_WALKS
from urushi.material.values import codes_of_values, material_of_lobes, required_pairs
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import remainder
from urushi.nets.weights import Model
from urushi.train.distribution import bottom_lobes
from urushi.walk import StackTable
from urushi.walk.bottoms import KINDS


def materials(
    model: Model, samples: Samples, encoded: int = 0, *, how: str = "code"
) -> list[Material]:
    """S materials of one channel, see `material`."""
    return split(material(model, samples, encoded, how=how))


def material(model: Model, samples: Samples, encoded: int = 0, *, how: str = "code") -> Material:
    """Encode the bottoms, or lower parts of stacks, and layer the coats above them.

    Args:
        model: the weights.
        samples: S stacks.
        encoded: number of lowest coats that are encoded with the bottom, from simulated values.
        how: as of `samples.Row`.

    Returns:
        A material of S channels.
    """
    found = _lower(model, samples, encoded, exact=how != "network")
    for index in reversed(range(samples.table.coats - encoded)):
        coat = coats_at(samples.table, index)
        if how == "code" and index == 0:
            return Material(transported_codes(coat, found), model)
        found = layer_material(coat, found, fast=how == "network")
    return found if how == "table" else replace(found, table=None)


def _lower(model: Model, samples: Samples, encoded: int, exact: bool) -> Material:
    """The encoded bottoms or lower parts; exact: whether bottoms have tables of their values."""
    # Without coats the values are exact and cheap, so the bottoms' albedo is computed as well.
    pairs = model.networks.pairs() if encoded else required_pairs(None, model, table=False)
    values, table = lower_values(samples, encoded, *pairs), samples.table
    if encoded == 0 and KINDS[table.kind].family.bare:
        return material_of_lobes(_lobes(model, samples, encoded), model, len(values))
    known = encoded or KINDS[table.kind].family.fresnel_numbers(table.bottom) is not None
    lobe = _lobes(model, samples, encoded)[:, None] if known else None
    # Each stack by itself: the channels of a material share the stretch of two widths.
    found = Material(codes_of_values(values[:, None], model, lobe)[:, 0], model)
    if encoded or not exact or model.widths == 2:
        return found
    wi, wo = node_pairs()
    lobe = found.latents[:, None, : model.arch.lobe]
    rest = remainder(lower_values(samples, 0, wi, wo), lobe, wi, wo)
    return replace(found, table=table_of_values(rest.T), beside_lobe=True)


def _lobes(model: Model, samples: Samples, encoded: int) -> np.ndarray:
    """The known lobes (S, L') of the encoded BRDFs: of the topmost coat or of the bottom."""
    table = samples.table
    if not encoded:
        return bottom_lobes(table.kind, table.bottom, model.widths)
    coat = coats_at(table, table.coats - encoded)
    return lobes.of_coat(coat.alpha, coat.eta)


def split(whole: Material) -> list[Material]:
    """Each channel of a material as a material with one channel."""
    tables = [None] * whole.channels
    if whole.table is not None:
        tables = [whole.table[..., c : c + 1] for c in range(whole.channels)]
    return [
        replace(whole, latents=code[None], table=table, coating=None)
        for code, table in zip(whole.latents, tables, strict=True)
    ]


def evaluate(materials: list, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Values float32 (S, M) [1/sr] of S materials, each at its own pairs (S, M, 3)."""
    return np.stack([m.f(*pairs)[:, 0] for m, *pairs in zip(materials, wi, wo, strict=True)])


def coats_at(table: StackTable, index: int) -> CoatParameters:
    """The coats (S,) of a place in the stacks, 0 the topmost."""
    alpha, *others = (getattr(table, name) for name in CoatParameters._fields)
    # Single precision may round the smallest width down.
    width = of_widths(lambda x: np.maximum(x[:, index].astype(np.float64), 0.01), alpha)
    return CoatParameters(width, *(x[:, index] for x in others))


def lower_values(samples: Samples, coats: int, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """Values (S, P) [1/sr] of the lowest `coats` coats over the bottoms at pairs (P, 3)."""
    if coats in samples.probed and np.array_equal(probe_pairs(PROBES), (wi, wo)):
        return samples.probed[coats]
    lower = sampling.part(samples.table, lowest=coats)
    wi, wo = (np.broadcast_to(w, (len(lower), *w.shape)) for w in (wi, wo))
    return sampling.walk_all(lower, wi, wo, STACK_WALKS, 0)[0]
