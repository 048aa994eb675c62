"""Conservation of energy: codes whose directional albedo is too high are scaled down.

A code's lobe (`urushi.nets.lobe`) conserves energy and is exact. So only the rest is scaled, until
lobe and rest together meet the ceiling of the albedo. One factor for all pairs of directions keeps
f exactly reciprocal. Codes of networks without a gain are not changed.

The quadrature of one code's albedo takes several hundred evaluations of the decoder. The millions
of codes of a texture lie close together: a regression that is fitted to a thousand of them predicts
the albedo of the others, and codes far below the ceiling are skipped (`codes_to_measure`).
"""

import functools
from collections.abc import Callable

import numpy as np

from urushi.checks import MIN_ALPHA
from urushi.material.albedo_rule import AlbedoRule, albedo_rule
from urushi.material.lobe_albedo import lobe_albedos
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks, one_blas_thread

#: Error of the quadrature and of the interpolation in the albedo: the ceiling is 1 less this.
MARGIN = 0.002

#: Excess of a code's albedo over its source's albedo that is allowed; with `MARGIN`, 0.5 %.
SLACK = 0.003

#: Excess over an albedo of 1 that counts as a numerical error of a source that conserves energy.
TOLERANCE = 0.005

#: Cosine of wi (84 degrees) below which the source's albedo is no ceiling: the networks' errors in
#: the last few degrees would darken all other directions.
GRAZING = 0.1

#: Least albedo in a division.
LEAST_ALBEDO = 1e-6

#: Albedo that the rest may always have: it is not scaled down for a lobe that reflects nearly all
#: light at one angle.
LEAST_REST = 0.005

#: Largest difference between a rest and the empty rest at which the rest counts as empty.
BARE_DIFFERENCE = 1e-4

#: A code with a factor below `TINY_FACTOR` is measured again, at most `TINY_FACTOR_ROUNDS` times:
#: codes far from the training data may decode to the greatest f of the decoder.
TINY_FACTOR, TINY_FACTOR_ROUNDS = 1e-3, 3

#: Codes of a block, which one core measures; fewer codes are measured by the calling thread.
BLOCK = 32

#: Codes that are decoded at once: their activations stay in a core's cache.
AT_ONCE = 6

#: Step of central differences of albedos: tables of lobes' albedos are in single precision.
SLOPE_STEP = 1e-3

#: Number of codes above which only the codes chosen by `codes_to_measure` are measured.
SCREENED_COUNT = 4096


def directional_albedos(model: Model, z: np.ndarray) -> np.ndarray:
    """Directional albedos (N, D) of codes (N, L) at the cosines of `albedo_rule`."""
    return rest_albedos(model, z) + top_albedos(model, z)


def top_albedos(model: Model, z: np.ndarray) -> np.ndarray:
    """Directional albedos (..., D) of the lobes of codes (..., L) at the cosines of the rule."""
    return lobe_albedos(z[..., : model.arch.lobe], albedo_rule(model.arch.widths))


def rest_albedos(model: Model, z: np.ndarray) -> np.ndarray:
    """Directional albedos (N, D) of the rests of codes (N, L) at the cosines of the rule."""
    nodes, networks = albedo_rule(model.arch.widths), model.networks
    count = len(nodes.cosines)

    def measure(codes: np.ndarray) -> np.ndarray:
        at_angles = [
            nodes.at_angles(networks.rest_at_all(codes[start : start + AT_ONCE], nodes.features))
            for start in range(0, len(codes), AT_ONCE)
        ]
        return nodes.interpolated(np.concatenate(at_angles))

    if not len(z):
        return np.zeros((0, count), np.float32)
    if len(z) <= BLOCK:
        with one_blas_thread():
            return measure(z)
    result = np.empty((len(z), count), np.float32)
    fill_blocks(result, measure, z, rows=BLOCK)
    return result


def albedo_ceiling(own: np.ndarray, rule: AlbedoRule) -> np.ndarray:
    """Largest albedos (..., D) allowed for a code whose source has the albedos own (..., D).

    None is above 1 - `MARGIN`, or the source's largest albedo if the source gains energy.
    """
    peak = own.max(axis=-1, keepdims=True)
    top = np.where(peak > 1 + TOLERANCE, peak, 1 - MARGIN)
    return np.where(rule.cosines < GRAZING, top, np.minimum(own + SLACK, top))


