"""Errors of anisotropic materials against the walk: E and P by group, energy and sampling.

Stacks of width quotients up to 8 along either axis, with Henyey-Greenstein media, of a seed that no
training data have. The reference is simulated to an error E of about 0.4 %. Materials are coats by
light transport, coats by the layering network, and simulated stacks that are encoded. Groups
without mixtures, with their media and without ("clear"), are also compared with Weier and Belcour
2020, and with Belcour 2018 of the mean width of every surface.
"""

from dataclasses import dataclass, replace
from typing import Any

import numpy as np
from benchmarks import measures
from benchmarks.evaluation import predict, samples
from benchmarks.evaluation.distributions import anisotropic
from benchmarks.evaluation.report import summary
from benchmarks.evaluation.samples import Samples
from benchmarks.experiment import BOTH, Experiment, Found, Options
from benchmarks.showing import table as markdown
from research.rivals import belcour, weier
from research.rivals.belcour_bottoms import SUFFIX

from urushi.checks import Widths
from urushi.nets.weights import anisotropic_model
from urushi.walk import StackTable

SEED = 90210

#: Pairs of a stack for E and for P, and walks of a pair.
E_PAIRS, P_PAIRS, WALKS = 160, 96, 20480

#: Stacks of a group, rounded up to as many of each kind of bottom.
STACKS = 20

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

    rivals: without mixtures, to be compared with the rivals. clear: without their media.
    """

    coats: int
    coat: bool
    bottom: bool
    rivals: bool = False
    clear: bool = False

    def tables(self, stacks: int) -> list[StackTable]:
        """The stacks, one table for each kind of bottom."""
        kinds = [
            kind
            for kind in KINDS
            if (not self.bottom or kind != "diffuse")
            and not (self.rivals and kind.startswith("mixture"))
        ]
        rng = np.random.default_rng((SEED, self.coats, self.coat, self.bottom))
        return [self._table(kind, rng, -(-stacks // len(kinds))) for kind in kinds]

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


GROUPS = {
    "coat of two widths": Group(1, True, False),
    "bottom of two widths": Group(1, False, True),
    "both": Group(1, True, True),
    "three interfaces": Group(2, True, True),
}


def reference(table: StackTable, index: int, walks: int) -> Samples:
    """Pairs and simulated values of one of a group's tables."""
    rng = np.random.default_rng((SEED, 1, index, table.coats))
    wi, wo = samples.pairs_of_stacks(rng, len(table), E_PAIRS, P_PAIRS, slopes=True)
    f, se = samples.walk_all(table, wi, wo, walks, SEED)
    return Samples(table, wi, wo, f, se, e_pairs=E_PAIRS)


#: The ways to make the materials of some stacks: whether stacks are encoded, and `how` they are
#: layered, see `samples.Row`.
WAYS = {"layered": (False, "code"), "network": (False, "network"), "encoded": (True, "code")}


def values(held: Samples, encoded: bool, how: str) -> np.ndarray:
    """Values (S, M) of the stacks' materials."""
    coats = held.table.coats if encoded else 0
    materials = predict.materials(anisotropic_model(), held, coats, how=how)
    return predict.evaluate(materials, held.wi, held.wo)


def by_rival(rival: Any, table: StackTable, held: Samples) -> np.ndarray:
    """Values of a model of `research.rivals` at the pairs for E."""
    wi, wo = held.wi[:, :E_PAIRS], held.wo[:, :E_PAIRS]
    return rival.rows(table, *samples.by_row(wi, wo)).reshape(wi.shape[:2])


def one_width(table: StackTable) -> StackTable:
    """The stacks with the geometric mean of the two widths of every surface."""
    alpha, bottom = table.alpha, dict(table.bottom)
    if isinstance(alpha, Widths):
        alpha = np.sqrt(alpha.u * alpha.v)
    if "alpha_u" in bottom:
        bottom = {"alpha": np.sqrt(bottom.pop("alpha_u") * bottom.pop("alpha_v")), **bottom}
    return replace(table, alpha=alpha, kind=table.kind.removesuffix(SUFFIX), bottom=bottom)


def cases(_: Options) -> dict[str, Group]:
    """The groups, then those that are compared with the rivals."""
    ends = {"": False, ", clear": True}
    return GROUPS | {
        f"{name}{end}, rivals": replace(group, rivals=True, clear=clear)
        for name, group in GROUPS.items()
        for end, clear in ends.items()
    }


def measure(group: Group, options: Options) -> Found:
    """E by method, or the figures of each way to make the materials."""
    tables, walks = group.tables(options.count(STACKS)), options.count(WALKS, 64)
    sets = [reference(table, index, walks) for index, table in enumerate(tables)]
    if group.rivals:
        found = {
            "Weier": [by_rival(weier, held.table, held) for held in sets],
            "one width": [by_rival(belcour, one_width(held.table), held) for held in sets],
            "networks": [values(held, *WAYS["layered"]) for held in sets],
            "reference": [measures.moved(held.f, held.se) for held in sets],
        }
        return {name: _errors(f, sets) for name, f in found.items()}
    own = _errors([measures.moved(held.f, held.se) for held in sets], sets).mean()
    result: Found = {}
    for way, how in WAYS.items():
        f = [values(held, *how) for held in sets]
        p = [samples.pair_errors(x, held).ravel() for x, held in zip(f, sets, strict=True)]
        figures = {"E": [*summary(_errors(f, sets)).values()], "reference": own}
        result[way] = figures | {"P": np.median(np.concatenate(p))}
    return result


def _errors(f, sets: list[Samples]) -> np.ndarray:
    """E of all stacks, from values (S, M) of each set."""
    return np.concatenate([samples.stack_errors(x, s) for x, s in zip(f, sets, strict=True)])


def tables(found: Found) -> list[str]:
    """Tables: the ways to make materials, and the rivals."""
    own, others = [], []
    for name, case in found.items():
        if "layered" not in case:
            parts = [100 * np.array(case[key]) for key in ("Weier", "one width", "networks")]
            cells = ["{:.1f} / {:.1f} / {:.1f}".format(*summary(e).values()) for e in parts]
            noise = f"{100 * np.mean(case['reference']):.2f}"
            others.append([name.removesuffix(", rivals"), *cells, noise])
            continue
        of = [case[way] for way in WAYS]
        noise, p = _cell([of[0]["reference"]]), _cell([way["P"] for way in of])
        own.append([name, *(_cell(way["E"]) for way in of), noise, p])
    head = ["stacks: E [%]", *WAYS, "of the reference", "median P: " + " / ".join(WAYS)]
    rivals = ["stacks: E [%]", "Weier and Belcour 2020", "one width", "codes", "of the reference"]
    return [markdown(*part) for part in ((head, own), (rivals, others)) if part[1]]


def _cell(shares: list[float]) -> str:
    return " / ".join(f"{100 * x:.2f}" for x in shares)


EXPERIMENT = Experiment(cases, tables, measure, models=BOTH, minutes=5)
