"""Urushi's codes by a linear basis, with the network that layers them, as one value."""

import json
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.mixture import Mixture
from urushi.core.stretched import FACTORS
from urushi.core.table import SHAPE
from urushi.errors import ParameterError
from urushi.nets import basis, layerer, proposal, transmittance
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis, Functions
from urushi.nets.code_fit import log_stretch, solve_codes
from urushi.nets.features import COAT_FEATURES
from urushi.nets.lobe import LOBE_FEATURES, NUMBERS
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.mlp import POLYNOMIALS, Params, shapes_of
from urushi.parallel import fill_blocks


@dataclass(frozen=True)
class Architecture:
    """Sizes of codes and of the layering network."""

    functions: int = 32  # K, of the basis, with the constant one
    probes: int = 256  # number of pairs at which f must be known for a code
    layerer: tuple[int, ...] = (256, 256, 256)  # widths of its hidden layers, at least one
    activation: str = "silu7"  # one of `mlp.POLYNOMIALS`, for all hidden layers
    widths: int = 1  # GGX widths of a surface
    # Of two widths, the numbers of functions, the last ones, that are multiplied by each of the
    # factors of `core.stretched`
    azimuthal: tuple[int, ...] = ()

    def __post_init__(self) -> None:
        if self.widths not in NUMBERS:
            raise ParameterError(f"architecture's widths is {self.widths!r}; it must be 1 or 2")
        for name in ("functions", "probes"):
            if getattr(self, name) not in range(1, 1 << 16):
                raise ParameterError(
                    f"architecture's {name} is {getattr(self, name)!r}; it must be a positive "
                    "integer"
                )
        if self.activation not in POLYNOMIALS:
            raise ParameterError(f"architecture's activation is unknown: {self.activation!r}")
        for name in ("layerer", "azimuthal"):
            object.__setattr__(self, name, tuple(getattr(self, name)))
        counts, most = self.azimuthal, FACTORS * (self.widths == 2)
        whole = all(isinstance(count, int) and count >= 0 for count in counts)
        if not whole or len(counts) > most or sum(counts) >= self.functions:
            raise ParameterError(
                f"architecture's azimuthal is {counts!r}; it must be at most {most} numbers of "
                f"functions, fewer than {self.functions} in all"
            )

    @property
    def lobe(self) -> int:
        """Number of numbers of a code that describe its analytic lobe, see `nets.lobe`."""
        return len(NUMBERS[self.widths])

    @property
    def latent(self) -> int:
        """Number of numbers of a code."""
        return self.lobe + self.rest

    @property
    def rest(self) -> int:
        """Number of numbers of a code beside its lobe: those of the functions, and the stretch."""
        return self.functions + (self.widths == 2)

    @property
    def factors(self) -> np.ndarray:
        """The factor (1 + K,) of mean and functions, see `Basis`."""
        counts = [1 + self.functions - sum(self.azimuthal), *self.azimuthal]
        return np.repeat(np.arange(len(counts)), counts)

    def to_json(self) -> str:
        """The sizes as a JSON object."""
        return json.dumps(asdict(self))

    def parameter_shapes(self) -> dict[str, tuple[int, ...]]:
        """Every parameter's shape by name."""
        nodes, k = int(np.prod(SHAPE)), self.functions
        shapes: dict[str, tuple[int, ...]] = {
            "basis.rows": (nodes, 1 + k),
            "basis.measure": (self.probes,),
            "basis.prior": (k, k),
            "proposal.weight": (self.rest, proposal.TERMS),
            "proposal.bias": (proposal.TERMS,),
            "proposal.overlap": (len(proposal.ALPHAS),),
        }
        inputs = self.rest + LOBE_FEATURES[self.widths] + COAT_FEATURES[self.widths]
        return shapes | shapes_of("layerer", (inputs, *self.layerer, self.rest))


