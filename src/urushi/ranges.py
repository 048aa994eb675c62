"""Ranges of the numeric options of all commands, as types of the commands' fields."""

import math
from dataclasses import dataclass
from typing import Annotated, Any, get_args, get_type_hints

from urushi.errors import ParameterError


@dataclass(frozen=True)
class Range:
    """The values that an option may have: `least` to `most`, in a unit.

    above: `least` itself is excluded; below: `most` is. step: values are multiples of it.
    """

    least: float
    most: float = math.inf
    unit: str = ""
    above: bool = False
    below: bool = False
    step: int = 0

    def __contains__(self, value: float) -> bool:
        low = value > self.least if self.above else value >= self.least
        high = value < self.most if self.below else value <= self.most
        return low and high and value != math.inf and not (self.step and value % self.step)

    def __str__(self) -> str:
        bounds = [f"{'above' if self.above else 'at least'} {self.least:.16g}"]
        if self.most < math.inf:
            bounds.append(f"{'below' if self.below else 'at most'} {self.most:.16g}")
        multiple = f", a multiple of {self.step}" if self.step else ""
        return " and ".join(bounds) + self.unit + multiple


#: Sides of pictures. Larger ones do not fit into the memory of most machines.
Pixels = Annotated[int, Range(1, 1 << 15, " pixels")]
Samples = Annotated[int, Range(1, 1 << 24, " samples")]
#: Mitsuba's seeds have 32 bits.
Seed = Annotated[int, Range(0, (1 << 32) - 1)]
Walks = Annotated[int, Range(2, 1 << 30, " walks")]
Texels = Annotated[int, Range(1, 4096, " texels")]
Threads = Annotated[int, Range(1, 1024, " threads")]
Index = Annotated[int, Range(0)]
Port = Annotated[int, Range(0, 65535)]
Pairs = Annotated[int, Range(1, 1 << 16, " pairs")]
Share = Annotated[float, Range(0, 1, above=True)]
Incidence = Annotated[float, Range(0, 90, " degrees", below=True)]
Angle = Annotated[float, Range(-360, 360, " degrees")]


def check(command: Any, dashes: str = "--") -> None:
    """Refuse values of a command's options that are out of range.

    `dashes` begin an option's name in the sentence.

    Raises:
        ParameterError: one is; the sentence names the option.
    """
    for name, hint in get_type_hints(type(command), include_extras=True).items():
        value, bounds = getattr(command, name), range_of(hint)
        if bounds is not None and value is not None and value not in bounds:
            option = name.replace("_", "-") if dashes else name
            raise ParameterError(f"{dashes}{option} is {value}; it must be {bounds}")


def range_of(hint: Any) -> Range | None:
    """The range in the annotations of a type, or of a member of a union."""
    for part in get_args(hint):
        found = part if isinstance(part, Range) else range_of(part)
        if found is not None:
            return found
    return None
