"""Textures that are functions of other textures."""

from collections.abc import Callable, Mapping
from functools import cache
from typing import Any

import mitsuba as mi


def derived(
    function: Callable[..., Any],
    sources: Mapping[str, "mi.Texture"],
    medium: Any = None,
    *,
    color: bool = True,
) -> "mi.Texture":
    """A texture whose value is a function of a surface interaction, lanes, and values of sources.

    sources: by the names that `mi.traverse` lists. medium: whose index the function depends on,
    too, with a method `put_index`. color: whether `eval` reads the sources' spectra, not numbers.
    """
    return _derived_class(mi.variant())(function, sources, medium, color)


@cache
def _derived_class(variant: str) -> type:
    """The class in a variant."""

    class Derived(mi.Texture):
        def __init__(self, function, sources, medium, color):
            self._function, self.sources = function, dict(sources)
            self._medium, self._color = medium, color
            mi.Texture.__init__(self, mi.Properties("derived"))

        def eval(self, si, active=True):
            if not self._color:
                return mi.Spectrum(self.eval_1(si, active))
            values = [x.eval(si, active) for x in self.sources.values()]
            return mi.Spectrum(self._function(si, active, *values))

        def eval_1(self, si, active=True):
            values = [x.eval_1(si, active) for x in self.sources.values()]
            return self._function(si, active, *values)

        def mean(self):
            return self._function(None, True, *(x.mean() for x in self.sources.values()))

        def is_spatially_varying(self):
            return False  # the sources are listed and vary by themselves, with their own transforms

        def traverse(self, callback):
            for name, source in self.sources.items():
                callback.put(name, source, mi.ParamFlags.Differentiable)
            if self._medium is not None:
                self._medium.put_index(callback)

        def to_string(self):
            return f"Derived[{', '.join(self.sources)}]"

    return Derived
