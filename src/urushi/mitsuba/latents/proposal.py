"""Proposals of codes in Dr.Jit: the counterpart of `nets.proposal`."""

from collections.abc import Sequence
from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT, stacked
from urushi.mitsuba.latents.lobe import LobeKind, passed, reflectance
from urushi.mitsuba.tables import interpolated, padded
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.proposal import ALPHAS, LARGEST_STRETCH, mixture, stretched_widths, weights
from urushi.nets.weights import Model

#: Roots of the cosines at which the weights of one code are tabulated: most at grazing angles,
#: where they change most.
ROOTS = np.linspace(0.0, 1.0, 129)


class CodeMixture(NamedTuple):
    """The proposal of a code for one wi; see `core.mixture.Mixture`.

    The widths that all codes share are constants in kernels, not values of a vertex.
    """

    weights: Sequence  # of the own lobe, of `ALPHAS` and of the cosine lobe
    own: Any  # the width of the own lobe, or its `Widths`
    stretch: Sequence  # s of two widths, nothing for one

    @property
    def mixture(self) -> Mixture:
        """The mixture with all widths."""
        fixed = stretched_widths(self.stretch[0]) if self.stretch else ALPHAS
        return Mixture(self.weights, [self.own, *fixed])

    def pdf(self, wi, wo):
        """Density of `sample` at wo [1/sr]."""
        return self.mixture.pdf(wi, wo)

    def sample(self, wi, choice, u):
        """Draw wo; see `Mixture.sample`."""
        return self.mixture.sample(wi, choice, u)


class CodeProposals:
    """Proposals from latent codes and the cosine of wi, see `nets.proposal`.

    The weights of one code are tabulated by the cosine.
    """

    def __init__(self, model: Model, kind: LobeKind):
        """kind: common properties of the codes' lobes."""
        self._params, self._kind = model.params, kind
        self._overlaps = model.params["proposal.overlap"].tolist()

    def tabulated(self, latent: np.ndarray) -> list[np.ndarray]:
        """Tables of a latent code (size,): the weights at `ROOTS`, and the widths of its lobe."""
        cosine = ROOTS**2
        sine = np.sqrt(0.5 - 0.5 * cosine**2)  # halfway between the axes of two widths
        wi = np.stack([sine, sine, cosine], axis=-1).astype(np.float32)
        code = latent[None].astype(np.float32)
        rows = stacked(mixture(self._params, self._kind.widths, code, wi).weights)
        places = [*WIDTH_PLACES[self._kind.widths], -1]  # the last: ln s of two widths
        return [padded(rows), latent[places].astype(np.float32)]

    def proposal_of_table(self, table: Sequence, wi) -> CodeMixture:
        """The mixture for wi, linear in the cosine's root between nodes."""
        rows, own = table
        place = dr.sqrt(dr.select(wi.z > 0, wi.z, 0))
        numbers = interpolated(rows, [len(ROOTS)], [place])[: len(ALPHAS) + 2]
        *sides, stretch = (dr.gather(mi.Float, own, i) for i in range(self._kind.widths + 1))
        return CodeMixture(numbers, of_sides(sides), stretch_of(sides, stretch))

    def proposal_of_terms(
        self, lobe: Sequence, terms: Sequence, wi, log_stretch: Any = 0.0
    ) -> CodeMixture:
        """The mixture of the lobe of a code, and of its terms, see `nets.proposal.code_terms`.

        log_stretch: the last number of a code of two widths.
        """
        sides = [lobe[place] for place in WIDTH_PLACES[self._kind.widths]]
        own, fresnel = of_sides(sides), partial(reflectance, lobe, kind=self._kind)
        through = passed(lobe, wi, self._kind)
        numbers = weights(terms, self._overlaps, own, fresnel, wi.z, DRJIT, through)
        return CodeMixture(numbers, own, stretch_of(sides, log_stretch))


def of_sides(sides: Sequence) -> Any:
    """The width, or the `Widths` of two."""
    return sides[0] if len(sides) == 1 else Widths(*sides)


def stretch_of(sides: Sequence, log_stretch: Any) -> list:
    """s of a code of two widths, from ln s; nothing for one width."""
    limit = LARGEST_STRETCH
    return [dr.exp(dr.clip(log_stretch, -limit, limit))] if len(sides) == 2 else []
