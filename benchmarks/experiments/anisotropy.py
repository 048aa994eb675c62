"""Errors of anisotropic materials against the walk: E and P by group, energy and sampling.

Stacks of width quotients up to 8 along either axis, with Henyey-Greenstein media, of a seed that no
training data have. The reference is simulated to an error E of about 0.4 %. Materials are coats by
light transport, coats by the layering network, and simulated stacks that are encoded. Groups
without mixtures, with their media and without ("clear"), are also compared with Weier and Belcour
2020, and with Belcour 2018 of the mean width of every surface.
"""

from collections.abc import Callable
from dataclasses import dataclass, replace
from functools import partial

import numpy as np
from benchmarks import brdf_errors
from benchmarks.evaluation import predict, samples
from benchmarks.evaluation.distributions import anisotropic
from benchmarks.experiment import BOTH, Experiment, Found, Options
from benchmarks.pairs import slope_pairs
from benchmarks.showing import rounded
from benchmarks.showing import table as markdown
from research.rivals import belcour, weier
from research.rivals.belcour_bottoms import SUFFIX

import urushi
from urushi.checks import Widths
from urushi.core.direction_sets import cosine_pairs
from urushi.material import Material
from urushi.material.layer import layer_material
from urushi.material.source import STACK_WALKS
from urushi.material.values import material_from_values, material_of_lobes
from urushi.nets import lobe as lobes
from urushi.nets.weights import anisotropic_model
from urushi.train.distribution import bottom_lobes
from urushi.walk import StackTable, analytic, bottoms, walk_pairs

SEED = 90210

#: Pairs of a stack for E and for P, and walks of a pair.
E_PAIRS, P_PAIRS, WALKS = 160, 96, 20480

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
    """Stacks of `coats` coats; coat and bottom tell which of them may be anisotropic.

    clear: without their media.
    """

    name: str
    coats: int
    coat: bool
    bottom: bool
    kinds: tuple[str, ...] = KINDS
    clear: bool = False

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
        depth = np.zeros_like(table.sigma_t) if self.clear else table.sigma_t
        return replace(table, alpha=alpha, bottom=bottom, sigma_t=depth)


#: Stacks of a group, rounded up to as many of each kind of bottom.
STACKS = 20

GROUPS = (
    Group("coat of two widths", 1, True, False),
    Group("bottom of two widths", 1, False, True),
    Group("both", 1, True, True),
    Group("three interfaces", 2, True, True),
)


def reference(group: Group, table: StackTable, index: int, walks: int) -> dict[str, np.ndarray]:
    """Pairs and simulated values of one of the group's tables."""
    rng, count = np.random.default_rng((SEED, 1, index, group.coats)), len(table)
    pairs = [cosine_pairs(rng, count * E_PAIRS), slope_pairs(rng, count * P_PAIRS)]
    wi, wo = (
        np.concatenate([w.reshape(count, -1, 3) for w in sides], axis=1)
        for sides in zip(*pairs, strict=True)
    )
    f, se = samples.walk_all(table, wi, wo, walks, SEED)
    return {"wi": wi, "wo": wo, "f": f, "se": se}


def predicted(table: StackTable, *, fast: bool = False) -> list[Material]:
    """One material of one channel for each stack; fast: by the layering network."""
    codes = np.concatenate([_bottom(table, row).latents for row in range(len(table))])
    whole = Material(codes, anisotropic_model())
    for coat in reversed(range(table.coats)):
        whole = layer_material(predict.coats_at(table, coat), whole, fast)
    return predict.split(whole)


def encoded(table: StackTable) -> list[Material]:
    """The stacks, encoded from simulated values at the probe pairs."""
    model = anisotropic_model()
    wi, wo = model.networks.pairs()
    materials = []
    for row in range(len(table)):
        rows = np.full(len(wi), row, np.uint32)
        values = walk_pairs(table, rows, wi, wo, walks=STACK_WALKS, seed=0)[0]
        width = table.alpha.map(lambda x, row=row: np.maximum(x[[row], 0], np.float32(0.01)))
        lobe = lobes.of_coat(width, table.eta[[row], 0])
        materials.append(material_from_values(values[:, None], model, lobe=lobe))
    return materials


def _bottom(table: StackTable, row: int) -> Material:
    """The encoded bottom of a stack."""
    model = anisotropic_model()
    columns = {name: values[row : row + 1] for name, values in table.bottom.items()}
    if bottoms.KINDS[table.kind].family.bare:
        lobe = bottom_lobes(table.kind, columns, 2)
        return material_of_lobes(lobe, model, channels=1)

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return analytic.rows(table.kind, columns, np.zeros(len(wi), np.uint32), wi, wo)

    return urushi.encode(f, model)


#: The ways to make the materials of some stacks, by name.
WAYS = {"layered": predicted, "network": partial(predicted, fast=True), "encoded": encoded}


