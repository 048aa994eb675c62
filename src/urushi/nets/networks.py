"""Urushi's codes by a linear basis, with the network that layers them, as one value."""

import json
from dataclasses import asdict, dataclass
from typing import Any, NamedTuple

import numpy as np

from urushi.checks import CoatParameters
from urushi.core.stretched import features_of
from urushi.core.table import SHAPE
from urushi.errors import ParameterError
from urushi.nets import basis, layerer, proposal
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.code_fit import solve_codes, solve_stretched
from urushi.nets.features import COAT_FEATURES
from urushi.nets.lobe import LOBE_FEATURES, NUMBERS
from urushi.nets.lobe_fit import fit_lobes
from urushi.nets.mlp import POLYNOMIALS, Params, shapes_of
from urushi.nets.stretched_basis import StretchedBasis, log_stretch


@dataclass(frozen=True)
class Architecture:
    """Sizes of codes and of the layering network.

    Attributes:
        functions: K, of the basis, with the constant one.
        probes: number of pairs at which f must be known for a code.
        layerer: widths of its hidden layers, at least one.
        activation: one of `mlp.POLYNOMIALS`, for all hidden layers.
        widths: GGX widths of a surface.
        azimuthal: of two widths, the numbers of functions, the last ones, that are multiplied by
            each of the factors of `core.stretched`.
    """

    functions: int = 24
    probes: int = 256
    layerer: tuple[int, ...] = (224, 224, 224)
    activation: str = "silu7"
    widths: int = 1
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
        """The factor (1 + K,) of mean and functions, see `StretchedBasis`."""
        counts = [1 + self.functions - sum(self.azimuthal), *self.azimuthal]
        return np.repeat(np.arange(len(counts)), counts)

    def to_json(self) -> str:
        """The sizes as a JSON object."""
        return json.dumps(asdict(self))

    @classmethod
    def from_json(cls, text: str) -> "Architecture":
        """Read `to_json`'s text; a ParameterError for anything else."""
        try:
            return cls(**json.loads(text))
        except (TypeError, ValueError) as error:
            raise ParameterError(f"the architecture is not valid: {error}") from error

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
    basis: Basis | StretchedBasis

    @classmethod
    def of(cls, params: Params, arch: Architecture) -> "Networks":
        """From checked parameters."""
        rows, *parts = (
            np.asarray(params[f"basis.{name}"]) for name in ("rows", "measure", "prior")
        )
        if arch.widths == 2:
            return cls(params, arch, StretchedBasis(rows, arch.factors, *parts))
        return cls(params, arch, Basis.of(rows, *parts))

    def pairs(self) -> tuple[np.ndarray, np.ndarray]:
        """The probe pairs wi, wo: float32 (P, 3)."""
        return self.basis.pairs()

    def features(self, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        """What `rest` needs of pairs (..., 3) above the horizon, (..., D).

        The functions for one width, the `core.stretched.features_of` for two.
        """
        if isinstance(self.basis, StretchedBasis):
            return features_of(*np.broadcast_arrays(wi, wo))
        return self.basis.at(wi, wo)

    def functions(self, z: np.ndarray, features: np.ndarray) -> np.ndarray:
        """The functions (P, 1 + K) of a code z (L,), from `features` (P, D)."""
        if isinstance(self.basis, StretchedBasis):
            return self.basis.at(features, z[-1])
        return features

    def encode(self, f: Any, lobe: Any = None) -> Any:
        """Codes (..., L) of values f (..., P) [1/sr] at the probe pairs.

        With two widths, channels, the last axis but one, share the stretch.

        lobe: (..., N) the lobes of these BRDFs, if known; None: `fit_lobes` fits them.
        """
        lobe = fit_lobes(f, self.arch.widths) if lobe is None else lobe
        lobe = np.broadcast_to(lobe, (*f.shape[:-1], self.arch.lobe))
        top = lobes.f(lobe[..., None, :], *self.pairs())
        rest, count = np.maximum(f - top, 0), f.shape[-1]
        flat = rest.reshape(-1, count)
        if isinstance(self.basis, StretchedBasis):
            mean = rest.mean(axis=-2, keepdims=True) if rest.ndim > 1 else rest
            stretch = log_stretch(mean.reshape(-1, count), self.basis.measure)
            stretch = np.broadcast_to(stretch.reshape(mean.shape[:-1]), rest.shape[:-1]).ravel()
            codes = solve_stretched(self.basis, flat, stretch)
        else:
            codes = solve_codes(self.basis, flat)
        codes = codes.reshape(*f.shape[:-1], self.arch.rest)
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
        rest = z[..., self.arch.lobe :]
        if isinstance(self.basis, Basis):
            return basis.decode(rest, features)
        numbers, stretch = rest[..., :-1], rest[..., -1]
        if (stretch == stretch.flat[0]).all():
            rows = self.basis.at(features.reshape(-1, features.shape[-1]), stretch.flat[0])
            return basis.decode(numbers, rows.reshape(*features.shape[:-1], -1))
        shape = np.broadcast_shapes(stretch.shape, features.shape[:-1])
        stretch, result = np.broadcast_to(stretch, shape), np.empty(shape, np.float32)
        numbers, features = (np.broadcast_to(x, (*shape, x.shape[-1])) for x in (numbers, features))
        for own in np.unique(stretch):
            at = stretch == own
            result[at] = basis.decode(numbers[at], self.basis.at(features[at], own))
        return result

    def rest_at_all(self, z: np.ndarray, features: np.ndarray) -> np.ndarray:
        """`rest` (S, P) of all codes z (S, L) at all of the same pairs' features (P, D)."""
        if isinstance(self.basis, Basis):
            return basis.decode(z[:, None, self.arch.lobe :], features)
        result = np.empty((len(z), len(features)), np.float32)
        for own in np.unique(z[:, -1]):
            at = z[:, -1] == own
            numbers = z[at, None, self.arch.lobe : -1]
            result[at] = basis.decode(numbers, self.basis.at(features, own))
        return result

    def table(self, z: np.ndarray) -> np.ndarray | None:
        """ln f of the rests of codes (C, L): float32 (*`SHAPE`, C); None without rests.

        With two widths, it has one more axis of `1 + core.stretched.FACTORS` terms.
        """
        if (self.gains(z) <= basis.EMPTY_GAIN).all():
            return None
        if isinstance(self.basis, StretchedBasis):
            return self.basis.contracted(z[:, self.arch.lobe :])
        logs = basis.decode_log(z[:, None, self.arch.lobe :], self.basis.rows)
        return logs.T.reshape(*SHAPE, len(z))

    def gains(self, z: np.ndarray) -> np.ndarray:
        """The logarithmic gains (...) of the rests of codes z (..., L), a view."""
        return z[..., self.arch.lobe]

    def rest_scaled(self, z: Any, factor: Any) -> Any:
        """Codes (..., L) with `factor` (...) > 0 times the rest, and the same lobe."""
        lobe = self.arch.lobe
        return np.concatenate([z[..., :lobe], basis.scaled(z[..., lobe:], factor)], axis=-1)

    def empty_rest(self) -> np.ndarray:
        """The numbers (K,) of a rest that is zero; of two widths (K + 1,)."""
        rest = np.zeros(self.arch.rest, np.float32)
        rest[0] = basis.EMPTY_GAIN
        return rest

    def proposal(self, z: Any, wi: Any) -> tuple[Any, Any]:
        """`proposal.mixture` of codes z (..., L) for wi (..., 3) above the horizon."""
        return proposal.mixture(self.params, self.arch.widths, z, wi)
