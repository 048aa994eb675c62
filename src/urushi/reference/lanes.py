"""How the random walk reads a table of stacks: one row per lane, from device memory."""

from typing import Any

import drjit as dr

from urushi.reference import bottoms
from urushi.reference.table import BOTTOM_KINDS, StackTable


class TableLayers:
    """The walk's `Layers`: one row of a table per lane, gathered from device memory."""

    def __init__(self, types: Any, table: StackTable, row: Any) -> None:
        self.count = table.coats
        self._row = row * self.count
        self._columns = {
            name: types.Float(getattr(table, name).ravel())
            for name in ("alpha", "eta", "albedo", "sigma_t", "g")
        }
        self._float = types.Float
        if self.count == 1:  # no layer index: read each parameter once, outside of the loop
            self._cached = {name: self._gather(name, row) for name in self._columns}

    def _gather(self, name: str, index: Any) -> Any:
        return dr.gather(self._float, self._columns[name], index)

    def _read(self, index: Any, *names: str) -> tuple[Any, ...]:
        if self.count == 1:
            return tuple(self._cached[name] for name in names)
        return tuple(self._gather(name, self._row + index) for name in names)

    def interface(self, index: Any) -> tuple[Any, Any]:
        return self._read(index, "alpha", "eta")

    def medium(self, index: Any) -> tuple[Any, Any, Any]:
        return self._read(index, "albedo", "sigma_t", "g")


class ChannelOf:
    """A custom bottom whose colours are read at one channel, the lane's row."""

    def __init__(self, brdf: Any, row: Any) -> None:
        self._brdf = brdf
        self._row = row

    def _channel(self, value: Any) -> Any:
        if dr.size_v(type(value)) != 3 or dr.depth_v(type(value)) < 2:
            return value
        return dr.select(self._row == 0, value[0], dr.select(self._row == 1, value[1], value[2]))

    def f_pdf(self, wi: Any, wo: Any) -> tuple[Any, Any]:
        f, pdf = self._brdf.f_pdf(wi, wo)
        return self._channel(f), pdf

    def sample(self, wi: Any, u0: Any, u1: Any, u2: Any) -> tuple[Any, Any, Any]:
        wo, weight, pdf = self._brdf.sample(wi, u0, u1, u2)
        return wo, self._channel(weight), pdf


def table_bottom(types: Any, table: StackTable, row: Any) -> bottoms.Bottom:
    """The walk's bottom for one row of a table per lane."""
    if table.kind == "custom":
        return ChannelOf(table.custom, row)
    factory, names = BOTTOM_KINDS[table.kind]
    return factory(*(dr.gather(types.Float, types.Float(table.bottom[n]), row) for n in names))
