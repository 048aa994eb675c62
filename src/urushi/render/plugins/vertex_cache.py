"""The last vertex, for code that is recorded once and asks about it twice.

Path integrators have a BSDF evaluate towards a light and then draw a direction, one right after the
other in the same recorded code, at the same vertex. Dr.Jit merges equal expressions, but no calls.
"""

from collections.abc import Callable, Sequence
from typing import Any, NamedTuple

import drjit as dr


class CacheEntry(NamedTuple):
    """What was asked, in which scope of recorded code, and the answer."""

    question: Sequence
    scope: int
    result: Any


class VertexCache:
    """The last answer that a plugin gave."""

    def __init__(self):
        self._last: CacheEntry | None = None
        self._replaced: list[CacheEntry] = []

    def answer(self, question: Sequence, compute: Callable[[], Any]) -> Any:
        """Return compute(), or what it gave when the same was last asked, if that can be used.

        question: Dr.Jit arrays. An answer can be used in the scope that it was computed in, and
        in those that `extend` reaches: those that follow it without leaving the recorded code.
        """
        known, self._last = self._last, None
        scope, indices = _scope(question), _indices(question)
        if known and (known.scope, _indices(known.question)) == (scope, indices):
            return known.result
        if not dr.flag(dr.JitFlag.FreezingScope):
            self._replaced.clear()
        elif known:
            # It may be the last trace of a scene, and no scene can be freed while a frozen function
            # is recorded: Dr.Jit ends the process.
            self._replaced.append(known)
        result = compute()
        if dr.detail.any_symbolic(question):  # otherwise all of it would be kept in memory
            self._last = CacheEntry(question, _scope(question), result)
        return result

    def extend(self) -> None:
        """Let the last answer be used in the present scope too: only calls have come between."""
        if self._last:
            self._last = self._last._replace(scope=_scope(self._last.question))


def _scope(arrays: Sequence) -> int:
    return dr.detail.scope(dr.backend_v(arrays[0]))


def _indices(arrays: Sequence) -> list[tuple[int, int]]:
    return [(array.index, array.index_ad) for array in arrays]
