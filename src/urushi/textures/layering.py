"""Layering of many different rows: by light transport at a few of them, which correct the network.

A texture has few parameters that vary, and codes are linear and smooth in them. Light transport is
computed at random rows. What the layering network lacks there is interpolated over features of
coats and bottoms, and added to the network's codes of all rows.
"""

import numpy as np

from urushi import checks
from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.core.microfacet import of_widths, pair
from urushi.material.coated_values import coated_values
from urushi.material.energy import limit_albedo
from urushi.material.layer import absent, check_ratios, codes_of_rests, predicted, with_widths
from urushi.material.material import Material
from urushi.material.reflector import Reflector
from urushi.material.substrate import Substrate
from urushi.nets import lobe as lobes
from urushi.nets.features import coat_features
from urushi.nets.layerer import bottom_rest
from urushi.nets.weights import Model
from urushi.textures.interpolation import interpolant

#: Rows by light transport, by the number of GGX widths: a second.
TRANSPORTED = {1: 384, 2: 12}

#: Rows among which rare classes are looked for.
CANDIDATES = 8192


def layer_rows(model: Model, rows: np.ndarray) -> np.ndarray:
    """Codes (k, L) of rows, each the code of a bottom and the parameters of a coat.

    rows: float32 (k, L + 5), of two widths (k, L + 6), with columns as `CoatParameters.columns`.
        Absent coats leave the bottom as it is.
    """
    z, coat = rows[:, : model.arch.latent], _coats(model, rows)
    none = absent(coat)
    if none.any():
        codes = np.array(z)
        if not none.all():
            codes[~none] = layer_rows(model, rows[~none])
        return codes
    count, size = TRANSPORTED[model.widths], model.arch.lobe
    if len(z) <= count:
        return transported(model, z, coat)
    codes, x = predicted(model, z, coat), features(model, z, coat)
    chosen = representatives(x, count)
    exact = transported(model, z[chosen], _coats(model, rows[chosen]))
    lacks = exact[:, size:] - codes[chosen, size:]
    codes[:, size:] += interpolant(x[chosen], lacks, model.networks.basis.norm)(x)
    return limit_albedo(model, codes)


def _coats(model: Model, rows: np.ndarray) -> CoatParameters:
    """The coats of rows; rounding to single precision makes no width too small."""
    coat = CoatParameters.of_columns([*rows[:, model.arch.latent :].T.astype(np.float64)])
    coat = with_widths(model, coat)
    return coat._replace(alpha=of_widths(lambda x: np.maximum(x, MIN_ALPHA), coat.alpha))


def representatives(x: np.ndarray, count: int) -> np.ndarray:
    """Indices (count,) of different points among x (k, D), without preference for any.

    The last quarter are the points that are the farthest from all before (Gonzalez 1985), so that
    rare classes have some.
    """
    order = np.random.default_rng(0).permutation(len(x))
    chosen, others = [*order[: count - count // 4]], order[:CANDIDATES]
    distance = np.full(len(others), np.inf)
    for last in chosen:
        distance = np.minimum(distance, np.square(x[others] - x[last]).sum(axis=1))
    while len(chosen) < count:
        chosen.append(others[distance.argmax()])
        distance = np.minimum(distance, np.square(x[others] - x[chosen[-1]]).sum(axis=1))
    return np.array(chosen)


def transported(model: Model, z: np.ndarray, coat: CoatParameters) -> np.ndarray:
    """Codes (k, L) of bottoms z (k, L) under coats (k,), by light transport at the probe pairs."""
    coat = checks.coat(coat, "the coat's", any_shape=True)
    check_ratios(model, z, coat)
    rests = transported_rests(model, *different(model, z), coat)
    # Each row is a material of its own, with one channel.
    coat = CoatParameters.of_columns([column[:, None] for column in coat.columns()])
    return codes_of_rests(model, rests[:, None], coat, z[:, None])[:, 0]


def transported_rests(
    model: Model, below: Substrate, places: np.ndarray, coat: CoatParameters
) -> np.ndarray:
    """f float32 (k, P) [1/sr] of bottoms at places (k,) under coats (k,) at the probe pairs.

    It is without the lobes of the coats.
    """
    columns = np.stack([*pair(coat.alpha)[: model.widths], *coat[1:]]).astype(np.float64)
    interfaces, media = np.split(columns, [model.widths + 1])
    return coated_values(below, places, interfaces, media, *model.networks.pairs()).T


def different(model: Model, codes: np.ndarray) -> tuple[Substrate, np.ndarray]:
    """The different ones of codes (..., L), and the place (...) of each among them."""
    flat = codes.reshape(-1, codes.shape[-1]).astype(np.float32)
    found, which = np.unique(flat, axis=0, return_inverse=True)
    return Substrate.of(Reflector.of(Material(found, model))), which.reshape(codes.shape[:-1])


def features(model: Model, z: np.ndarray, coat: CoatParameters) -> np.ndarray:
    """Features float32 (k, D) of bottoms z (k, L) under coats (k,), in the directions in which they
    vary."""
    size = model.arch.lobe
    found = [coat_features(*coat), lobes.lobe_features(z[:, :size]), bottom_rest(z, size)]
    x = np.concatenate(found, axis=1, dtype=np.float32)
    x -= x.mean(axis=0)
    sizes, axes = np.linalg.eigh(x.T.astype(np.float64) @ x)
    return x @ axes[:, sizes > 1e-6 * sizes[-1]].astype(np.float32)