def limit_albedo(
    model: Model, z: np.ndarray, ceiling: np.ndarray | float = 1 - MARGIN
) -> np.ndarray:
    """Scale codes down so that their directional albedo is nowhere above a ceiling.

    Args:
        model: the networks.
        z: float32 (..., L).
        ceiling: a number, or an array that broadcasts to (..., D), at the cosines of `albedo_rule`.

    Returns:
        float32 (..., L); the same bits where a code is not above its ceiling.
    """
    rows, over = np.ascontiguousarray(z).reshape(-1, z.shape[-1]), np.arange(z[..., 0].size)
    varies = not isinstance(ceiling, float)
    if varies:
        count = len(albedo_rule(model.arch.widths).cosines)
        ceiling = np.broadcast_to(ceiling, (*z.shape[:-1], count)).reshape(-1, count)
    elif len(rows) > SCREENED_COUNT:
        over = codes_to_measure(functools.partial(excesses, model, ceiling=ceiling), rows)
    unchanged = True
    for _ in range(1 + TINY_FACTOR_ROUNDS):
        if not len(over):
            break
        own = ceiling[over] if varies else ceiling  # type: ignore[index]
        factors = (1 / excesses(model, rows[over], own)).astype(np.float32)
        if (factors < 1).any():
            rows, unchanged = rows if not unchanged else np.array(rows), False
            gains = model.networks.gains(rows)
            gains[over[factors < 1]] += np.log(factors[factors < 1])
        over = over[factors < TINY_FACTOR]
    return z if unchanged else rows.reshape(z.shape)


def as_rendered(model: Model, z_bottom: np.ndarray) -> np.ndarray:
    """Codes (..., L) of bottoms as they are rendered: without the rests of bare surfaces.

    The encoder's code of an empty rest decodes to a little light. It serves the layerer and is
    never rendered.
    """
    bare = are_bare(model, z_bottom)[..., None]
    return np.where(bare, model.networks.without_rest(z_bottom), z_bottom)


def are_bare(model: Model, z: np.ndarray) -> np.ndarray:
    """Whether codes (..., L) have an empty rest, as bare surfaces have; bool (...)."""
    empty = model.networks.empty_rest()
    return np.abs(z[..., model.arch.lobe :] - empty).max(axis=-1) < BARE_DIFFERENCE


def excesses(model: Model, z: np.ndarray, ceiling: np.ndarray | float) -> np.ndarray:
    """Largest ratios (N,) of the albedo of the rest to its allowed albedo, for codes (N, L)."""
    allowed = np.maximum(ceiling - top_albedos(model, z), LEAST_REST)
    ratios = np.maximum(rest_albedos(model, z), LEAST_ALBEDO) / allowed
    return np.where(is_limited(z[:, : model.arch.lobe]), ratios.max(axis=-1), LEAST_ALBEDO)


def is_limited(lobe: np.ndarray) -> np.ndarray:
    """Whether codes of lobes (..., N) are limited; bool (...).

    An interface of an index below one lies below another coat. It reflects all light beyond the
    critical angle, and the rest ends there, with an edge that the decoder cannot draw where the
    interface is smooth. The codes of coats above meet the ceiling themselves.
    """
    return (lobe[..., 3] <= 0) | (lobe[..., 4] >= 1)


def factor_slopes(model: Model, z: np.ndarray) -> np.ndarray:
    """Derivatives (L,) of ln of the limit's factor of a code z (L,), by the numbers of the code.

    The factor is the albedo that the lobe allows the rest over the albedo of the rest, at the angle
    where this is least. The derivatives do not change with the gain: codes that were scaled down
    may stand for codes that were not.
    """
    rule, size = albedo_rule(model.arch.widths), model.arch.lobe
    log_f, slopes = model.networks.decode_log(z[None], rule.features)
    f, top = np.exp(log_f), top_albedos(model, z)
    at_angles, allowed = rule.at_angles(f), np.maximum(1 - MARGIN - top, LEAST_REST)
    rest = rule.interpolated(at_angles)
    at = int((rest / allowed).argmax())
    step = SLOPE_STEP * at_angles.max()
    up, down = (
        rule.interpolated(at_angles + way * step * np.eye(len(at_angles)))[:, at] for way in (1, -1)
    )
    counts = np.diff(rule.first, append=len(rule.weights))
    of_nodes = np.repeat((up - down) / (2 * step), counts) * rule.weights * f
    lobe = np.concatenate([z[:size] + way * SLOPE_STEP * np.eye(size) for way in (1, -1)])
    lobe = lobe.astype(np.float32)
    widths = list(WIDTH_PLACES[model.arch.widths])
    lobe[:, widths] = np.clip(lobe[:, widths], MIN_ALPHA, 1)
    (wide, narrow), (up, down) = np.split(lobe, 2), np.split(lobe_albedos(lobe, rule)[:, at], 2)
    of_top = (up - down) / (wide - narrow).diagonal() / allowed[at]
    of_top *= allowed[at] > LEAST_REST
    return np.concatenate([-of_top, -of_nodes @ slopes / max(rest[at], LEAST_ALBEDO)])


