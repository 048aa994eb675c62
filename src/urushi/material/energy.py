"""Albedos of codes: no code gains energy, and a code of a known source has its albedo.

Albedos are measured at the directions of `albedo_rule`. A code's lobe (`urushi.nets.lobe`) is
exact and conserves energy, so that only the rest is changed. A code that was fitted to values is
replaced by the nearest code whose albedo is within bounds (`nearest_within`): at grazing angles,
where there are no probes, it may be far too bright although it is right elsewhere. Codes of the
layering network, and codes that are still too bright, are scaled down (`limit_albedo`).
"""

import functools

import numpy as np

from urushi.core.namespace import components
from urushi.material.albedo_rule import AlbedoRule, albedo_rule
from urushi.material.crossing import facet_points, mirrored
from urushi.nets import basis, code_fit, transmittance
from urushi.nets import lobe as lobes
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Error of the quadrature in the albedo: the ceiling is 1 less this.
MARGIN = 0.0005

#: Difference of a code's albedo from its source's albedo that is not corrected.
SLACK = 0.003

#: Sources with albedos up to 1 plus this count as conserving energy: the excess is numerical.
TOLERANCE = 0.005

#: Cosine of wi (84 degrees) below which the source's albedo does not count: errors of codes in
#: the last few degrees would change all other directions.
GRAZING = 0.1

#: Least albedo in a division.
LEAST_ALBEDO = 1e-6

#: Albedo that the rest may always have: it is not scaled down for a lobe that reflects nearly all
#: light at one angle.
LEAST_REST = 0.005

#: A code with a factor below `NO_FACTOR` is measured again, at most `ROUNDS` times: f of codes far
#: from the training data may be greater than the greatest f of the basis, to which it is clipped.
NO_FACTOR, ROUNDS = 0.999, 5

#: Codes, and lobes, that are measured at once: their values stay in a core's cache.
BLOCK, LOBES = 32, 4

#: Facets at which a lobe is measured.
FACETS = 512

#: Most that a rough surface reflects more than a smooth one: lobes are measured only if this
#: bound does not suffice.
ROUGH_GAIN = 0.003

#: Weight of the prior of codes in the change of a code: directions of codes that the probes hardly
#: see would change without bound.
PLAUSIBLE = 0.3

#: Weights of the difference of ln albedo from its bounds beside the error of the code, one round
#: after the other.
ALBEDO_WEIGHTS = 0.25, 1.0, 4.0, 16.0, 64.0, 256.0


def lobe_albedos(lobe: np.ndarray) -> np.ndarray:
    """Directional albedos float32 (..., K) of lobes (..., 6) of one width, or (..., 7) of two.

    They are means over visible facets, with an error of at most 0.004. Lobes whose numbers are
    equal in half precision are measured once.
    """
    rule = albedo_rule(1 + (lobe.shape[-1] > len(lobes.LOBE_NUMBERS)))
    wi, points = components(rule.directions[:, None]), facet_points(FACETS)

    def measure(some: np.ndarray) -> np.ndarray:
        some = some[:, None, None]
        facets = mirrored(wi, lobes.width(some), points)
        return (lobes.reflectance(some, facets.cosine) * facets.masking).mean(axis=-1)

    flat = lobe.reshape(-1, lobe.shape[-1]).astype(np.float16)
    different, which = np.unique(flat, axis=0, return_inverse=True)
    result = np.empty((len(different), len(rule.directions)), np.float32)
    fill_blocks(result, measure, different.astype(np.float32), rows=LOBES)
    return result[which.reshape(lobe.shape[:-1])]


def rest_albedos(model: Model, z: np.ndarray) -> np.ndarray:
    """Directional albedos (N, K) of the rests of codes (N, L)."""
    rule, functions = albedo_rule(model.arch.widths), node_functions(model)

    def measure(codes: np.ndarray) -> np.ndarray:
        return rule.albedo(model.networks.rest_at_all(codes, functions))

    result = np.empty((len(z), len(rule.directions)), np.float32)
    return fill_blocks(result, measure, z, rows=BLOCK)


