"""The last accepted parameters of a plugin, put back where an update is refused."""

from collections.abc import Iterator
from contextlib import contextmanager
from typing import Any

import mitsuba as mi

from urushi.errors import ParameterError


class KeptParameters:
    """The values that `mi.traverse` lists below a plugin, as of its last accepted update."""

    def __init__(self) -> None:
        self._values: dict[str, Any] | None = None
        self._restoring = False

    def keep(self, plugin: "mi.Object") -> None:
        """Remember the present values. Dr.Jit's arrays are copied when they are written."""
        parameters = mi.traverse(plugin)
        keys = list(parameters.keys())
        written = [key for key in keys if not parameters.flags(key) & mi.ParamFlags.ReadOnly]
        self._values = {key: type(parameters[key])(parameters[key]) for key in written}

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
