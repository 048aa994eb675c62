"""The values of a plugin's parameters: compared, and put back where an update is refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError


class ParameterSnapshot:
    """The values that `mi.traverse` lists below a plugin, as of its last accepted update."""

    def __init__(self) -> None:
        self._values: dict[str, Any] | None = None
        self._restoring = False

    def keep(self, plugin: "mi.Object") -> None:
        """Remember the present values. Dr.Jit's arrays are copied when they are written."""
        self._values = {key: type(value)(value) for key, value in writable(plugin)}

    @contextmanager
    def restored_on_error(self, plugin: "mi.Object") -> Iterator[None]:
        """Run an update; where it is refused, put the kept values back and update again."""
        try:
            yield
        except ParameterError:
            if self._values is not None and not self._restoring:
                self._restoring = True
                try:
                    parameters = mi.traverse(plugin)
                    present = {k: v for k, v in self._values.items() if k in parameters}
                    parameters.update(present)
                finally:
                    self._restoring = False
            raise
        if not self._restoring:
            self.keep(plugin)


def has_gradients(plugin: "mi.Object") -> bool:
    """Whether a parameter below a plugin carries a gradient, also where gradients are suspended."""
    return any(is_attached(value) for _, value in writable(plugin))


def is_attached(value: Any) -> bool:
    """Whether a value carries a gradient, also where gradients are suspended."""
    if dr.is_tensor_v(value):
        return bool(value.array.index_ad)
    if not dr.is_array_v(value) or not dr.is_diff_v(value):
        return False
    return bool(value.index_ad) if dr.depth_v(value) == 1 else any(map(is_attached, value))


def writable(plugin: "mi.Object") -> list[tuple[str, Any]]:
    """Names and values of the parameters below a plugin that are not read-only."""
    parameters, read_only = mi.traverse(plugin), mi.ParamFlags.ReadOnly
    return [(key, value) for key, value in parameters if not parameters.flags(key) & read_only]
