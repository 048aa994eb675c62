"""Errors of anisotropic materials against the walk: E and P by group, energy, albedos and sampling.

    python -m benchmarks.quality.anisotropy --out DIR [--stacks 32]

Stacks of width quotients up to 8 along either axis, with Henyey-Greenstein media, of a seed that no
training data have. The reference is kept in DIR and simulated to an error E of about 0.4 %. Three
rows a group: coats by light transport, coats by the layering network, and simulated stacks that are
encoded.
"""

import argparse
from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial
from pathlib import Path

import numpy as np
from benchmarks.evaluation import predict
from benchmarks.evaluation.distributions import anisotropic

import urushi
from urushi.checks import CoatParameters, Widths
from urushi.core import error_metrics
from urushi.core.direction_sets import cosine_pairs, slope_pairs
from urushi.material import Material
from urushi.material.layer import layer_material
from urushi.material.source import STACK_WALKS
from urushi.material.values import material_from_values, material_of_lobes
from urushi.nets import lobe as lobes
from urushi.nets.weights import anisotropic_model
from urushi.train.bottoms import bottom_lobes
from urushi.walk import StackTable, analytic, bottoms, walk_pairs

SEED = 90210

#: Pairs of a stack for E and for P, and walks of a pair.
E_PAIRS, P_PAIRS, WALKS = 160, 96, 20480

#: Cosines and azimuths of the directional albedos, samples of one, and walks of a sample.
ALBEDO_COSINES, ALBEDO_AZIMUTHS = (0.95, 0.6, 0.3), np.linspace(0, np.pi / 2, 4)
ALBEDO_SAMPLES, ALBEDO_WALKS = 2048, 32

#: Directions wi of a material at which the proposal's noise is measured, and samples of each.
VARIATION_ANGLES, VARIATION_SAMPLES = 8, 2048

#: Kinds of bottoms, in turn.
KINDS = (
    "conductor_anisotropic",
    "conductor_complex_anisotropic",
    "conductor_anisotropic",
    "mixture_anisotropic",
    "diffuse",
)


