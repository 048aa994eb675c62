"""The layering network: from the code of a bottom and a coat to the code of the coated BRDF."""

from typing import Any

from urushi.checks import CoatParameters
from urushi.nets.features import coat_features
from urushi.nets.first_crossing import FirstCrossing
from urushi.nets.lobe import lobe_features, of_coat
from urushi.nets.mlp import Params, hidden_to_output, split_linear

#: Logarithmic gain of a bottom's rest below which the network takes it as this one: of no rest.
LEAST_GAIN = -12.0


def layer(
    params: Params,
    arch: Any,
    z_bottom: Any,
    coat: tuple[Any, ...],
    crossing: FirstCrossing | None = None,
) -> Any:
    """Return the latent codes (..., L) of bottoms z_bottom (..., L) under coats.

    coat: alpha, eta, albedo, sigma_t, g, arrays that broadcast against each other and against the
    bottoms; alpha is two `Widths` if codes have two widths. The coat's interface becomes the
    lobe of the result. crossing: of an architecture that has one.
    """
    return finished(params, arch, z_bottom, coat, start(arch, z_bottom, coat, crossing))


def start(arch: Any, z_bottom: Any, coat: tuple[Any, ...], crossing: FirstCrossing | None) -> Any:
    """The numbers (..., K) beside the lobe that the network changes, see `layer`.

    They are those of the first crossing, or of the bottom if there is none.
    """
    rest = seen_rest(arch, z_bottom)
    if crossing is None:
        return rest
    return crossing.codes(rest, z_bottom[..., : arch.lobe], CoatParameters(*coat))


def seen_rest(arch: Any, z_bottom: Any) -> Any:
    """The numbers (..., K) beside the lobe of bottoms (..., L); gains are at least `LEAST_GAIN`."""
    xp, gain = z_bottom.__array_namespace__(), z_bottom[..., arch.lobe : arch.lobe + 1]
    gain = xp.maximum(gain, xp.asarray(LEAST_GAIN, dtype=z_bottom.dtype))
    return xp.concat([gain, z_bottom[..., arch.lobe + 1 :]], axis=-1)


def finished(params: Params, arch: Any, z_bottom: Any, coat: tuple[Any, ...], begun: Any) -> Any:
    """`layer` from its `start` (..., K).

    The network computes the change of these numbers, from them, the bottom's lobe and the coat, and
    from the bottom's gain beside a first crossing.
    """
    xp = z_bottom.__array_namespace__()
    inputs = [begun, lobe_features(z_bottom[..., : arch.lobe])]
    if arch.crossing:
        inputs.insert(1, seen_rest(arch, z_bottom)[..., :1])
    shape = begun.shape[:-1]
    inputs = [xp.broadcast_to(x, (*shape, x.shape[-1])) for x in inputs]
    own = xp.concat(inputs, axis=-1)
    first = split_linear(params, "layerer.0", own, coat_features(*coat))
    rest = begun + hidden_to_output(params, "layerer", first, arch.activation)
    top = of_coat(*coat[:2])
    return xp.concat([xp.broadcast_to(top, (*rest.shape[:-1], arch.lobe)), rest], axis=-1)
