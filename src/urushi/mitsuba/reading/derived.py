"""Textures that are functions of other textures."""

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any

import mitsuba as mi


def derived(
    function: Callable[..., Any], sources: Sequence["mi.Texture"], medium: Any = None
) -> "mi.Texture":
    """A texture whose value is a function of a surface interaction, lanes, and values of sources.

    medium: whose index the function depends on, too, with a method `put_index`.
    """
    return _derived_class(mi.variant())(function, sources, medium)


@cache
def _derived_class(variant: str) -> type:
    """The class in a variant."""

    class Derived(mi.Texture):
        def __init__(self, function, sources, medium):
            self._function, self._derived_from, self._medium = function, sources, medium
            mi.Texture.__init__(self, mi.Properties("derived"))

        def eval(self, si, active=True):
            values = [x.eval(si, active) for x in self._derived_from]
            return mi.Spectrum(self._function(si, active, *values))

        def eval_1(self, si, active=True):
            return self._function(si, active, *(x.eval_1(si, active) for x in self._derived_from))

        def mean(self):
            return self._function(None, True, *(x.mean() for x in self._derived_from))

        def is_spatially_varying(self):
            return False  # the sources are listed, and vary by themselves

        def traverse(self, callback):
            for i, source in enumerate(self._derived_from):
                callback.put(f"source_{i}", source, mi.ParamFlags.Differentiable)
            if self._medium is not None:
                self._medium.put_index(callback)

        def to_string(self):
            return f"Derived[{', '.join(map(str, self._derived_from))}]"

    return Derived
