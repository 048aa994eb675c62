"""The values of a plugin's parameters: compared, and put back where an update is refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any
from weakref import WeakSet, ref

import drjit as dr
import mitsuba as mi

from urushi.errors import ParameterError


class ParameterSnapshot:
    """The values that `mi.traverse` lists below a plugin, as of its last accepted update."""

    def __init__(self) -> None:
        self._values: dict[str, Any] = {}
        self._plugin: Any = None  # a weak reference
        self._holders: WeakSet[ParameterSnapshot] = WeakSet()  # of plugins that contain this one
        self._restoring = False

    def keep(self, plugin: "mi.Object") -> None:
        """Remember the present values. Dr.Jit's arrays are copied when they are written."""
        self._values = {key: type(value)(value) for key, value in writable(plugin)}
        self._plugin = ref(plugin)
        for node in mi.traverse(plugin).hierarchy:
            inner = getattr(node, "_snapshot", self)
            if inner is not self:
                inner._holders.add(self)

    @contextmanager
    def restored_on_error(self, plugin: "mi.Object") -> Iterator[None]:
        """Run an update; where it is refused, put the kept values back and update again.

        So it is in the plugins that contain this one: one update may change them, too.
        """
        held = [self, *self._holders]
        restoring = any(x._restoring for x in held)
        try:
            yield
        except ParameterError:
            if not restoring:
                for snapshot in held:
                    if not snapshot._holders:
                        snapshot._restore()
            raise
        self.keep(plugin)

    def _restore(self) -> None:
        plugin = self._plugin and self._plugin()
        if plugin is None:
            return
        self._restoring = True
        try:
            parameters = mi.traverse(plugin)
            parameters.update({k: v for k, v in self._values.items() if k in parameters})
        finally:
            self._restoring = False


def has_gradients(plugin: "mi.Object") -> bool:
    """Whether a parameter below a plugin carries a gradient, also where gradients are suspended."""
    return any(is_attached(value) for _, value in writable(plugin))


def is_attached(value: Any) -> bool:
    """Whether a value carries a gradient, also where gradients are suspended."""
    with dr.resume_grad():
        return dr.is_array_v(value) and dr.grad_enabled(value)


def writable(plugin: "mi.Object") -> list[tuple[str, Any]]:
    """Names and values of the parameters below a plugin that are not read-only."""
    parameters, read_only = mi.traverse(plugin), mi.ParamFlags.ReadOnly
    return [(key, value) for key, value in parameters if not parameters.flags(key) & read_only]
