"""Faulty variants of the walk, each of which replaces one step while a context lasts.

They are no part of the package. A variant draws the same random numbers as the right walk, so that
their difference has little noise.
"""

import contextlib
from collections.abc import Callable, Iterator
from typing import Any
from unittest import mock

import drjit as dr

from urushi.walk import interface, walk
from urushi.walk.exits import ExitPaths
from urushi.walk.interface import flip


@contextlib.contextmanager
def right() -> Iterator[None]:
    """The walk as it is."""
    yield


@contextlib.contextmanager
def reverse_density() -> Iterator[None]:
    """The weight of a sampled direction uses the density of leaving, not that of connecting."""

    def through_top(self: ExitPaths, w: Any) -> tuple[Any, Any]:
        f, _ = _through_top(self, w)
        # The faulty line: wo given the inner direction. The rival draws the inner one given wo.
        _, pdf = interface.transmission(flip(-w), flip(self._wo), self._alpha, 1 / self._eta)
        return f, pdf

    with mock.patch.object(ExitPaths, "through_top", through_top):
        yield


@contextlib.contextmanager
def dropped_connection() -> Iterator[None]:
    """A surface's vertex whose own sample fails makes no connection."""
    with (
        mock.patch.object(walk, "bottom_event", _dropping(walk.bottom_event)),
        mock.patch.object(walk, "inner_event", _dropping(walk.inner_event)),
    ):
        yield


def _dropping(event: Callable[..., walk.Event]) -> Callable[..., walk.Event]:
    """The event of a surface without the contribution of vertices whose sample has no weight."""

    def faulty(*arguments: Any) -> walk.Event:
        found = event(*arguments)
        # The faulty line: the walk breaks off here, before it connects.
        kept = dr.select(found.throughput > 0, found.contribution, 0)
        return found._replace(contribution=kept)

    return faulty


_through_top = ExitPaths.through_top

#: The walks by name, the right one first.
VARIANTS = {
    "right": right,
    "reverse density": reverse_density,
    "dropped connection": dropped_connection,
}
