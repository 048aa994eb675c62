"""Proposals of codes in Dr.Jit: the counterpart of `nets.proposal`."""

from collections.abc import Sequence
from functools import partial

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT
from urushi.mitsuba.networks import mlp
from urushi.mitsuba.networks.lobe import LobeKind, reflectance
from urushi.mitsuba.networks.sampler import UrushiSampler
from urushi.mitsuba.networks.table import interpolated, padded
from urushi.nets.linear import LinearArchitecture
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.proposal import ALPHAS, mixture, weights
from urushi.nets.weights import Model

#: Roots of the cosines at which the weights of one code are tabulated: most at grazing angles,
#: where they change most.
ROOTS = np.linspace(0.0, 1.0, 129)


class CodeProposals:
    """Proposals from latent codes and the cosine of wi, see `nets.proposal`.

    The weights of one code are tabulated by the cosine.
    """

    def __init__(self, model: Model, kind: LobeKind):
        """kind: common properties of the codes' lobes."""
        self._params, self._kind, self._lobe = model.params, kind, model.arch.lobe
        self._weight = model.params["proposal.weight"]
        self._bias = model.params["proposal.bias"].tolist()
        self._overlaps = model.params["proposal.overlap"].tolist()

    def tabulated(self, latent: np.ndarray) -> list[np.ndarray]:
        """Tables of a latent code (size,): the weights at `ROOTS`, and the widths of its lobe."""
        cosine = ROOTS**2
        wi = np.stack([np.sqrt(1 - cosine**2), 0 * cosine, cosine], axis=-1).astype(np.float32)
        code = latent[None].astype(np.float32)
        rows, _ = mixture(self._params, self._kind.widths, code, wi)
        return [padded(rows), latent[list(WIDTH_PLACES[self._kind.widths])].astype(np.float32)]

    def proposal_of_table(self, table: Sequence, wi) -> Mixture:
        """The mixture for wi, linear in the cosine's root between nodes."""
        rows, own = table
        place = dr.sqrt(dr.select(wi.z > 0, wi.z, 0))
        numbers = interpolated(rows, [len(ROOTS)], [place])[: len(ALPHAS) + 2]
        sides = [dr.gather(mi.Float, own, side) for side in range(self._kind.widths)]
        return self._mixture(numbers, sides)

    def proposal(self, latent: Sequence, wi) -> Mixture:
        """The mixture of a latent code, a list (size) of Dr.Jit floats."""
        terms = mlp.dense(latent[self._lobe :], self._weight, self._bias)
        sides = [latent[place] for place in WIDTH_PLACES[self._kind.widths]]
        own = sides[0] if len(sides) == 1 else Widths(*sides)
        fresnel = partial(reflectance, latent[: self._lobe], kind=self._kind)
        return self._mixture(weights(terms, self._overlaps, own, fresnel, wi.z, DRJIT), sides)

    def _mixture(self, numbers: Sequence, sides: Sequence) -> Mixture:
        """The mixture of weights, and of lobes with the code's own widths and `ALPHAS`."""
        if len(sides) == 1:
            return Mixture(numbers, [*sides, *ALPHAS])
        return Mixture(numbers, [Widths(*sides), *(Widths(a, a) for a in map(mi.Float, ALPHAS))])


def proposals_of(model: Model, kind: LobeKind) -> CodeProposals | UrushiSampler:
    """Proposals of codes of a basis, or of networks that are still to be replaced by one."""
    linear = isinstance(model.arch, LinearArchitecture)
    return CodeProposals(model, kind) if linear else UrushiSampler(model, kind)
