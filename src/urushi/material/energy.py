"""Conservation of energy: codes whose directional albedo is too high are scaled down.

A code's lobe (`urushi.nets.lobe`) conserves energy and is exact. So only the rest is scaled, until
lobe and rest together meet the ceiling of the albedo. One factor for all pairs of directions keeps
f exactly reciprocal. Codes of networks without a gain are not changed.

The quadrature of one code's albedo takes several hundred evaluations of the decoder, and a texture
has millions of codes. They lie close together, so a regression fitted to a thousand of them
predicts the albedo of the other codes, and codes far below the ceiling are skipped
(`codes_to_measure`).
"""

import functools
from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.material import regression
from urushi.material.albedo_rule import AlbedoRule, albedo_rule
from urushi.material.lobe_albedo import lobe_albedos
from urushi.material.regression import CodeFeatures
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
#: down to exp(-80).
TINY_FACTOR, TINY_FACTOR_ROUNDS = 1e-3, 3

#: Codes of a block, which one core measures; fewer codes are measured by the calling thread.
BLOCK = 32

#: Codes that are decoded at once: their activations stay in a core's cache.
AT_ONCE = 6

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


def peak_ceiling(own: np.ndarray) -> np.ndarray:
    """The largest albedo (..., 1) allowed for a code whose source has the albedos own (..., D).

    It is 1 - `MARGIN`, or the source's largest albedo if the source gains energy.
    """
    peak = own.max(axis=-1, keepdims=True)
    return np.where(peak > 1 + TOLERANCE, peak, 1 - MARGIN)


def albedo_ceiling(own: np.ndarray, rule: AlbedoRule) -> np.ndarray:
    """Largest albedos (..., D) allowed for a code whose source has the albedos own (..., D)."""
    top = peak_ceiling(own)
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
    return _scaled(model, z, _limiting_factors(model, z, ceiling))


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


def _limiting_factors(
    model: Model, z: np.ndarray, ceiling: np.ndarray | float = 1 - MARGIN
) -> np.ndarray:
    """The factors float32 (...) in (0, 1] that bring codes (..., L) below a ceiling.

    A code far from the training data may decode to the greatest f that the decoder represents
    (`decoder.MAX_LOG`). Then the factor is found by scaling and measuring repeatedly.
    """
    result = _measured_factors(model, z, ceiling)
    far = result < TINY_FACTOR
    for _ in range(TINY_FACTOR_ROUNDS):
        if not far.any():
            break
        ceilings = ceiling
        if not isinstance(ceiling, float):
            ceilings = np.broadcast_to(ceiling, (*z.shape[:-1], _directions(model)))[far]
        further = _measured_factors(
            model, model.networks.rest_scaled(z[far], result[far]), ceilings
        )
        result[far] *= further
        far[far] = further < TINY_FACTOR
    return result


def _measured_factors(model: Model, z: np.ndarray, ceiling: np.ndarray | float) -> np.ndarray:
    """`_limiting_factors` by one measurement, exact where f is below the decoder's maximum."""
    result = np.ones(z.shape[:-1], np.float32)
    if not z.size:
        return result
    rows = np.ascontiguousarray(z).reshape(-1, z.shape[-1])
    if isinstance(ceiling, float) and len(rows) > SCREENED_COUNT:
        excess = functools.partial(excesses, model, ceiling=ceiling)
        bright = codes_to_measure(excess, rows)
        result.reshape(-1)[bright] = 1 / excess(rows[bright])
    else:
        ceilings = ceiling
        if not isinstance(ceiling, float):
            ceilings = np.broadcast_to(ceiling, (*z.shape[:-1], _directions(model)))
            ceilings = ceilings.reshape(-1, ceilings.shape[-1])
        result[...] = (1 / excesses(model, rows, ceilings)).reshape(result.shape)
    return np.minimum(result, 1, out=result)


def _directions(model: Model) -> int:
    """The number D of directions at which the albedos of codes are known."""
    return len(albedo_rule(model.arch.widths).cosines)


def excesses(model: Model, z: np.ndarray, ceiling: np.ndarray | float) -> np.ndarray:
    """Largest ratios (N,) of the albedo of the rest to its allowed albedo, for codes (N, L)."""
    allowed = np.maximum(ceiling - top_albedos(model, z), LEAST_REST)
    ratios = np.maximum(rest_albedos(model, z), LEAST_ALBEDO) / allowed
    return np.where(is_limited(z[:, : model.arch.lobe]), ratios.max(axis=-1), LEAST_ALBEDO)