def code_albedos(model: Model, z: np.ndarray) -> np.ndarray:
    """Directional albedos (N, K) of codes (N, L)."""
    return rest_albedos(model, z) + lobe_albedos(z[:, : model.arch.lobe])


@functools.lru_cache(maxsize=8)
def node_functions(model: Model) -> basis.Functions:
    """The functions of the basis at the pairs of `albedo_rule`."""
    rule = albedo_rule(model.arch.widths)
    return model.networks.basis.functions_at(rule.wi, rule.wo)


def albedo_bounds(own: np.ndarray, rule: AlbedoRule) -> tuple[np.ndarray, np.ndarray]:
    """Largest and least albedos (..., K) of a code whose source has the albedos own (..., K).

    They are within `SLACK` of the source's, and above `GRAZING` only. None is above 1 - `MARGIN`,
    or the source's largest albedo if the source gains energy.
    """
    peak = own.max(axis=-1, keepdims=True)
    top = np.where(peak > 1 + TOLERANCE, peak, 1 - MARGIN)
    grazing = rule.directions[:, 2] < GRAZING
    most = np.where(grazing, top, np.minimum(own + SLACK, top))
    return most, np.where(grazing, 0, np.minimum(own - SLACK, most))


def nearest_within(
    model: Model,
    z: np.ndarray,
    most: np.ndarray | float = 1 - MARGIN,
    least: np.ndarray | float = 0.0,
) -> np.ndarray:
    """The nearest codes float32 (..., L) whose directional albedo is within bounds.

    Distances are those of the least squares of `nets.code_fit`. The bounds are not kept exactly,
    but no albedo is above the largest bound: such codes are scaled down. `most` is the ceiling of
    `limit_albedo`, `least` is of the same shapes.
    """
    rows, most = _rows(model, z, most)
    off = excesses(model, rows, most) > 1
    if np.any(least):
        least = _rows(model, z, least)[1]
        off |= (code_albedos(model, rows) < least).any(axis=1)
    if not off.any():
        return z
    rows, lobe = np.array(rows), lobe_albedos(rows[off, : model.arch.lobe])
    ceiling = most.max(axis=1, keepdims=True)
    bounds = np.broadcast_to(least, most.shape)[off], most[off], ceiling[off]
    for row, own, *limits in zip(np.flatnonzero(off), lobe, *bounds, strict=True):
        rows[row] = _fitted_within(model, rows[row], own, *limits)
    return limit_albedo(model, rows, ceiling).reshape(z.shape)