@dataclass(frozen=True)
class Group:
    """Stacks of `coats` coats; coat and bottom tell which of them may be anisotropic."""

    name: str
    coats: int
    coat: bool
    bottom: bool
    kinds: tuple[str, ...] = KINDS

    def tables(self, stacks: int) -> list[StackTable]:
        """The stacks, one table for each kind of bottom."""
        kinds = [kind for kind in self.kinds if not self.bottom or kind != "diffuse"]
        share = -(-stacks // len(kinds))
        rng = np.random.default_rng((SEED, self.coats, self.coat, self.bottom))
        return [self._table(kind, rng, share) for kind in kinds]

    def _table(self, kind: str, rng: np.random.Generator, stacks: int) -> StackTable:
        table = anisotropic(rng, stacks, self.coats, kind)
        assert isinstance(table.alpha, Widths)
        alpha, bottom = table.alpha, dict(table.bottom)
        if not self.coat:
            alpha = Widths(alpha.u, alpha.u)
        if not self.bottom:
            bottom |= {name: bottom[name[:-1] + "u"] for name in bottom if name.endswith("alpha_v")}
        return replace(table, alpha=alpha, bottom=bottom)


GROUPS = (
    Group("coat anisotropic", 1, True, False),
    Group("bottom anisotropic", 1, False, True),
    Group("both", 1, True, True),
    Group("three interfaces", 2, True, True),
)


def reference(group: Group, stacks: int, folder: Path) -> list[dict[str, np.ndarray]]:
    """Pairs and simulated values of each of the group's tables, kept in `folder`."""
    parts = []
    for index, table in enumerate(group.tables(stacks)):
        path = folder / f"{group.name.replace(' ', '-')}-{index}-{stacks}.npz"
        if not path.exists():
            rng = np.random.default_rng((SEED, 1, index, group.coats))
            count = len(table)
            pairs = [cosine_pairs(rng, count * E_PAIRS), slope_pairs(rng, count * P_PAIRS)]
            wi, wo = (
                np.concatenate([w.reshape(count, -1, 3) for w in sides], axis=1)
                for sides in zip(*pairs, strict=True)
            )
            row = np.repeat(np.arange(count, dtype=np.uint32), E_PAIRS + P_PAIRS)
            flat = wi.reshape(-1, 3), wo.reshape(-1, 3)
            f, se = walk_pairs(table, row, *flat, walks=WALKS, seed=SEED)
            np.savez(path, wi=wi, wo=wo, f=f.reshape(count, -1), se=se.reshape(count, -1))
        parts.append(dict(np.load(path)))
    return parts


def predicted(table: StackTable, *, fast: bool = False) -> list[Material]:
    """One material of one channel for each stack; fast: by the layering network."""
    codes = np.concatenate([_bottom(table, row).latents for row in range(len(table))])
    whole = Material(codes, anisotropic_model())
    for coat in reversed(range(table.coats)):
        columns = {
            name: value.map(lambda x, coat=coat: x[:, coat])
            if isinstance(value, Widths)
            else value[:, coat]
            for name in CoatParameters._fields
            for value in [getattr(table, name)]
        }
        columns["alpha"] = columns["alpha"].map(lambda x: np.maximum(x.astype(np.float64), 0.01))
        whole = layer_material(CoatParameters(**columns), whole, fast)
    return predict.split(whole)


def encoded(table: StackTable) -> list[Material]:
    """The stacks, encoded from simulated values at the probe pairs."""
    model = anisotropic_model()
    wi, wo = model.networks.pairs()
    materials = []
    for row in range(len(table)):
        rows = np.full(len(wi), row, np.uint32)
        values = walk_pairs(table, rows, wi, wo, walks=STACK_WALKS, seed=0)[0]
        materials.append(material_from_values(values[:, None], model, lobe=_top(table, row)))
    return materials


def _top(table: StackTable, row: int) -> np.ndarray:
    """The lobe (1, 7) of a stack's topmost interface."""
    width = table.alpha.map(lambda x: np.maximum(x[row : row + 1, 0], np.float32(0.01)))
    return lobes.of_coat(width, table.eta[row : row + 1, 0])


def _bottom(table: StackTable, row: int) -> Material:
    """The encoded bottom of a stack."""
    model = anisotropic_model()
    columns = {name: values[row : row + 1] for name, values in table.bottom.items()}
    if bottoms.KINDS[table.kind].family.bare:
        lobe = bottom_lobes(table.kind, np.stack(list(columns.values()), axis=-1), 2)
        return material_of_lobes(lobe, model, channels=1)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return analytic.rows(table.kind, columns, np.zeros(len(wi), np.uint32), wi, wo)

    return urushi.encode(f, model)


def errors(materials: list[Material], held: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """E (S,) of the stacks, that of the reference, and P (S, `P_PAIRS`)."""
    f = np.stack(
        [m.f(*pairs)[:, 0] for m, *pairs in zip(materials, held["wi"], held["wo"], strict=True)]
    )
    first, last = slice(None, E_PAIRS), slice(E_PAIRS, None)
    cosines = held["wi"][:, first, 2], held["wo"][:, first, 2]
    found = error_metrics.stack_error(f[:, first], held["f"][:, first], *cosines)
    noisy = held["f"] + held["se"] * np.sqrt(2 / np.pi)
    own = error_metrics.stack_error(noisy[:, first], held["f"][:, first], *cosines)
    return found, own, error_metrics.pair_error(f[:, last], held["f"][:, last])


def excess(table: StackTable) -> float:
    """The largest directional albedo above one of the stacks without their absorption.

    Over angles and azimuths; -1 for bottoms that absorb in other ways.
    """
    if "r0" not in table.bottom:
        return -1.0
    white = replace(
        table,
        albedo=np.ones_like(table.albedo),
        bottom=table.bottom | {"r0": np.ones_like(table.bottom["r0"])},
    )
    wi = albedo_directions()
    return max(float(m.directional_albedo(wi).max() - 1) for m in predicted(white))


def albedo_directions() -> np.ndarray:
    """The directions (D, 3) at which albedos are measured."""
    cosines, azimuths = np.meshgrid(ALBEDO_COSINES, ALBEDO_AZIMUTHS)
    sines = np.sqrt(1 - cosines**2)
    wi = np.stack([sines * np.cos(azimuths), sines * np.sin(azimuths), cosines], axis=-1)
    return wi.reshape(-1, 3)


def albedo_differences(
    table: StackTable, materials: list[Material], rng: np.random.Generator
) -> np.ndarray:
    """Directional albedos of the materials less those of the walk, and standard errors: (2, S, D).

    Both are estimated with the same directions, which the materials' proposals draw.
    """
    wi = albedo_directions()
    repeated = np.repeat(wi, ALBEDO_SAMPLES, axis=0)
    found = np.empty((2, len(materials), len(wi)))
    for row, material in enumerate(materials):
        wo, pdf = material.sample(repeated, rng.random((len(repeated), 3)))
        rows = np.full(len(wo), row, np.uint32)
        wo = np.where(pdf[:, None] > 0, wo, [0, 0, 1])
        walked = walk_pairs(table, rows, repeated, wo, walks=ALBEDO_WALKS, seed=SEED + row)[0]
        weight = np.where(pdf > 0, wo[:, 2] / np.maximum(pdf, 1e-12), 0)
        values = (weight * (material.f(repeated, wo)[:, 0] - walked)).reshape(len(wi), -1)
        found[:, row] = values.mean(1), values.std(1) / np.sqrt(ALBEDO_SAMPLES)
    return found


def variations(material: Material, rng: np.random.Generator) -> np.ndarray:
    """Coefficients of variation (`VARIATION_ANGLES`,) of f cos / pdf over wo, each at one wi."""
    angles, _ = cosine_pairs(rng, VARIATION_ANGLES, lowest_cosine=0.1)
    wi = np.repeat(angles, VARIATION_SAMPLES, axis=0)
    wo, pdf = material.sample(wi, rng.random((len(wi), 3)))
    weight = material.f(wi, wo)[:, 0] * wo[:, 2] / np.maximum(pdf, 1e-12)
    weight = weight.reshape(VARIATION_ANGLES, VARIATION_SAMPLES)
    return weight.std(axis=1) / weight.mean(axis=1)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--stacks", type=int, default=32)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    print(f"weights {anisotropic_model().fingerprint}")
    print(
        "| group | materials | E mean | median | p95 | reference's own | P median | lossless albedo"
        " above 1 | cv median | cv p95 | albedo above the walk's, less 2 se | mean error of the"
        " albedo |"
    )
    for group in GROUPS:
        tables = group.tables(arguments.stacks)
        held = reference(group, arguments.stacks, arguments.out)
        above = 100 * max(map(excess, tables))
        ways = {"layered": predicted, "network": partial(predicted, fast=True), "encoded": encoded}
        for way, make in ways.items():
            row = figures(tables, held, make)
            row.insert(5, above if way == "layered" else None)
            cells = " | ".join("" if x is None else f"{x:.2f}" for x in row)
            print(f"| {group.name} | {way} | {cells} |", flush=True)


def figures(
    tables: list[StackTable],
    held: list[dict[str, np.ndarray]],
    make: Callable[[StackTable], list[Material]],
) -> list[float | None]:
    """A row of the table, without the lossless albedo."""
    rng = np.random.default_rng(SEED)
    found, own, pairs, spread, albedos = [], [], [], [], []
    for table, of_table in zip(tables, held, strict=True):
        materials = make(table)
        of_stacks, of_reference, of_pairs = errors(materials, of_table)
        found.append(of_stacks)
        own.append(of_reference)
        pairs.append(of_pairs.ravel())
        albedos.append(albedo_differences(table, materials, rng))
        spread += [variations(material, rng) for material in materials]
    e = 100 * np.concatenate(found)
    difference, error = np.concatenate(albedos, axis=1)
    return [
        e.mean(),
        np.median(e),
        np.percentile(e, 95),
        100 * np.concatenate(own).mean(),
        100 * np.median(np.concatenate(pairs)),
        np.median(spread),
        np.percentile(spread, 95),
        100 * (difference - 2 * error).max(),
        100 * np.abs(difference).mean(),
    ]


if __name__ == "__main__":
    main()
