"""Proposals of codes in Dr.Jit: the counterpart of `nets.proposal`."""

from collections.abc import Sequence
from functools import partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import Widths
from urushi.core.mixture import Mixture
from urushi.core.namespace import DRJIT, stacked
from urushi.mitsuba.latents.lobe import LobeKind, passed, reflectance, width_of
from urushi.mitsuba.tables import interpolated, padded
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.proposal import ALPHAS, mixture, weights, widths_of
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

    def proposal_of_table(self, table: Sequence, wi) -> Mixture:
        """The mixture for wi, linear in the cosine's root between nodes."""
        rows, own = table
        place = dr.sqrt(dr.select(wi.z > 0, wi.z, 0))
        numbers = interpolated(rows, [len(ROOTS)], [place])[: len(ALPHAS) + 2]
        *sides, log_stretch = (dr.gather(mi.Float, own, i) for i in range(self._kind.widths + 1))
        width = Widths(*sides) if self._kind.widths == 2 else sides[0]
        return Mixture(numbers, widths_of(width, log_stretch, DRJIT))

    def proposal_of_terms(
        self, lobe: Sequence, terms: Sequence, wi, log_stretch: Any = 0.0
    ) -> Mixture:
        """The mixture of the lobe of a code, and of its terms, see `nets.proposal.code_terms`.

        log_stretch: the last number of a code of two widths.
        """
        own, fresnel = width_of(lobe, self._kind), partial(reflectance, lobe, kind=self._kind)
        through = passed(lobe, wi, self._kind)
        numbers = weights(terms, self._overlaps, own, fresnel, wi.z, DRJIT, through)
        return Mixture(numbers, widths_of(own, log_stretch, DRJIT))