class Networks(NamedTuple):
    """Codes, layering and proposals of an `Architecture`.

    A code z (..., L) represents one monochrome BRDF. Leading dimensions broadcast.
    """

    params: Params
    arch: Architecture
    basis: Basis

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (P, 3)."""
        return self.basis.pairs()

    def encode(self, f: np.ndarray, lobe: np.ndarray | None = None) -> np.ndarray:
        """Codes float32 (..., L) of values f (..., P) [1/sr] at the probe pairs.

        With two widths, channels, the last axis but one, share the stretch.

        lobe: (N,) or (..., N) the lobes of these BRDFs, if known; None: `fit_lobes` fits them.
        """
        values = np.asarray(f, np.float32)
        pairs = len(self.basis.measure)
        if not values.ndim or values.shape[-1] != pairs:
            raise ParameterError(f"f has shape {values.shape}; this basis needs (..., {pairs})")
        codes = np.empty((*values.shape[:-1], self.arch.latent), np.float32)
        own = [] if lobe is None else [np.broadcast_to(lobe, (*codes.shape[:-1], self.arch.lobe))]

        def fill(f: np.ndarray, lobe: np.ndarray | None = None) -> np.ndarray:
            lobe = fit_lobes(f, self.arch.widths) if lobe is None else lobe
            rest = transmittance.remainder(f, lobe[..., None, :], *self.pairs())
            return self._encode_rest(rest, lobe)

        return fill_blocks(codes, fill, values, *own)

    def encode_rest(self, rest: np.ndarray, lobe: np.ndarray) -> np.ndarray:
        """Codes float32 (..., L) beside lobes (..., N) of rests (..., P): g at the probe pairs."""
        codes = np.empty((*rest.shape[:-1], self.arch.latent), np.float32)
        lobe = np.broadcast_to(lobe, (*codes.shape[:-1], self.arch.lobe))
        return fill_blocks(codes, self._encode_rest, rest, lobe)

    def _encode_rest(self, rest: np.ndarray, lobe: np.ndarray) -> np.ndarray:
        passed, stretch = transmittance.both_ways(lobe[..., None, :], *self.pairs()), None
        count = rest.shape[-1]
        if self.arch.widths == 2:
            mean = rest.mean(axis=-2, keepdims=True) if rest.ndim > 1 else rest
            stretch = log_stretch(mean.reshape(-1, count), self.basis.measure)
            stretch = np.broadcast_to(stretch.reshape(mean.shape[:-1]), rest.shape[:-1]).ravel()
        rows = rest.reshape(-1, count), passed.reshape(-1, count)
        codes = solve_codes(self.basis, *rows, stretch).reshape(*rest.shape[:-1], self.arch.rest)
        return np.concatenate([lobe, codes], axis=-1, dtype=np.float32)

    def layer(self, z_bottom: Any, coat: CoatParameters) -> Any:
        """Codes (..., L) of bottoms under coats."""
        return layerer.layer(self.params, self.arch, z_bottom, coat)

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """Values (...) [1/sr]: positive, and the same bits with wi and wo exchanged.

        z (..., L) and the unit vectors wi, wo (..., 3) above the horizon broadcast.
        """
        rest = self._rest(z[..., self.arch.lobe :], wi, wo)
        passed = transmittance.both_ways(z[..., : self.arch.lobe], wi, wo)
        return self.top(z, wi, wo) + passed * rest

    def top(self, z: Any, wi: Any, wo: Any) -> Any:
        """The part of f (...) [1/sr] that the codes' lobes reflect."""
        return lobes.f(z[..., : self.arch.lobe], wi, wo)

    def _rest(self, rest: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """g (...) [1/sr], see `nets.basis`."""
        numbers, stretch = self.basis.split(rest)
        if (stretch == stretch.flat[0]).all():
            return basis.decode(numbers, self.basis.at(wi, wo, stretch.flat[0]))
        shape = np.broadcast_shapes(stretch.shape, wi.shape[:-1], wo.shape[:-1])
        stretch, result = np.broadcast_to(stretch, shape), np.empty(shape, np.float32)
        numbers, wi, wo = (np.broadcast_to(x, (*shape, x.shape[-1])) for x in (numbers, wi, wo))
        for own in np.unique(stretch):
            at = stretch == own
            result[at] = basis.decode(numbers[at], self.basis.at(wi[at], wo[at], own))
        return result

    def rest_at_all(self, z: np.ndarray, functions: Functions) -> np.ndarray:
        """The rests of f (S, P) [1/sr] of all codes z (S, L) at the functions of the same pairs."""
        lobe = z[:, None, : self.arch.lobe]
        passed = transmittance.both_ways(lobe, functions.wi, functions.wo)
        return self.g_at_all(z, functions) * passed

    def g_at_all(self, z: np.ndarray, functions: Functions) -> np.ndarray:
        """g (S, P) [1/sr] of all codes z (S, L) at the functions of the same pairs."""
        result = np.empty((len(z), len(functions.wi)), np.float32)
        for rows, numbers, own in self.basis.groups(z[:, self.arch.lobe :]):
            result[rows] = basis.decode(numbers[:, None], functions(own))
        return result

    def table(self, z: np.ndarray) -> np.ndarray | None:
        """`Basis.table` of codes (C, L), of g; None without rests."""
        empty = (self.gains(z) <= basis.EMPTY_GAIN).all()
        return None if empty else self.basis.table(z[:, self.arch.lobe :])

    def gains(self, z: np.ndarray) -> np.ndarray:
        """The logarithmic gains (...) of the rests of codes z (..., L), a view."""
        return z[..., self.arch.lobe]

    def empty_rest(self) -> np.ndarray:
        """The numbers (K,) of a rest that is zero; of two widths (K + 1,)."""
        rest = np.zeros(self.arch.rest, np.float32)
        rest[0] = basis.EMPTY_GAIN
        return rest

    def proposal(self, z: Any, wi: Any) -> Mixture:
        """The proposal of codes z (..., L) for wi (..., 3) above the horizon."""
        return proposal.mixture(self.params, self.arch.widths, z, wi)