#: Number of codes that are measured, half to fit the regression and half to estimate its error.
SAMPLE = 1024

#: Codes are weighted in the fit by this power of their excess. The error of the regression is its
#: greatest error over held-out codes whose ln excess is above -`NEAR`, or over the brightest tenth,
#: times `ERROR_FACTOR`, plus `LEAST_MARGIN`.
WEIGHT_POWER, NEAR, ERROR_FACTOR, LEAST_MARGIN = 4.0, 0.25, 2.0, 0.02

#: Regression: number of random features, and ridge.
FEATURES, RIDGE = 64, 1e-3

#: Factor on the range of the sample; a code outside this range in any number is measured.
REACH = 1.25

#: Greatest number of rounds, each with its own sample. The rounds stop when fewer than
#: `GAIN` times `SAMPLE` candidates remain.
ROUNDS, GAIN = 4, 4


def codes_to_measure(excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray) -> np.ndarray:
    """Indices of the codes among z (N, L) whose excess may be greater than one.

    excess: measures the positive excess (n,) of codes (n, L). Samples have fixed seeds.

    The candidates are screened again in further rounds, because a regression on bright codes alone
    is more exact.
    """
    index = np.arange(len(z))
    for seed in range(ROUNDS):
        before = len(index)
        index = index[_candidates(excess, z[index] if seed else z, np.random.default_rng(seed))]
        if len(index) > before // 2 or len(index) < GAIN * SAMPLE:
            break
    return index


def _candidates(
    excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray, rng: np.random.Generator
) -> np.ndarray:
    """`codes_to_measure` by one ridge regression of the logarithm of the excess.

    Its features are tanh of random combinations of a code's numbers, the numbers, and one.
    """
    sample, half = z[rng.integers(len(z), size=SAMPLE)], SAMPLE // 2
    target = np.log(excess(sample))
    mean, spread = sample.mean(axis=0), sample.std(axis=0)
    # Numbers that hardly vary must not be amplified.
    scale = 1 / np.maximum(spread, 0.01 * spread.max() + 1e-12)
    size = sample.shape[1]
    projection = (rng.normal(size=(size, FEATURES)) / np.sqrt(size)).astype(np.float32)
    shift = rng.uniform(-2, 2, FEATURES).astype(np.float32)
    reach = REACH * np.abs((sample - mean) * scale).max(axis=0) + 1e-3

    def features(x: np.ndarray) -> np.ndarray:
        one = np.ones((len(x), 1), np.float32)
        return np.concatenate([np.tanh(x @ projection + shift), x, one], axis=1)

    def estimate(z: np.ndarray) -> np.ndarray:  # infinite for codes far outside the sample
        x = (z - mean) * scale
        inside = (np.abs(x) <= reach).all(axis=-1)
        return np.where(inside, features(x) @ coefficients, np.float32(np.inf))[:, None]

    with one_blas_thread():  # the matrices are small
        x = features((sample[:half] - mean) * scale).astype(np.float64)
        weights = np.exp(WEIGHT_POWER * (target[:half] - target[:half].max()))
        weighted = x.T * (weights / weights.sum())
        normal = weighted @ x + RIDGE * np.eye(x.shape[1])
        coefficients = np.linalg.solve(normal, weighted @ target[:half]).astype(np.float32)
        errors = target[half:] - estimate(sample[half:])[:, 0]
    near = target[half:] >= min(-NEAR, np.quantile(target[half:], 0.9))
    margin = ERROR_FACTOR * max(float(errors[near].max()), 0) + LEAST_MARGIN
    values = np.empty((len(z), 1), np.float32)
    fill_blocks(values, estimate, z)
    return np.flatnonzero(values[:, 0] > -margin)
