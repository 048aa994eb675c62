"""The linear basis in Dr.Jit: the counterpart of `nets.basis`, for channels that share directions.

The functions are looked up once for all channels. A table holds the mean and the functions but the
first, which is one, as numbers of 16 bits.

Codes of two widths have a stretch, on which the functions depend. Channels of the same stretch
share the look-up.
"""

import weakref
from collections.abc import Sequence
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.lanes import cell
from urushi.core.namespace import DRJIT
from urushi.core.stretched import stretched
from urushi.core.table import MAX_LOG, MIN_LOG, SHAPE, coordinates, corner_steps
from urushi.mitsuba.latents import lobe
from urushi.mitsuba.latents.lobe import LobeKind
from urushi.mitsuba.latents.tables import Numbers
from urushi.nets.networks import Networks
from urushi.nets.weights import Model


class BasisTable:
    """Mean and functions at the nodes of `core.table`, in Dr.Jit's memory."""

    def __init__(self, rows: np.ndarray, factors: Sequence[int] = ()):
        """Store functions.

        Args:
            rows: (P, N) mean and functions, without the constant one.
            factors: (N,) of `core.stretched`, for two widths; 0: none.
        """
        self._factors, self._numbers = factors, Numbers(rows)

    @property
    def count(self) -> int:
        """Number of columns, N."""
        return self._numbers.count

    def at(self, wi, wo, stretch2=None) -> list:
        """Mean and functions (N) of a pair above the horizon.

        stretch2: the squared stretch, for two widths; the functions are times their factors.
        """
        if stretch2 is None:
            return self._at(coordinates(wi + wo, wi - wo, DRJIT))
        places, around = stretched(wi + wo, wi - wo, stretch2, DRJIT)
        pairs = zip(self._at(places), self._factors, strict=True)
        return [value * around[factor - 1] if factor else value for value, factor in pairs]

    def _at(self, places: Sequence) -> list:
        """Mean and functions (N) at coordinates (3)."""
        clipped = [dr.clip(place, 0, 1) for place in places]
        first, shares = cell(SHAPE, clipped, mi.UInt32(0))
        weights: list[Any] = [1]
        for share in shares:
            weights = [x * y for x in weights for y in (1 - share, share)]
        nodes = [first + step for step in corner_steps(SHAPE)]
        return self._numbers.at([*zip(nodes, weights, strict=True)])


#: The tables of networks by fingerprint and variant, while any plugin uses them.
_tables: weakref.WeakValueDictionary[tuple[str, str], BasisTable] = weakref.WeakValueDictionary()


def table_of(model: Model) -> BasisTable:
    """The table of a model, which plugins share."""
    key = model.fingerprint, mi.variant()
    table = _tables.get(key)
    if table is None:
        networks = model.networks
        assert isinstance(networks, Networks)  # for the type checker
        rows, factors = (
            np.delete(x, 1, axis=-1) for x in (networks.basis.rows, networks.basis.factors)
        )
        table = BasisTable(rows, factors.tolist())
        _tables[key] = table
    return table


class BasisDecoder:
    """f [1/sr] of latent codes: the lobe, and the rest by the basis below `nets.transmittance`.

    The terms of a channel's code are the numbers of its lobe that `LobeKind.numbers` names, its
    gain, and its other numbers; of two widths also the squared stretch.
    """

    def __init__(
        self, model: Model, kind: LobeKind, functions: np.ndarray | None = None, faint: float = 0.0
    ):
        """Decode codes of a model.

        Args:
            model: of the codes.
            kind: common properties of their lobes.
            functions: (P, N) mean and functions of other numbers in the place of the code's, at
                the nodes. None for two widths.
            faint: [1/sr] by which g of the codes is too large.
        """
        self._kind, self._lobe, self._faint = kind, model.arch.lobe, faint
        self._table = table_of(model) if functions is None else BasisTable(functions)
        self._end = self._lobe + self._table.count  # of the numbers of functions

    def code_terms(self, latents: Sequence[Sequence]) -> list[list]:
        """Terms of the code of each channel, from numbers or Dr.Jit floats (C, size)."""
        terms = []
        for c, z in enumerate(latents):
            stretch2 = [dr.exp(2 * x) for x in z[self._end :]]
            lobe = (z[i] for i in self._kind.numbers(c))
            terms.append([*lobe, *z[self._lobe : self._end], *stretch2])
        return terms

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list of Dr.Jit floats, its terms, for each.

        Exchanging wi and wo gives the same bits.
        """
        two, rests = self._kind.widths == 2, list[Any]()
        count, looked_up = self._table.count + two, dict[Any, list]()
        for channel in terms:
            gain, *numbers = channel[-count:]
            stretch2 = numbers.pop() if two else None
            key = None if stretch2 is None else stretch2.index  # of the variable
            if key not in looked_up:
                looked_up[key] = self._table.at(wi, wo, stretch2)
            mean, *functions = looked_up[key]
            log = mean + gain
            for number, function in zip(numbers, functions, strict=True):
                log = dr.fma(number, function, log)
            rest = dr.exp(dr.clip(log, MIN_LOG, MAX_LOG))
            if self._faint:  # the derivative passes the bound, so that an optimiser can leave black
                rest = rest - self._faint
                rest = rest + dr.detach(dr.maximum(-rest, 0))
            rests.append(rest)
        lobes = self._kind.complete([channel[:-count] for channel in terms])
        return lobe.with_rests(lobes, rests, wi, wo, self._kind)