def errors(materials: list[Material], held: dict[str, np.ndarray]) -> tuple[np.ndarray, ...]:
    """E (S,) of the stacks, that of the reference, and P (S, `P_PAIRS`)."""
    f = predict.evaluate(materials, held["wi"], held["wo"])
    first, last = slice(None, E_PAIRS), slice(E_PAIRS, None)
    cosines = held["wi"][:, first, 2], held["wo"][:, first, 2]
    found = brdf_errors.stack_error(f[:, first], held["f"][:, first], *cosines)
    noisy = held["f"] + held["se"] * np.sqrt(2 / np.pi)
    own = brdf_errors.stack_error(noisy[:, first], held["f"][:, first], *cosines)
    return found, own, brdf_errors.pair_error(f[:, last], held["f"][:, last])


def by_rivals(table: StackTable, held: dict[str, np.ndarray]) -> list[np.ndarray]:
    """E (S,) of Weier and Belcour 2020, and of Belcour 2018 with the mean of two widths."""
    wi, wo, f = (held[name][:, :E_PAIRS] for name in ("wi", "wo", "f"))
    flat = samples.by_row(wi, wo)
    values = weier.rows(table, *flat), belcour.rows(one_width(table), *flat)
    cosines = wi[..., 2], wo[..., 2]
    return [brdf_errors.stack_error(v.reshape(f.shape), f, *cosines) for v in values]


def one_width(table: StackTable) -> StackTable:
    """The stacks with the geometric mean of the two widths of every surface."""
    alpha, bottom = table.alpha, dict(table.bottom)
    if isinstance(alpha, Widths):
        alpha = np.sqrt(alpha.u * alpha.v)
    if "alpha_u" in bottom:
        bottom = {"alpha": np.sqrt(bottom.pop("alpha_u") * bottom.pop("alpha_v")), **bottom}
    return replace(table, alpha=alpha, kind=table.kind.removesuffix(SUFFIX), bottom=bottom)


def cases(_: Options) -> dict[str, tuple[Group, bool]]:
    """The groups, and whether they are compared with the rivals."""
    found = {group.name: (group, False) for group in GROUPS}
    kinds = tuple(kind for kind in KINDS if not kind.startswith("mixture"))
    for group in GROUPS:
        for end, clear in (("", False), (", clear", True)):
            one = replace(group, kinds=kinds, clear=clear)
            found[f"{group.name}{end}, rivals"] = one, True
    return found


def measure(case: tuple[Group, bool], options: Options) -> Found:
    """E by method, or the figures of each way to make the materials."""
    group, rivals = case
    tables, walks = group.tables(options.count(STACKS)), options.count(WALKS, 64)
    held = [reference(group, table, index, walks) for index, table in enumerate(tables)]
    if rivals:
        parts = []
        for table, own in zip(tables, held, strict=True):
            networks, noise, _ = errors(predicted(table), own)
            parts.append([*by_rivals(table, own), networks, noise])
        e = rounded(np.concatenate(parts, axis=1))
        return dict(zip(("Weier", "one width", "networks", "reference"), e, strict=True))
    return {way: figures(tables, held, make) for way, make in WAYS.items()}


def figures(
    tables: list[StackTable],
    held: list[dict[str, np.ndarray]],
    make: Callable[[StackTable], list[Material]],
) -> Found:
    """Figures of materials that a function makes of each table of stacks."""
    found, own, pairs = [], [], []
    for table, of_table in zip(tables, held, strict=True):
        materials = make(table)
        of_stacks, of_reference, of_pairs = errors(materials, of_table)
        found.append(of_stacks)
        own.append(of_reference)
        pairs.append(of_pairs.ravel())
    e = np.concatenate(found)
    return {
        "E": rounded([e.mean(), *np.percentile(e, [50, 95])]),
        "reference": rounded(np.concatenate(own).mean()),
        "P": rounded(np.median(np.concatenate(pairs))),
    }


def tables(found: Found) -> list[str]:
    """Tables: the ways to make materials, and the rivals."""
    own, others = [], []
    for name, case in found.items():
        if "layered" not in case:
            parts = [100 * np.array(case[key]) for key in ("Weier", "one width", "networks")]
            cells = ["{:.1f} / {:.1f} / {:.1f}".format(*_summary(e)) for e in parts]
            noise = f"{100 * np.mean(case['reference']):.2f}"
            others.append([name.removesuffix(", rivals"), *cells, noise])
            continue
        of = [case[way] for way in WAYS]
        noise, p = _cell([of[0]["reference"]]), _cell([way["P"] for way in of])
        own.append([name, *(_cell(way["E"]) for way in of), noise, p])
    head = ["stacks: E [%]", *WAYS, "of the reference", "median P: " + " / ".join(WAYS)]
    rivals = ["stacks: E [%]", "Weier and Belcour 2020", "one width", "codes"]
    made = [markdown(head, own)] if own else []
    return made + ([markdown([*rivals, "of the reference"], others)] if others else [])


def _summary(e: np.ndarray) -> list[float]:
    return [e.mean(), *np.percentile(e, [50, 95])]


def _cell(shares: list[float]) -> str:
    return " / ".join(f"{100 * x:.2f}" for x in shares)


EXPERIMENT = Experiment(cases=cases, measure=measure, tables=tables, models=BOTH, minutes=5)
