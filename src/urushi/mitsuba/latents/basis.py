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
from urushi.mitsuba.latents.tables import Packets
from urushi.nets.networks import Networks
from urushi.nets.weights import Model

#: The value one of a scaled function; zero is `ONE` + 1.
ONE = (1 << 15) - 1

#: Factor of numbers whose functions are tables of values up to one.
FUNCTION_SCALE = 1 / ONE


class BasisTable:
    """Mean and functions at the nodes of `core.table`, in Dr.Jit's memory."""

    def __init__(
        self, rows: np.ndarray, factors: Sequence[int] = (), scale: np.ndarray | None = None
    ):
        """Store functions.

        Args:
            rows: (P, N) mean and functions, without the constant one.
            factors: (N,) of `core.stretched`, for two widths; 0: none.
            scale: (N,) largest absolute value of each column that can be stored; None: it is found.
        """
        self._factors = factors
        if scale is None:
            scale = np.maximum(np.abs(rows).max(axis=0), 1e-9)
        self.scale = (scale / ONE).astype(np.float32)  # (N,) by which looked up numbers count
        self._packets = Packets(np.rint(rows / scale * ONE) + (ONE + 1))

    def at(self, wi, wo, stretch2=None) -> list:
        """Mean and functions (N) of a pair above the horizon, over `scale`.

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
        total = [mi.Float(-ONE - 1)] * self._packets.count  # shares of all corners add up to one
        corners = np.ndindex(*[2] * len(shares))
        for corner, step in zip(corners, corner_steps(SHAPE), strict=True):
            # One corner after the other, whose sums stay in a processor's registers: without it,
            # Dr.Jit computes one number after the other, at two thirds of the speed or less.
            dr.detail.new_scope(dr.backend_v(mi.Float))
            weight: Any = 1
            for share, end in zip(shares, corner, strict=True):
                weight = weight * (share if end else 1 - share)
            levels = self._packets.at(first + step)
            total = [dr.fma(weight, *pair) for pair in zip(levels, total, strict=True)]
        return total


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
    gain, and its other numbers, scaled as the table's functions require; of two widths also the
    squared stretch.
    """

    def __init__(
        self,
        model: Model,
        kind: LobeKind,
        functions: np.ndarray | None = None,
        faint: float = 0.0,
    ):
        """Decode codes of a model.

        Args:
            model: of the codes.
            kind: common properties of their lobes.
            functions: (P, N) mean and functions of other numbers in the place of the code's, at
                the nodes; the numbers have been multiplied by `FUNCTION_SCALE`. None for two
                widths.
            faint: [1/sr] by which g of the codes is too large.
        """
        self._kind, self._lobe, self._faint = kind, model.arch.lobe, faint
        if functions is None:
            self._table = table_of(model)
            self._scale = [float(factor) for factor in self._table.scale]
        else:  # a power of two: textures share compiled code
            mean = 2.0 ** np.ceil(np.log2(max(np.abs(functions[:, 0]).max(), 1)))
            scale = np.append(mean, np.ones(functions.shape[1] - 1))
            self._table = BasisTable(functions, scale=scale)
            self._scale = [mean / ONE, *[1.0] * (functions.shape[1] - 1)]
        self._end = self._lobe + len(self._scale)  # of the numbers of functions

    @property
    def factors(self) -> np.ndarray:
        """Factors of the numbers of a code after its lobe in its terms, without the stretch."""
        own = [1.0, *self._scale[1:]]
        return np.array([*own, 1.0] if self._kind.widths == 2 else own)

    def code_terms(self, latents: np.ndarray) -> list[np.ndarray]:
        """Terms (N,) of the code of each channel, from codes (C, size)."""
        factors = np.array([1.0, *self._scale[1:]], np.float32)
        terms = []
        for c, z in enumerate(latents):
            numbers = z[self._lobe : self._end] * factors
            terms.append([z[self._kind.numbers(c)], numbers, np.exp(2 * z[self._end :])])
        return [np.concatenate(parts) for parts in terms]

    def code_terms_drjit(self, latents: Sequence[Sequence]) -> list[list]:
        """`code_terms` of codes given as lists (size) of Dr.Jit floats, one for each channel."""
        terms = []
        for c, z in enumerate(latents):
            gain, *others = z[self._lobe : self._end]
            scaled = [x * factor for x, factor in zip(others, self._scale[1:], strict=True)]
            stretch2 = [dr.exp(2 * x) for x in z[self._end :]]
            terms.append([*(z[i] for i in self._kind.numbers(c)), gain, *scaled, *stretch2])
        return terms

    def f_of_terms(self, terms: Sequence[Sequence], wi, wo) -> list:
        """f of each channel, from a list of Dr.Jit floats, its terms, for each.

        Exchanging wi and wo gives the same bits.
        """
        two, rests = self._kind.widths == 2, list[Any]()
        count, looked_up = len(self._scale) + two, dict[Any, list]()
        for channel in terms:
            gain, *numbers = channel[-count:]
            stretch2 = numbers.pop() if two else None
            key = None if stretch2 is None else stretch2.index  # of the variable
            if key not in looked_up:
                looked_up[key] = self._table.at(wi, wo, stretch2)
            mean, *functions = looked_up[key]
            log = mean * self._scale[0] + gain
            for number, function in zip(numbers, functions, strict=True):
                log = dr.fma(number, function, log)
            rest = dr.exp(dr.clip(log, MIN_LOG, MAX_LOG))
            if self._faint:  # the derivative passes the bound, so that an optimiser can leave black
                rest = rest - self._faint
                rest = rest + dr.detach(dr.maximum(-rest, 0))
            rests.append(rest)
        lobes = self._kind.complete([channel[:-count] for channel in terms])
        return lobe.with_rests(lobes, rests, wi, wo, self._kind)