def is_limited(lobe: np.ndarray) -> np.ndarray:
    """Whether codes of lobes (..., N) are limited; bool (...).

    An interface of an index below one lies below another coat. It reflects all light beyond the
    critical angle, and the rest ends there, with an edge that the decoder cannot draw where the
    interface is smooth. Coats over such codes meet the ceiling themselves.
    """
    return (lobe[..., 3] <= 0) | (lobe[..., 4] >= 1)


def _scaled(model: Model, z: np.ndarray, factors: np.ndarray) -> np.ndarray:
    """Codes (..., L) with factors (...) in (0, 1] on their rests."""
    over = factors < 1
    if not over.any():
        return z
    result = np.array(z)
    gains = model.networks.gains(result)
    gains[over] += np.log(factors[over])
    return result


#: Number of codes that are measured, half to fit the regression and half to estimate its error.
SCREEN_SAMPLE = 1024

#: Power of the excess by which codes are weighted in the fit; and the error of the regression: the
#: greatest over held-out codes whose ln excess is above -`SCREEN_NEAR`, or over the
#: brightest tenth, times a factor, plus a constant.
SCREEN_WEIGHT_POWER, SCREEN_NEAR, SCREEN_ERROR_FACTOR, SCREEN_LEAST_MARGIN = 4.0, 0.25, 2.0, 0.02

#: Regression: number of random features, and ridge.
SCREEN_FEATURES, SCREEN_RIDGE = 64, 1e-3

#: Factor on the range of the sample; a code outside this range in any number is measured.
SCREEN_REACH = 1.25

#: Greatest number of rounds, each with its own sample. The rounds stop when fewer than
#: `SCREEN_GAIN` times `SCREEN_SAMPLE` candidates remain.
SCREEN_ROUNDS, SCREEN_GAIN = 4, 4


def codes_to_measure(excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray) -> np.ndarray:
    """Indices of the codes among z (N, L) whose excess may be greater than one.

    excess: measures the positive excess (n,) of codes (n, L). Samples have fixed seeds.

    The candidates are screened again in further rounds, because a regression on bright codes alone
    is more exact.
    """
    index = np.arange(len(z))
    for seed in range(SCREEN_ROUNDS):
        before = len(index)
        index = index[_codes_to_measure(excess, z[index] if seed else z, seed)]
        if len(index) > before // 2 or len(index) < SCREEN_GAIN * SCREEN_SAMPLE:
            break
    return index


def _codes_to_measure(
    excess: Callable[[np.ndarray], np.ndarray], z: np.ndarray, seed: int
) -> np.ndarray:
    rng = np.random.default_rng(seed)
    sample = z[rng.integers(len(z), size=SCREEN_SAMPLE)]
    target = np.log(excess(sample))
    half = SCREEN_SAMPLE // 2
    with one_blas_thread():  # the matrices are small
        estimate = _fit_albedo_regression(sample[:half], target[:half], sample, rng)
        errors = target[half:] - estimate(sample[half:])
    near = target[half:] >= min(-SCREEN_NEAR, np.quantile(target[half:], 0.9))
    margin = SCREEN_ERROR_FACTOR * max(float(errors[near].max()), 0) + SCREEN_LEAST_MARGIN
    values = np.empty((len(z), 1), np.float32)
    fill_blocks(values, lambda codes: estimate(codes)[:, None], z)
    return np.flatnonzero(values[:, 0] > -margin)


class AlbedoRegression(NamedTuple):
    """Regression of the logarithm of the excess of codes within the range of a sample."""

    features: CodeFeatures
    reach: np.ndarray
    coefficients: np.ndarray

    def __call__(self, z: np.ndarray) -> np.ndarray:
        """Estimates (N,) for codes (N, L); infinite for those far outside the sample."""
        x = self.features.standard(z)
        inside = (np.abs(x) <= self.reach).all(axis=-1)
        return np.where(
            inside, self.features.of_standard(x) @ self.coefficients, np.float32(np.inf)
        )


def _fit_albedo_regression(
    z: np.ndarray, target: np.ndarray, sample: np.ndarray, rng: np.random.Generator
) -> AlbedoRegression:
    """Fit the regression to targets (n,) of codes (n, L); sample: codes that define its range."""
    features = regression.fit_features(sample, SCREEN_FEATURES, 1e-12, rng)
    reach = SCREEN_REACH * np.abs(features.standard(sample)).max(axis=0) + 1e-3
    weights = np.exp(SCREEN_WEIGHT_POWER * (target - target.max()))
    return AlbedoRegression(
        features, reach, regression.ridge_coefficients(features(z), target, SCREEN_RIDGE, weights)
    )
