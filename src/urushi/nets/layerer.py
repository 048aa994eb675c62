"""The layering network: from the code of a bottom and a coat to the code of the coated BRDF."""

from typing import Any

from urushi.nets.features import coat_features
from urushi.nets.lobe import lobe_features, of_coat
from urushi.nets.mlp import Params, hidden_to_output, split_linear

#: Logarithmic gain of a bottom's rest below which the network takes it as this one: of no rest.
LEAST_GAIN = -12.0


def layer(params: Params, arch: Any, z_bottom: Any, coat: tuple[Any, ...]) -> Any:
    """Return the latent codes (..., L) of bottoms z_bottom (..., L) under coats.

    coat: alpha, eta, albedo, sigma_t, g, arrays that broadcast against each other and against the
    bottoms; alpha is two `Widths` if codes have two widths. The coat's interface becomes the
    lobe of the result. The network computes the change of the other numbers, from these, the
    bottom's lobe and the coat.
    """
    xp, rest = z_bottom.__array_namespace__(), bottom_rest(z_bottom, arch.lobe)
    own = xp.concat([rest, lobe_features(z_bottom[..., : arch.lobe])], axis=-1)
    first = split_linear(params, "layerer.0", own, coat_features(*coat))
    rest = rest + hidden_to_output(params, "layerer", first, arch.activation)
    top = of_coat(*coat[:2])
    return xp.concat([xp.broadcast_to(top, (*rest.shape[:-1], arch.lobe)), rest], axis=-1)


def bottom_rest(z: Any, lobe: int) -> Any:
    """Rests (..., K) of bottoms z (..., L), whose lobes have `lobe` numbers, for the network.

    What is fainter than `LEAST_GAIN` is no rest: its other numbers are those of rounding errors.
    """
    xp = z.__array_namespace__()
    gain, others = z[..., lobe : lobe + 1], z[..., lobe + 1 :]
    least = xp.asarray(LEAST_GAIN, dtype=z.dtype)
    zero = xp.zeros_like(least)
    return xp.concat([xp.maximum(gain, least), xp.where(gain > least, others, zero)], axis=-1)