def _fitted_within(
    model: Model,
    z: np.ndarray,
    lobe: np.ndarray,
    least: np.ndarray,
    most: np.ndarray,
    ceiling: np.ndarray,
) -> np.ndarray:
    """The code (L,) near z (L,) that has about an albedo within the bounds (K,).

    Least squares of the change of the rest at the probe pairs, and of the logarithm of the albedo
    where it is out of bounds, times the share of the rest in it, by Gauss and Newton's method.
    Above the ceiling it is the logarithm by which the whole rest would be scaled down.

    lobe: (K,) albedos of its lobe. ceiling: (1,), of `limit_albedo`.
    """
    rule, own = albedo_rule(model.arch.widths), model.networks.basis
    result = z.copy()
    numbers, stretch = own.split(result[model.arch.lobe :])
    nodes = node_functions(model)(float(stretch))
    functions = nodes[:, 1:].reshape(*rule.weights.shape, -1)
    top = result[: model.arch.lobe]
    seen, passed = (transmittance.both_ways(top, *w) for w in (own.pairs(), (rule.wi, rule.wo)))
    start = code = numbers.astype(float)
    at_probes = own.probe_rows(float(stretch))
    form = code_fit.form_about(at_probes, own.measure * seen, own.prior, start)
    form += PLAUSIBLE * own.prior
    highest = np.maximum(most, lobe + LEAST_REST)
    lowest = np.minimum(least, highest)
    allowed = np.maximum(ceiling - lobe, LEAST_REST)
    best, smallest = code, np.inf
    for weight in (*ALBEDO_WEIGHTS, 0.0):
        f = passed * basis.decode(code.astype(np.float32), nodes)
        light = rule.weights * f.reshape(rule.weights.shape)
        rest = np.maximum(light.sum(axis=1), LEAST_ALBEDO)
        total, above = rest + lobe, np.log(np.maximum(rest / allowed, 1))
        off = rest / total * np.log(total / np.clip(total, lowest, highest))
        hard = above > np.maximum(off, 0)
        off, size = np.where(hard, above, off), np.where(hard, rest, total * total / rest)
        error = (code - start) @ form @ (code - start) + ALBEDO_WEIGHTS[-1] * off @ off
        if error < smallest:
            best, smallest = code, error
        slopes = np.where(off, 1 / size, 0)[:, None] * (light[:, None] @ functions)[:, 0]
        right = weight * slopes.T @ (slopes @ (code - start) - off)
        code = start + np.linalg.solve(form + weight * slopes.T @ slopes, right)
    numbers[...] = best
    return result


def limit_albedo(
    model: Model, z: np.ndarray, ceiling: np.ndarray | float = 1 - MARGIN
) -> np.ndarray:
    """Scale codes down so that their directional albedo is nowhere above a ceiling.

    Args:
        model: the weights.
        z: float32 (..., L).
        ceiling: a number, or an array that broadcasts to (..., K).

    Returns:
        float32 (..., L); the same bits where a code is not above its ceiling.
    """
    rows, ceiling = _rows(model, z, ceiling)
    rows, over = np.array(rows), np.arange(len(rows))
    gains = model.networks.gains(rows)
    for _ in range(1 + ROUNDS):
        if not len(over):
            break
        factors = 1 / excesses(model, rows[over], ceiling[over])
        gains[over[factors < 1]] += np.log(factors[factors < 1])
        over = over[factors < NO_FACTOR]
    return rows.reshape(z.shape)


def excesses(model: Model, z: np.ndarray, ceiling: np.ndarray) -> np.ndarray:
    """Largest ratios (N,) of the albedo of the rest to its allowed albedo, for codes (N, L)."""
    result = np.empty((len(z), 1), np.float32)

    def measure(z: np.ndarray, ceiling: np.ndarray) -> np.ndarray:
        lobe, rest = z[:, : model.arch.lobe], np.maximum(rest_albedos(model, z), LEAST_ALBEDO)
        smooth = lobes.reflectance(lobe[:, None], albedo_rule(model.arch.widths).directions[:, 2])
        allowed = np.maximum(ceiling - smooth - ROUGH_GAIN, LEAST_REST)
        near = (rest > allowed).any(axis=-1)
        allowed[near] = np.maximum(ceiling[near] - lobe_albedos(lobe[near]), LEAST_REST)
        return (rest / allowed).max(axis=-1, keepdims=True)

    # Codes of the same stretch one after the other: their functions are computed once.
    order = np.argsort(model.networks.basis.split(z)[1], kind="stable")
    fill_blocks(result, measure, z[order], ceiling[order])
    return result[np.argsort(order), 0]


def _rows(
    model: Model, z: np.ndarray, ceiling: np.ndarray | float
) -> tuple[np.ndarray, np.ndarray]:
    """Codes (N, L) and ceilings (N, K) of codes (..., L), see `limit_albedo`."""
    count = len(albedo_rule(model.arch.widths).directions)
    ceiling = np.broadcast_to(np.float32(ceiling), (*z.shape[:-1], count))
    return np.ascontiguousarray(z).reshape(-1, z.shape[-1]), ceiling.reshape(-1, count)
