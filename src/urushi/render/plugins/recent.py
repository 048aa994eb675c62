"""The last vertex, for code that is recorded once and asks about it twice.

Path integrators have a BSDF evaluate towards a light and then draw a direction, one right after the
other in the same recorded code, at the same vertex. Dr.Jit merges equal expressions, but no calls.
"""

from collections.abc import Callable, Sequence
from typing import Any

import drjit as dr

#: Who asked (by id: this must keep no plugin alive), what about, in which scope of recorded code,
#: and the answer.
_last: tuple[int, Sequence, int, Any] | None = None


def answer(asker: object, question: Sequence, compute: Callable[[], Any]) -> Any:
    """Return compute(), or what it gave when the same was last asked, if that can still be used.

    question: Dr.Jit arrays. An answer can be used in the scope that it was computed in, and
    in those that `extend` reaches: those that follow it without leaving the recorded code.
    """
    global _last
    known, _last = _last, None
    scope, indices = _scope(question), _indices(question)
    if known and (known[0], known[2], _indices(known[1])) == (id(asker), scope, indices):
        return known[3]
    result = compute()
    if dr.detail.any_symbolic(question):  # otherwise all of it would be kept in memory
        _last = (id(asker), question, _scope(question), result)
    return result


def extend(asker: object) -> None:
    """Let the last answer be used in the present scope as well: only calls have come between."""
    global _last
    if _last and _last[0] == id(asker):
        _last = (_last[0], _last[1], _scope(_last[1]), _last[3])


def _scope(arrays: Sequence) -> int:
    return dr.detail.scope(dr.backend_v(arrays[0]))


def _indices(arrays: Sequence) -> list[tuple[int, int]]:
    return [(array.index, array.index_ad) for array in arrays]
