"""Ranges of the numeric options of all commands, as types of the commands' fields."""

import dataclasses
import math
from dataclasses import dataclass
from typing import Annotated, Any, get_args, get_origin, get_type_hints

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
        return low and high and math.isfinite(value) and not (self.step and value % self.step)

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
    """Refuse values of a command, or of the commands and options inside, that are out of range.

    `dashes` begin an option's name in the sentence.

    Raises:
        ParameterError: one is; the sentence names the option.
    """
    hints = get_type_hints(type(command), include_extras=True)
    for field in dataclasses.fields(command):
        value = getattr(command, field.name)
        if dataclasses.is_dataclass(value):
            check(value, dashes)
        elif value is not None:
            for bounds in ranges_of(hints[field.name]):
                if value not in bounds:
                    name = field.name.replace("_", "-") if dashes else field.name
                    raise ParameterError(f"{dashes}{name} is {value:.16g}; it must be {bounds}")


def ranges_of(hint: Any) -> list[Range]:
    """The ranges in the annotations of a type and of the members of a union."""
    parts = get_args(hint)
    inner = parts[:1] if get_origin(hint) is Annotated else parts
    found = [part for part in parts if isinstance(part, Range)]
    return found + [bounds for part in inner for bounds in ranges_of(part)]
