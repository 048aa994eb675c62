"""Urushi's codes by a linear basis, with the network that layers them, as one value."""

import json
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.table import SHAPES
from urushi.errors import ParameterError
from urushi.nets import basis, layerer, proposal
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.code_fit import solve_codes
from urushi.nets.features import COAT_FEATURES
from urushi.nets.lobe import LOBE_FEATURES, NUMBERS
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.mlp import POLYNOMIALS, Params, shapes_of


@dataclass(frozen=True)
class LinearArchitecture:
    """Sizes of codes and of the layering network.

    Attributes:
        functions: K, of the basis, with the constant one.
        probes: number of pairs at which f must be known for a code.
        layerer: widths of its hidden layers, at least one.
        activation: one of `mlp.POLYNOMIALS`, for all hidden layers.
        widths: GGX widths of a surface.
    """

    functions: int = 24
    probes: int = 256
    layerer: tuple[int, ...] = (224, 224, 224)
    activation: str = "silu7"
    widths: int = 1

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
        object.__setattr__(self, "layerer", tuple(self.layerer))

    @property
    def lobe(self) -> int:
        """Number of numbers of a code that describe its analytic lobe, see `nets.lobe`."""
        return len(NUMBERS[self.widths])

    @property
    def latent(self) -> int:
        """Number of numbers of a code."""
        return self.lobe + self.functions

    def to_json(self) -> str:
        """The sizes as a JSON object."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> "LinearArchitecture":
        """Read `to_json`'s text; a ParameterError for anything else."""
        try:
            return cls(**json.loads(text))
        except (TypeError, ValueError) as error:
            raise ParameterError(f"the architecture is not valid: {error}") from error

    def parameter_shapes(self) -> dict[str, tuple[int, ...]]:
        """Every parameter's shape by name."""
        nodes, k = int(np.prod(SHAPES[self.widths])), self.functions
        shapes: dict[str, tuple[int, ...]] = {
            "basis.rows": (nodes, 1 + k),
            "basis.measure": (self.probes,),
            "basis.prior": (k, k),
            "proposal.weight": (k, proposal.TERMS),
            "proposal.bias": (proposal.TERMS,),
            "proposal.overlap": (len(proposal.ALPHAS),),
        }
        inputs = k + LOBE_FEATURES[self.widths] + COAT_FEATURES[self.widths]
        return shapes | shapes_of("layerer", (inputs, *self.layerer, k))


class LinearNetworks(NamedTuple):
    """Codes, layering and proposals of a `LinearArchitecture`.

    A code z (..., L) represents one monochrome BRDF. Leading dimensions broadcast.
    """

    params: Params
    arch: LinearArchitecture
    basis: Basis

    @classmethod
    def of(cls, params: Params, arch: LinearArchitecture) -> "LinearNetworks":
        """The networks of checked parameters."""
        parts = (np.asarray(params[f"basis.{name}"]) for name in ("rows", "measure", "prior"))
        return cls(params, arch, Basis.of(*parts, arch.widths))

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (P, 3)."""
        return self.basis.pairs()

    def features(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """The functions (..., 1 + K) of pairs (..., 3) above the horizon, for `rest`."""
        return self.basis.at(wi, wo)

    def encode(self, f: Any, lobe: Any = None) -> Any:
        """Codes (..., L) of values f (..., P) [1/sr] at the probe pairs.

        lobe: (..., N) the lobes of these BRDFs, if known; None: `fit_lobes` fits them.
        """
        lobe = fit_lobes(f, self.arch.widths) if lobe is None else lobe
        lobe = np.broadcast_to(lobe, (*f.shape[:-1], self.arch.lobe))
        top = lobes.f(lobe[..., None, :], *self.pairs())
        rest, count = np.maximum(f - top, 0), f.shape[-1]
        codes = solve_codes(self.basis, rest.reshape(-1, count), top.reshape(-1, count))
        codes = codes.reshape(*f.shape[:-1], self.arch.functions)
        return np.concatenate([lobe, codes], axis=-1, dtype=np.float32)

    def layer(self, z_bottom: Any, coat: CoatParameters) -> Any:
        """Codes (..., L) of bottoms under coats."""
        return layerer.layer(self.params, self.arch, z_bottom, coat)

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """Values (...) [1/sr]: positive, and the same bits with wi and wo exchanged.

        z (..., L) and the unit vectors wi, wo (..., 3) above the horizon broadcast.
        """
        return self.top(z, wi, wo) + self.rest(z, self.features(wi, wo))

    def top(self, z: Any, wi: Any, wo: Any) -> Any:
        """The part of f (...) [1/sr] that the codes' lobes reflect."""
        return lobes.f(z[..., : self.arch.lobe], wi, wo)

    def rest(self, z: Any, features: Any) -> Any:
        """The rest of f (...) [1/sr], from `features`."""
        return basis.decode(z[..., self.arch.lobe :], features)

    def rest_at_all(self, z: np.ndarray, features: np.ndarray) -> np.ndarray:
        """`rest` (S, P) of all codes z (S, L) at all of the same pairs' features (P, 1 + K)."""
        return basis.decode(z[:, None, self.arch.lobe :], features)

    def table(self, z: np.ndarray) -> np.ndarray | None:
        """ln f of the rests of codes (C, L): float32 (*`SHAPES[widths]`, C); None without rests."""
        if (self.gains(z) <= basis.EMPTY_GAIN).all():
            return None
        logs = basis.decode_log(z[:, None, self.arch.lobe :], self.basis.rows)
        return logs.T.reshape(*SHAPES[self.arch.widths], len(z))

    def gains(self, z: np.ndarray) -> np.ndarray:
        """The logarithmic gains (...) of the rests of codes z (..., L), a view."""
        return z[..., self.arch.lobe]

    def rest_scaled(self, z: Any, factor: Any) -> Any:
        """Codes (..., L) with `factor` (...) > 0 times the rest, and the same lobe."""
        lobe = self.arch.lobe
        return np.concatenate([z[..., :lobe], basis.scaled(z[..., lobe:], factor)], axis=-1)

    def without_rest(self, z: Any) -> Any:
        """Codes (..., L) of the lobes alone: the rest has the least value."""
        codes = np.array(z)
        codes[..., self.arch.lobe :] = self.empty_rest()
        return codes

    def empty_rest(self) -> np.ndarray:
        """The code (K,) of a rest that is zero."""
        rest = np.zeros(self.arch.functions, np.float32)
        rest[0] = basis.EMPTY_GAIN
        return rest

    def proposal(self, z: Any, wi: Any) -> tuple[Any, Any]:
        """`proposal.mixture` of codes z (..., L) for wi (..., 3) above the horizon."""
        return proposal.mixture(self.params, self.arch.widths, z, wi)
