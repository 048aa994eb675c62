"""The sampler in Dr.Jit: the counterpart of `nets.sampler`."""

from collections.abc import Sequence
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.networks import mlp
from urushi.mitsuba.networks.lobe import LobeKind, lobe_features
from urushi.mitsuba.networks.table import interpolated, padded
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.sampler import mixture, sampler_columns, weights_and_widths
from urushi.nets.weights import Model

#: Roots of the cosines at which the proposals of one code are tabulated, by the number of GGX
#: widths: most at grazing angles, where proposals change most.
_ROOTS = {1: np.linspace(0.0, 1.0, 129), 2: np.linspace(0.0, 1.0, 65)}

#: Squares of the cosine of the azimuth at which they are tabulated for each root.
_AZIMUTHS = {1: np.ones(1), 2: np.linspace(0.0, 1.0, 9)}


class UrushiSampler:
    """Proposals from latent codes and the cosine of wi.

    A proposal is a mixture of GGX reflection lobes and a cosine lobe (`core.mixture`), whose
    weights and widths the network gives; the first width is the width of the code's lobe. Weights
    and widths of one code depend on the cosine of wi, and on its azimuth if there are two GGX
    widths. They are tabulated: two or four entries of a table take half the network's time.
    """

    def __init__(self, model: Model, kind: LobeKind):
        """kind: common properties of the codes' lobes."""
        params = model.params
        self._hidden = partial(
            mlp.hidden_to_output, params, "sampler", activation=model.arch.activation
        )
        self._arch, self._kind = model.arch, kind
        self._params = params
        self._weight, self._bias = params["sampler.0.weight"], params["sampler.0.bias"]

    def tabulated(self, latent: np.ndarray) -> list[np.ndarray]:
        """Tables of a latent code (size,): the proposals at the nodes, and the lobe's own widths.

        A row has a node's weights, the widths of the network's lobes along the tangent, and those
        across it if there are two. The azimuth is the fastest.
        """
        widths = self._arch.widths
        nodes = np.meshgrid(_ROOTS[widths] ** 2, _AZIMUTHS[widths], indexing="ij")
        cosine, along = (x.ravel() for x in nodes)
        sine = np.sqrt(1 - cosine**2)
        wi = np.stack([sine * np.sqrt(along), sine * np.sqrt(1 - along), cosine], axis=-1)
        codes = latent[None].astype(np.float32)
        weights, alphas = mixture(self._params, self._arch, codes, wi.astype(np.float32))
        sides = [alphas.u, alphas.v] if isinstance(alphas, Widths) else [alphas]
        rows = np.concatenate([weights, *(side[:, 1:] for side in sides)], axis=-1)
        return [padded(rows), np.stack([side[0, 0] for side in sides])]

    def proposal_of_table(self, table: Sequence, wi) -> Mixture:
        """The mixture for wi, linear in the cosine's root and in the azimuth between nodes."""
        rows, own = table
        widths, lobes = self._arch.widths, self._arch.lobes
        shape, place = [len(_ROOTS[widths])], [dr.sqrt(dr.select(wi.z > 0, wi.z, 0))]
        if widths == 2:
            x2 = wi.x * wi.x
            shape.append(len(_AZIMUTHS[widths]))
            place.append(x2 / dr.maximum(x2 + wi.y * wi.y, 1e-12))
        numbers = interpolated(rows, shape, place)
        sides = [
            [dr.gather(mi.Float, own, side), *numbers[lobes + 2 + side * lobes :][:lobes]]
            for side in range(widths)
        ]
        return _mixture(numbers[: lobes + 2], sides)

    def proposal(self, latent: Sequence, wi) -> Mixture:
        """The mixture from a latent code, a list (size) of Dr.Jit floats, by the network."""
        lobe = self._arch.lobe
        inputs = [*lobe_features(latent[:lobe], self._kind), *latent[lobe:]]
        inputs += sampler_columns(wi, self._arch.widths, DRJIT)
        first = mlp.dense(inputs, self._weight, self._bias.tolist())
        own = [latent[place] for place in WIDTH_PLACES[self._arch.widths]]
        return _mixture(*weights_and_widths(self._hidden(first), own, DRJIT))


def _mixture(weights: Sequence, sides: Sequence[Sequence]) -> Mixture:
    """The proposal of lobes with widths along the tangent, and across it if there are two."""
    if len(sides) == 1:
        return Mixture(weights, sides[0])
    return Mixture(weights, [Widths(u, v) for u, v in zip(*sides, strict=True)])
