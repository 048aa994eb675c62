"""The held-out stacks that networks are measured on, and the rows of the table of errors."""

from collections.abc import Sequence
from dataclasses import dataclass
from typing import NamedTuple

from urushi.errors import ParameterError
from urushi.train.data.distribution import Clear, Distribution, Extended, Table2
from urushi.walk.bottoms import KINDS


@dataclass(frozen=True)
class Group:
    """Held-out stacks of one distribution.

    Attributes:
        name: unique; seeds the group's stacks and directions.
        distribution: of the stacks' parameters.
        stacks: number of stacks.
        probed: numbers of coats, each at least one. For each number the lowest coats over the
            bottom are simulated at the probe pairs too, as input of the encoder.
    """

    name: str
    distribution: Distribution
    stacks: int
    probed: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.stacks < 1:
            raise ParameterError(
                f"group '{self.name}' has {self.stacks} stacks; it needs at least one"
            )
        if not all(0 < coats <= self.distribution.coats for coats in self.probed):
            raise ParameterError(
                f"group '{self.name}' has probed = {self.probed}; "
                f"its stacks have 1 to {self.distribution.coats} coats"
            )


class Aim(NamedTuple):
    """An aim of the project: `metric`'s `statistic` is at most `limit` (a fraction)."""

    metric: str
    statistic: str
    limit: float


@dataclass(frozen=True)
class Row:
    """One line of the table: errors over the stacks of several groups.

    Attributes:
        name: of the line.
        groups: the names of the groups.
        encoded: number of each stack's lowest coats that are encoded with the bottom, from values
            at the probe pairs; the others are layered. -1: all.
        refined: whether the codes are refined before they are layered, see `material.fit`.
        aims: of the shipped networks.
    """

    name: str
    groups: tuple[str, ...]
    encoded: int = 0
    refined: bool = False
    aims: tuple[Aim, ...] = ()

    def coats(self, group: Group) -> int:
        """Number of coats of a group's stacks that are encoded."""
        return group.distribution.coats if self.encoded < 0 else self.encoded


def _e(limit: float) -> Aim:
    return Aim("E", "mean", limit)


#: The kinds of bottom that are measured, with their names in the table.
BOTTOMS = {
    name: kind.family.title
    for name, kind in KINDS.items()
    if kind.family.title and kind.widths == 1
}
_KINDS = tuple(BOTTOMS)

_BARE = tuple(Group(f"bare {kind}", Extended(0, kind), 64) for kind in _KINDS)
_TWO = (
    Group("two, table2", Table2(1), 64, probed=(1,)),
    *(Group(f"two, {kind}", Extended(1, kind), 12, probed=(1,)) for kind in _KINDS),
)
_THREE = (
    Group("three, table2", Table2(2), 8, probed=(1, 2)),
    *(Group(f"three, {kind}", Extended(2, kind), 4, probed=(1, 2)) for kind in _KINDS),
)
_SIX = (
    Group("six, table2", Table2(5), 4),
    *(Group(f"six, {kind}", Extended(5, kind), 4) for kind in _KINDS),
)
_CLEAR = tuple(Group(f"clear, {kind}", Clear(1, kind), 12) for kind in _KINDS)
_LOW_TWO = tuple(Group(f"low two, {kind}", Extended(1, kind, "low"), 8) for kind in _KINDS)
_LOW_THREE = tuple(Group(f"low three, {kind}", Extended(2, kind, "low"), 4) for kind in _KINDS)


def _names(groups: Sequence[Group]) -> tuple[str, ...]:
    return tuple(group.name for group in groups)


#: All groups; those without a coat are analytic, the others are simulated.
GROUPS = (*_BARE, *_TWO, *_THREE, *_SIX, *_CLEAR, *_LOW_TWO, *_LOW_THREE)

#: The table, top to bottom.
ROWS = (
    *(
        Row(f"encode {BOTTOMS[kind]}", (f"bare {kind}",), aims=(_e(0.005),))
        for kind in _KINDS
    ),
    Row(
        "encode simulated stacks",
        _names((*_TWO, *_THREE)),
        encoded=-1,
        aims=(_e(0.006), Aim("P", "median", 0.004)),
    ),
    Row("bare surfaces, all, refined", _names(_BARE), refined=True, aims=(_e(0.005),)),
    Row(
        "simulated stacks, refined",
        _names((*_TWO, *_THREE)),
        encoded=-1,
        refined=True,
        aims=(_e(0.006), Aim("P", "median", 0.004)),
    ),
    Row(
        "layer two interfaces, Table 2",
        _names(_TWO[:1]),
        aims=(_e(0.005), Aim("E", "p95", 0.012), Aim("P", "median", 0.0035)),
    ),
    Row("layer two interfaces, extended", _names(_TWO[1:]), aims=(_e(0.008),)),
    *(Row(f"  over {BOTTOMS[kind]}", (f"two, {kind}",)) for kind in _KINDS),
    Row("layer three interfaces", _names(_THREE), aims=(_e(0.012),)),
    Row("  upper over encoded lower", _names(_THREE), encoded=1),
    Row("  upper over refined lower", _names(_THREE), encoded=1, refined=True),
    Row("layer six interfaces", _names(_SIX), aims=(_e(0.025),)),
    Row("layer clear coats", _names(_CLEAR)),
    *(Row(f"  over {BOTTOMS[kind]}, clear", (f"clear, {kind}",)) for kind in _KINDS),
    Row("indices below one, two interfaces", _names(_LOW_TWO), aims=(_e(0.01),)),
    Row("indices below one, three interfaces", _names(_LOW_THREE), aims=(_e(0.01),)),
)  # fmt: skip
