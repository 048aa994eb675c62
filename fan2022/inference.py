"""The paper's networks evaluated: codes and directions to f, coats to codes, codes to proposals.

Unlike Urushi's decoder, the evaluation network takes the coordinates of the directions. It is not
reciprocal, it is isotropic only as far as it has learnt to be, and its output may be negative.

The sampling proposal is a Gaussian on the projected half vector and a cosine lobe. A small network
predicts the Gaussian's width and share from a material's code; neither depends on the direction
(Fan et al. 2022, supplement). The supplement does not define how the outputs become a width and a
share, nor how directions below the horizon are treated. Here the Gaussian is cut off at the unit
disk, and directions below the horizon are mirrored up, so that the density is exactly normalised.
"""

import math
from typing import Any, NamedTuple

import numpy as np

from fan2022 import architecture
from fan2022.architecture import EVALUATION, LAYERING
from urushi.core.namespace import DRJIT, Namespace, arrays
from urushi.nets.mlp import Params, hidden_to_output, linear, split_linear

#: The first layer; its product with the code is shared by all directions.
_FIRST = "evaluation.0"

#: Place of the light's cosine among the direction inputs.
LIGHT_COSINE = 5


def direction_inputs(wi: Any, wo: Any) -> Any:
    """The direction inputs (..., 6): wi.xy, wo.xy, wi.z, wo.z; wi is the view, wo the light."""
    xp = wi.__array_namespace__()
    wi, wo = xp.broadcast_arrays(wi, wo)
    return xp.concat([wi[..., :2], wo[..., :2], wi[..., 2:], wo[..., 2:]], axis=-1)


def evaluate(params: Params, z: Any, directions: Any) -> Any:
    """Return values (...) [1/sr], negative ones included.

    z (..., 32) and `direction_inputs` (..., 6) broadcast against each other.
    """
    first = split_linear(params, _FIRST, directions, z)
    return architecture.apply(params, EVALUATION[1:], first)[..., 0]


def layer(params: Params, z_top: Any, z_bottom: Any, albedo: Any, sigma_t: Any) -> Any:
    """Return codes (..., 32) of bottoms z_bottom (..., 32) under dielectrics z_top (..., 32).

    albedo, sigma_t (...): of the medium between them, which scatters isotropically. Leading
    dimensions broadcast. Codes are close to 1, so the network reads and returns codes minus 1.
    """
    xp = z_top.__array_namespace__()
    medium = xp.stack(xp.broadcast_arrays(albedo, sigma_t), axis=-1)
    parts = [z_top - 1, z_bottom - 1, medium]
    shape = np.broadcast_shapes(*(part.shape[:-1] for part in parts))
    x = xp.concat([xp.broadcast_to(p, (*shape, p.shape[-1])) for p in parts], axis=-1)
    return architecture.apply(params, LAYERING, x) + 1


def isotropic(albedo: Any, sigma_t: Any, g: Any) -> tuple[Any, Any]:
    """Return albedo and sigma_t of the isotropic medium similar to a medium of asymmetry g.

    Similarity relation (van de Hulst 1980): equal absorption, scattering times 1 - g.
    """
    reduced = 1 - albedo * g
    return albedo * (1 - g) / reduced, sigma_t * reduced


#: Least width sigma (the greatest is 1), and least share of either lobe.
MIN_SIGMA, MIN_SHARE = 0.005, 0.02


class GaussianMixture(NamedTuple):
    """The proposal: the Gaussian's width sigma (...) and its share (...) of all samples.

    As `core.mixture.Mixture`: directions have components, which are arrays of `xp`.
    """

    sigma: Any
    share: Any

    @classmethod
    def of_outputs(cls, outputs: Any, xp: Namespace) -> "GaussianMixture":
        """The proposal of the two outputs of the proxy."""
        width, share = map(xp.falling_logistic, outputs)
        return cls(xp.exp(math.log(MIN_SIGMA) * width), MIN_SHARE + (1 - 2 * MIN_SHARE) * share)

    def _spread(self, xp: Namespace) -> tuple[Any, Any]:
        """Twice the Gaussian's variance, and its mass inside the unit disk."""
        variance2 = 2 * self.sigma * self.sigma
        return variance2, 1 - xp.exp(-1 / variance2)

    def pdf(self, wi: Any, wo: Any, xp: Namespace = DRJIT) -> Any:
        """Density of `sample` at wo [1/sr]; 0 where either direction is below the horizon.

        The Jacobian of the projection of the half vector on the disk is its cosine. The Jacobian of
        the reflection is 4 wi.h, twice the length of wi + wo.
        """
        variance2, mass_inside = self._spread(xp)
        x, y = wi.x + wo.x, wi.y + wo.y
        across = x * x + y * y  # the same for wo's mirror image

        def reflected(up: Any) -> Any:
            squared = xp.maximum(across + up * up, 1e-12)
            on_disk = xp.exp(-(across / squared) / variance2) / (math.pi * variance2 * mass_inside)
            return on_disk * xp.absolute(up) / (2 * squared)

        gaussian = reflected(wi.z + wo.z) + reflected(wi.z - wo.z)
        density = self.share * gaussian + (1 - self.share) * (wo.z / math.pi)
        return xp.where((wi.z > 0) & (wo.z > 0), density, 0.0)

    def sample(self, wi: Any, choice: Any, u: Any, xp: Namespace = DRJIT) -> Any:
        """Draw wo above the horizon by uniform numbers: `choice` for the lobe, two `u` for wo."""
        variance2, mass_inside = self._spread(xp)
        squared = xp.clip(-variance2 * xp.log(1 - u[0] * mass_inside), 0.0, 1.0)
        radius, hz = xp.sqrt(squared), xp.sqrt(1 - squared)
        sin, cos = xp.sincos((2 * math.pi) * u[1])
        hx, hy, disk = radius * cos, radius * sin, xp.sqrt(u[0])
        twice = 2 * (wi.x * hx + wi.y * hy + wi.z * hz)
        gaussian = twice * hx - wi.x, twice * hy - wi.y, xp.absolute(twice * hz - wi.z)
        cosine = disk * cos, disk * sin, xp.sqrt(1 - u[0])
        pairs = zip(gaussian, cosine, strict=True)
        return type(wi)(*(xp.where(choice < self.share, a, b) for a, b in pairs))


def proxy(params: Params, z: Any) -> GaussianMixture:
    """Return the proposal of codes z (..., 32)."""
    output = hidden_to_output(params, "proxy", linear(params, "proxy.0", z), "relu")
    return GaussianMixture.of_outputs((output[..., 0], output[..., 1]), arrays(output))
