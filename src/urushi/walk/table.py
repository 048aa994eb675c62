"""Many monochrome stacks of one shape as arrays, from which each lane of a walk reads one row."""

from dataclasses import dataclass, field
from typing import Any

import drjit as dr
import numpy as np
import numpy.typing as npt

from urushi.checks import CoatParameters, Widths
from urushi.core.microfacet import of_widths
from urushi.errors import ParameterError
from urushi.walk import spectral_mis
from urushi.walk.bottoms import KINDS, Bottom, Description
from urushi.walk.bottoms.bottom import numbers_of
from urushi.walk.stack import Coat, Stack


@dataclass(frozen=True)
class StackTable:
    """S monochrome stacks of N coats each over bottoms of one kind.

    Parameters of coats are float32 (S, N), from top to bottom. If a coat may be anisotropic, alpha
    is `Widths` of two arrays; a walk then takes up to a tenth longer.
    """

    alpha: np.ndarray | Widths
    eta: np.ndarray
    albedo: np.ndarray
    sigma_t: np.ndarray
    g: np.ndarray
    kind: str  # a key of `bottoms.KINDS`, or "custom"
    bottom: dict[str, np.ndarray] = field(default_factory=dict)  # parameters by name, float32 (S,)
    custom: Any = None  # for "custom", a `Bottom`; row i reads channel i of its colours

    def __post_init__(self) -> None:
        names = KINDS[self.kind].parameters if self.kind in KINDS else ()
        if self.kind != "custom" and tuple(self.bottom) != names:
            raise ParameterError(
                f"a table of '{self.kind}' bottoms needs the parameters {', '.join(names)}"
            )
        for name in CoatParameters._fields:
            value = getattr(self, name)
            if isinstance(value, Widths):
                value = Widths(*map(self._coat_column, ("alpha_u", "alpha_v"), (value.u, value.v)))
            else:
                value = self._coat_column(name, value)
            object.__setattr__(self, name, value)
        columns = {name: _column(values) for name, values in self.bottom.items()}
        if any(v.shape != (len(self),) for v in columns.values()):
            raise ParameterError("the table's bottom parameters must have one number per stack")
        object.__setattr__(self, "bottom", columns)

    def _coat_column(self, name: str, values: npt.ArrayLike) -> np.ndarray:
        """A parameter of the coats as float32 (S, N)."""
        array = _column(values)
        if array.ndim != 2 or array.shape != np.shape(self.albedo):
            raise ParameterError(f"the table's {name} must have shape (stacks, coats)")
        return array

    def __len__(self) -> int:
        return len(self.eta)

    @property
    def coats(self) -> int:
        """Number of coats of every stack."""
        return int(self.eta.shape[1])


def _column(values: npt.ArrayLike) -> np.ndarray:
    """The values as contiguous float32; -0.0, by which the walk may divide, becomes 0.0."""
    return np.ascontiguousarray(values, np.float32) + np.float32(0)


def from_stack(described: Stack | Description) -> StackTable:
    """The table of the channels of a Stack, or of a surface without coats.

    It has three rows, or one if all channels are equal.
    """
    coats: tuple[Coat, ...] = described.coats if isinstance(described, Stack) else ()
    bottom = described.bottom if isinstance(described, Stack) else described
    parts = (*coats, bottom) if isinstance(bottom, Description) else ()
    numbers = [value for part in parts for value in numbers_of(part)]
    channels = 1 if numbers and not any(isinstance(x, tuple) for x in numbers) else 3

    def column(name: str) -> np.ndarray:
        """A parameter of the coats, (channels, coats)."""
        values = [np.broadcast_to(getattr(coat, name), channels) for coat in coats]
        return np.reshape(values, (len(coats), channels)).T

    columns: dict[str, Any] = {name: column(name) for name in CoatParameters._fields[1:]}
    if any(coat.is_anisotropic for coat in coats):
        columns["alpha"] = Widths(column("alpha_u"), column("alpha_v"))
    else:
        columns["alpha"] = column("alpha")
    if not isinstance(bottom, Description):
        return StackTable(**columns, kind="custom", custom=bottom)
    kind = bottom.as_kind()
    values = {name: np.broadcast_to(getattr(bottom, name), channels) for name in kind.parameters}
    return StackTable(**columns, kind=kind.name, bottom=values)


class TableLayers:
    """The walk's `Layers`: one row of a table per lane."""

    def __init__(self, types: Any, table: StackTable, row: Any) -> None:
        self.count = table.coats
        self._row = row * self.count
        coats = CoatParameters(*(getattr(table, name) for name in CoatParameters._fields))
        columns = [types.Float(column.ravel()) for column in coats.columns()]
        self._columns = CoatParameters.of_columns(columns)

    def _read(self, index: Any, column: Any) -> Any:
        place = self._row + index
        return of_widths(lambda x: dr.gather(type(x), x, place), column)

    def interface(self, index: Any) -> tuple[Any, Any]:
        return self._read(index, self._columns.alpha), self._read(index, self._columns.eta)

    def medium(self, index: Any) -> tuple[Any, ...]:
        return tuple(self._read(index, column) for column in self._columns[2:])


class ChannelBottom:
    """A custom bottom; each lane reads the channel whose number is the lane's row."""

    def __init__(self, brdf: Any, row: Any) -> None:
        self._brdf = brdf
        self._row = row

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        f, pdf = self._brdf.f_pdf(wi, wo)
        return spectral_mis.of_hero(f, self._row), pdf

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        wo, weight, pdf = self._brdf.sample(wi, u0, u1, u2)
        return wo, spectral_mis.of_hero(weight, self._row), pdf


def table_bottom(types: Any, table: StackTable, row: Any) -> Bottom:
    """The walk's bottom: one row of a table per lane."""
    if table.kind == "custom":
        return ChannelBottom(table.custom, row)
    return bottom_of_columns(types, table.kind, table.bottom, row)


def bottom_of_columns(types: Any, kind: str, columns: dict[str, np.ndarray], row: Any) -> Bottom:
    """The BRDF of a kind with one row of its parameters' columns (S,) per lane."""
    arrays = (types.Float(_column(columns[name])) for name in KINDS[kind].parameters)
    return KINDS[kind].bottom(*(dr.gather(types.Float, array, row) for array in arrays))
