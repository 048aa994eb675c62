"""E of anisotropic stacks by Weier and Belcour 2020 and by the networks, against the walk.

    python -m benchmarks.rivals.weier --out DIR [--stacks 12]

The groups of `benchmarks.quality.anisotropy`, without its mixtures, which the model does not
describe; each group also without its media. `--stacks` is the number of stacks of a group, rounded
up to one of each kind of bottom. The reference is kept in DIR.
"""

import argparse
import itertools
from dataclasses import replace
from pathlib import Path

import numpy as np
from benchmarks.quality.anisotropy import E_PAIRS, GROUPS, KINDS, Group, predicted, reference
from research.rivals import belcour, weier
from research.rivals.belcour_bottoms import SUFFIX

from urushi.checks import Widths
from urushi.core import error_metrics
from urushi.nets.weights import anisotropic_model
from urushi.walk import StackTable

#: Kinds of bottoms that the model describes.
DESCRIBED = tuple(kind for kind in KINDS if not kind.startswith("mixture"))

#: Limits of the largest width of a stack's coats, by which the stacks without media are split.
WIDTHS = (0, 0.1, 0.3, 0.6, np.inf)


class Clear(Group):
    """The stacks of a group without their media."""

    def tables(self, stacks: int) -> list[StackTable]:
        """The stacks, one table for each kind of bottom."""
        return [
            replace(table, sigma_t=np.zeros_like(table.sigma_t)) for table in super().tables(stacks)
        ]


def groups() -> list[Group]:
    """The groups, each with its media and without."""
    scattering = [replace(group, kinds=DESCRIBED) for group in GROUPS]
    return [
        one
        for group in scattering
        for one in (group, Clear(f"{group.name} clear", *list(vars(group).values())[1:]))
    ]


def one_width(table: StackTable) -> StackTable:
    """The stacks with the geometric mean of the two widths of every surface."""
    alpha, bottom = table.alpha, dict(table.bottom)
    if isinstance(alpha, Widths):
        alpha = np.sqrt(alpha.u * alpha.v)
    if "alpha_u" in bottom:
        mean = np.sqrt(bottom.pop("alpha_u") * bottom.pop("alpha_v"))
        bottom = {"alpha": mean, **bottom}
    kind = table.kind.removesuffix(SUFFIX)
    return replace(table, alpha=alpha, kind=kind, bottom=bottom)


def errors(table: StackTable, held: dict[str, np.ndarray]) -> np.ndarray:
    """E of each stack, (4, S): the model, Belcour 2018 of one width, networks, the reference."""
    wi, wo = (held[name][:, :E_PAIRS] for name in ("wi", "wo"))
    row = np.repeat(np.arange(len(table), dtype=np.uint32), E_PAIRS)
    flat = row, wi.reshape(-1, 3), wo.reshape(-1, 3)
    values = [
        weier.rows(table, *flat).reshape(wi.shape[:2]),
        belcour.rows(one_width(table), *flat).reshape(wi.shape[:2]),
        np.stack([m.f(*pair)[:, 0] for m, *pair in zip(predicted(table), wi, wo, strict=True)]),
        (held["f"] + held["se"] * np.sqrt(2 / np.pi))[:, :E_PAIRS],
    ]
    f, cosines = held["f"][:, :E_PAIRS], (wi[..., 2], wo[..., 2])
    return np.stack([error_metrics.stack_error(value, f, *cosines) for value in values])


def print_row(name: str, e: np.ndarray) -> None:
    """Print one row of the table; e is in percent, (4, S)."""
    *methods, own = e
    columns = [
        f"{x.mean():.1f} / {np.median(x):.1f} / {np.percentile(x, 95):.1f} %" for x in methods
    ]
    print(f"| {name} | {len(own)} | {' | '.join(columns)} | {own.mean():.2f} % |", flush=True)


def main() -> None:
    """Print a table."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--stacks", type=int, default=12)
    arguments = parser.parse_args()
    arguments.out.mkdir(parents=True, exist_ok=True)
    print(f"weights {anisotropic_model().fingerprint}; mean / median / 95th percentile of E")
    print(
        "| stacks | number | Weier and Belcour 2020 | Belcour 2018, mean widths | networks |"
        " reference's own |\n|---|---|---|---|---|---|"
    )
    all_stacks, clear, widest = [], [], []
    for group in groups():
        tables = group.tables(arguments.stacks)
        held = reference(group, arguments.stacks, arguments.out)
        parts = [100 * errors(*part) for part in zip(tables, held, strict=True)]
        print_row(group.name, np.concatenate(parts, axis=1))
        all_stacks += parts
        if isinstance(group, Clear):
            clear += parts
            widest += [np.maximum(table.alpha.u, table.alpha.v).max(axis=1) for table in tables]
    e, width = np.concatenate(clear, axis=1), np.concatenate(widest)
    for low, high in itertools.pairwise(WIDTHS):
        within = (width >= low) & (width < high)
        print_row(f"clear, the coats' largest width {low:g} to {high:g}", e[:, within])
    model, _, networks, _ = np.concatenate(all_stacks, axis=1)
    print(f"networks closer to the walk: {(networks < model).sum()} of {len(model)} stacks")


if __name__ == "__main__":
    main()
