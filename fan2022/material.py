"""Materials of the paper's networks: projected, layered, evaluated and sampled in NumPy."""

import os
import warnings
from dataclasses import dataclass
from typing import Any

import numpy as np
import numpy.typing as npt

from fan2022.architecture import LATENT
from fan2022.inference import GaussianMixture, proxy
from fan2022.networks import PaperNetworks, projection_pairs
from urushi import checks, files
from urushi.checks import CoatParameters
from urushi.core.namespace import NUMPY, components, stacked
from urushi.errors import FileError, ParameterError, UrushiWarning
from urushi.material.material import FORMAT_VERSION
from urushi.material.source import source_name
from urushi.material.values import evaluate_source
from urushi.nets.weights import check_made_with
from urushi.parallel import fill_blocks
from urushi.walk import Dielectric

#: Networks, or their file.
Networks = PaperNetworks | str | os.PathLike


@dataclass(frozen=True, eq=False)
class Material:
    """A BRDF as codes of the paper's networks. Make it with `encode`, `layer` or `load`.

    Attributes:
        latents: float32 (C, 32), one code per channel (C = 3 for RGB, 1 for grey). The networks
            interpolate them: a blend of two materials has the blend of their codes.
        networks: the networks.
    """

    latents: np.ndarray
    networks: PaperNetworks

    def __post_init__(self) -> None:
        try:
            latents = np.array(self.latents, np.float32)
        except (TypeError, ValueError) as error:
            raise ParameterError("a material's latents must be an array of numbers") from error
        if latents.ndim != 2 or latents.shape[1] != LATENT or not np.isfinite(latents).all():
            raise ParameterError(
                f"a material's latents have shape {latents.shape}; give finite (channels, {LATENT})"
            )
        object.__setattr__(self, "latents", latents)

    def f(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Return float32 (N, C) [1/sr] for unit vectors (N, 3); never negative, not reciprocal.

        It is zero where either direction is below the horizon.
        """
        wi, wo = checks.directions(wi, wo)
        f = np.empty((len(wi), len(self.latents)), np.float32)
        codes, pairs = self.latents[None], (wi[:, None], wo[:, None])
        fill_blocks(f[..., None], lambda *part: self.networks.f(*part)[..., None], codes, *pairs)
        return np.where(((wi[:, 2] > 0) & (wo[:, 2] > 0))[:, None], f, np.float32(0))

    def pdf(self, wi: npt.ArrayLike, wo: npt.ArrayLike) -> np.ndarray:
        """Return the density (N,) [1/sr] of `sample`; zero where a direction is below the horizon.

        All channels share one proposal, of the mean code.
        """
        wi, wo = map(components, checks.directions(wi, wo))
        return self._proposal().pdf(wi, wo, NUMPY)

    def sample(self, wi: npt.ArrayLike, u: npt.ArrayLike) -> tuple[np.ndarray, np.ndarray]:
        """Draw directions (N, 3) and their densities (N,) from uniform numbers u (N, 3).

        wi: unit vectors (N, 3) above the horizon.
        """
        wi = checks.direction(wi, "wi")
        choice, *numbers = checks.uniform(u, len(wi)).T
        drawn = self._proposal().sample(components(wi), choice, numbers, NUMPY)
        wo = stacked(drawn)
        return wo, self.pdf(wi, wo)

    def _proposal(self) -> GaussianMixture:
        """The proposal of the mean code."""
        return proxy(self.networks.params, self.latents.mean(axis=0))

    def save(self, path: str | os.PathLike) -> None:
        """Write the codes and the fingerprint of the networks to a safetensors file.

        Raises:
            FileError: the file cannot be written.
        """
        description = {"version": FORMAT_VERSION, "weights": self.networks.fingerprint}
        files.write_tensors(path, "material", description, {"latents": self.latents})


def load(path: str | os.PathLike, networks: Networks) -> Material:
    """Read a material that `Material.save` wrote; networks: those of the material, or their file.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    networks = _read(networks)
    description, arrays = files.read_tensors(path, "material", FORMAT_VERSION)
    check_made_with(path, description.get("weights"), networks.fingerprint)
    try:
        return Material(arrays["latents"], networks)
    except (KeyError, ParameterError) as error:
        raise FileError(f"the material file '{path}' is damaged: {error}") from error


def _read(networks: Networks) -> PaperNetworks:
    """Networks that a user gave, or those of the file."""
    return networks if isinstance(networks, PaperNetworks) else PaperNetworks.read(networks)


def encode(source: Any, networks: Networks) -> Material:
    """Project a BRDF into codes, one per channel; see `PaperNetworks.encode` for the time.

    source: as of `urushi.encode`; it is averaged to be isotropic and reciprocal. networks: the
        networks, or their file.

    Raises:
        ParameterError: the source cannot be encoded, or its values are negative or not finite.

    Warns:
        UrushiWarning: averaging changes the source by more than 10 %, or transmitted or specular
            light is left out.
    """
    networks = _read(networks)
    if isinstance(source, Material) and source.networks.fingerprint == networks.fingerprint:
        return source
    values, deviations = evaluate_source(source, *projection_pairs())
    for sentence in deviations.warnings():
        warnings.warn(f"encode {source_name(source)}: {sentence}", UrushiWarning, stacklevel=2)
    return Material(networks.encode(values.T), networks)


def layer(
    top: Dielectric,
    bottom: Material,
    *,
    albedo: npt.ArrayLike = checks.DEFAULT_COAT.albedo,
    sigma_t: npt.ArrayLike = checks.DEFAULT_COAT.sigma_t,
    g: npt.ArrayLike = checks.DEFAULT_COAT.g,
) -> Material:
    """Coat a material; the arguments have the meaning that `urushi.layer` gives them.

    Raises:
        ParameterError: a parameter is out of range or of a wrong shape, the coat has two widths, or
            its index is below one.
    """
    if not (isinstance(top, Dielectric) and isinstance(bottom, Material)):
        raise ParameterError(
            f"layer needs a urushi.dielectric over a fan2022.Material, not "
            f"{type(top).__name__} over {type(bottom).__name__}; make the bottom by fan2022.encode"
        )
    coat = checks.coat(CoatParameters(top.alpha, top.eta, albedo, sigma_t, g), "the coat's")
    return Material(bottom.networks.layer(bottom.latents, coat), bottom.networks)
