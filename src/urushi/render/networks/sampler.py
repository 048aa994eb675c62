"""The sampler in Dr.Jit: the counterpart of `nets.sampler`."""

from collections.abc import Sequence

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.checks import MIN_ALPHA, Widths
from urushi.nets.features import MIN_COSINE
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.sampler import MIN_COSINE_SHARE, mixture, sampler_inputs
from urushi.nets.weights import Model
from urushi.physics.mixture import Mixture
from urushi.render.networks import mlp
from urushi.render.networks.cooperative import hidden_layers
from urushi.render.networks.lobe import LobeKind, lobe_features

#: Roots of the cosines at which the proposals of one code are tabulated: most at grazing angles,
#: where they change most.
_ROOTS = np.linspace(0.0, 1.0, 129)


class UrushiSampler:
    """Proposals from latent codes and the cosine of wi; see `protocols.Sampler`.

    A proposal is a mixture of GGX reflection lobes and a cosine lobe (`physics.mixture`), whose
    weights and widths the network gives; the first width is that of the code's own lobe. Those of
    one isotropic code depend on the cosine of wi alone. They are tabulated, because two entries of
    a table take half the time of the network.
    """

    def __init__(self, model: Model, kind: LobeKind, cooperative: bool | None = None):
        """kind: what is known of the codes' lobes. cooperative: see `cooperative.hidden_layers`."""
        params, activation = model.params, model.arch.activation
        self._hidden = hidden_layers(params, "sampler", activation, cooperative)
        self._arch, self._kind = model.arch, kind
        self._params = params
        self._weight, self._bias = params["sampler.0.weight"], params["sampler.0.bias"]

    def tabulated(self, latent: np.ndarray) -> list[np.ndarray]:
        """The table of a latent code (size,): weights and widths at the squares of `_ROOTS`."""
        cosines = np.square(_ROOTS, dtype=np.float32)
        wi = np.stack([np.sqrt(1 - cosines**2), np.zeros_like(cosines), cosines], axis=-1)
        codes = latent[None].astype(np.float32)
        rows = np.concatenate(mixture(self._params, self._arch, codes, wi), axis=-1)
        size = 1 << (rows.shape[-1] - 1).bit_length()  # Dr.Jit gathers powers of two at once
        return [np.pad(rows, [(0, 0), (0, size - rows.shape[-1])])]

    def proposal_of_table(self, table: Sequence, cos_i) -> Mixture:
        """The mixture for wi of cosine cos_i, linear in the cosine's root between entries."""
        (numbers,) = table
        size, last = len(numbers) // len(_ROOTS), len(_ROOTS) - 1
        place = dr.sqrt(dr.select(cos_i > 0, cos_i, 0)) * last
        index = dr.minimum(mi.UInt32(place), last - 1)
        shape, fraction = (size, dr.width(index)), place - mi.Float(index)
        low, high = (dr.gather(mi.ArrayXf, numbers, index + i, shape=shape) for i in (0, 1))
        values = [dr.fma(b - a, fraction, a) for a, b in zip(low, high, strict=True)]
        lobes = 1 + self._arch.lobes
        return Mixture(values[: lobes + 1], values[lobes + 1 : 2 * lobes + 1])

    def code_terms(self, latent: np.ndarray) -> np.ndarray:
        """The width or the widths of the code's lobe, and what the code adds to the first layer."""
        own = latent[list(WIDTH_PLACES[self._arch.widths])]
        inputs = sampler_inputs(self._arch, latent)
        return np.concatenate([own, inputs @ self._weight[: len(inputs)] + self._bias])

    def proposal_of_terms(self, terms: Sequence, wi) -> Mixture:
        """The mixture from `code_terms`, a list of Dr.Jit floats, by the network."""
        features = sampler_features(wi, self._arch.widths)
        count = self._arch.widths
        first = mlp.dense(features, self._weight[-len(features) :], terms[count:])
        return self._mixture(terms[:count], self._hidden(first))

    def proposal(self, latent: Sequence, wi) -> Mixture:
        """The mixture from a latent code, a list (size) of Dr.Jit floats, by the network."""
        lobe = self._arch.lobe
        inputs = [*lobe_features(latent[:lobe], self._kind), *latent[lobe:]]
        inputs += sampler_features(wi, self._arch.widths)
        first = mlp.dense(inputs, self._weight, self._bias.tolist())
        own = [latent[place] for place in WIDTH_PLACES[self._arch.widths]]
        return self._mixture(own, self._hidden(first))

    def _mixture(self, own: Sequence, output: Sequence) -> Mixture:
        """own: the width or the two widths of the code's lobe."""
        k = 1 + self._arch.lobes
        logits = output[: k + 1]
        largest = logits[0]
        for logit in logits[1:]:
            largest = dr.maximum(largest, logit)
        shares = [dr.exp(logit - largest) for logit in logits]
        scale = (1 - MIN_COSINE_SHARE) / sum(shares)
        weights = [share * scale for share in shares]
        weights[k] = weights[k] + MIN_COSINE_SHARE
        fractions = [1 / (1 + dr.exp(x)) for x in output[k + 1 :]]
        alphas = [dr.exp(float(np.log(MIN_ALPHA)) * x) for x in fractions]
        # One side for each width: that of the code's lobe, and those of the other lobes.
        sides = [[width, *alphas[i * (k - 1) :][: k - 1]] for i, width in enumerate(own)]
        sides = [[dr.clip(alpha, MIN_ALPHA, 1) for alpha in side] for side in sides]
        if len(sides) == 1:
            return Mixture(weights, sides[0])
        return Mixture(weights, [Widths(u, v) for u, v in zip(*sides, strict=True)])


def sampler_features(wi, widths: int = 1):
    """The sampler's features of wi, see `nets.sampler.sampler_features`, as a list."""
    raised = dr.maximum(wi.z, MIN_COSINE)
    columns = [(raised - 0.5) * 3, dr.log(raised) + 1]
    if widths == 2:
        columns += [(wi.x * wi.x - 0.33) * 3, (wi.y * wi.y - 0.33) * 3]
    return columns
