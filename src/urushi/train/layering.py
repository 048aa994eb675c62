"""The layering network: a regression from the code of a bottom and a coat to the code of both.

Codes are fixed numbers of the basis, so that this is a single well-posed fit. Bottoms and coated
materials are those of `urushi.train.tables`, computed by light transport. The error of a code by d
is measured at the probe pairs,

    q(d) = sum_p w_p (U_p d)^2,

the mean square of the relative error of f, weighted by light. With two widths, ln s counts by the
derivative of ln f. The loss is sqrt(e^2 + q) - e, about the error E of the result: stacks that are
hard to predict count linearly.
"""

from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from urushi.checks import CoatParameters
from urushi.core.stretched import STEP
from urushi.nets import code_fit, layerer
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis, decode_log
from urushi.nets.lobe import LOBE_FEATURES
from urushi.nets.mlp import Params
from urushi.nets.networks import Architecture
from urushi.nets.transmittance import both_ways
from urushi.nets.weights import Model

#: Error below which the loss is quadratic.
KNEE = 0.01

#: Weight of the measure beside the light.
FLOOR = 0.02

#: Examples whose codes are solved at once.
BLOCK = 256


class Layerings(NamedTuple):
    """Examples: bottoms under coats."""

    bottom: np.ndarray  # float32 (N, L) codes
    coat: np.ndarray  # float32 (N, 5), `CoatParameters`, or (N, 6)
    code: np.ndarray  # float32 (N, K) of the coated material, without its lobe
    root: np.ndarray  # float32 (N, K, K), q(d) = |root d|^2

    def taken(self, rows: np.ndarray) -> "Layerings":
        """The examples of some rows."""
        return Layerings(*(x[rows] for x in self))


def examples(basis: Basis, bottom: np.ndarray, coats: np.ndarray, coated: np.ndarray) -> Layerings:
    """Examples of bottoms with codes (M, L) under coats (M, C, 5), of two widths (M, C, 6).

    coated: (M, C, P) ln g of the coated materials at the probe pairs, see `nets.transmittance`.
    """
    flat = coats.reshape(-1, coats.shape[-1]).astype(np.float32)
    top = lobes.of_coat(*CoatParameters.of_columns(flat.T)[:2])
    passed = both_ways(top[:, None], *basis.pairs())
    code = code_fit.solve_codes(basis, np.exp(coated.reshape(len(flat), -1)), passed)
    root = np.empty((*code.shape, code.shape[1]), np.float32)
    for every, _, stretch in basis.groups(code):
        functions, slopes = basis.probe_rows(stretch), None
        if basis.widths == 2:  # derivatives by ln s
            high, low = (basis.probe_rows(stretch + step) for step in (STEP, -STEP))
            slopes = (high - low) / (2 * STEP)
        for first in range(0, len(every), BLOCK):
            rows = every[first : first + BLOCK]
            numbers, _ = basis.split(code[rows])
            f = np.exp(decode_log(numbers[:, None], functions))
            light = (passed[rows] * f + lobes.f(top[rows, None], *basis.pairs())) @ basis.measure
            weights = basis.measure * passed[rows] * (f / light[:, None] + FLOOR)
            form = code_fit.weighted_products(functions[:, 1:], weights)
            if slopes is not None:  # one more function
                slope = (numbers @ slopes[:, 1:].T)[..., None]
                mixed = np.swapaxes(slope * weights[..., None], 1, 2) @ functions[:, 1:]
                corner = (slope * slope * weights[..., None]).sum(axis=1, keepdims=True)
                form = np.block([[form, np.swapaxes(mixed, 1, 2)], [mixed, corner]])
            form += 1e-9 * np.eye(code.shape[1])
            root[rows] = np.swapaxes(np.linalg.cholesky(form), 1, 2)
    return Layerings(np.repeat(bottom, coats.shape[1], axis=0), flat, code, root)


def mirrored(found: Layerings, factors: np.ndarray) -> Layerings:
    """Examples of two widths with x and y exchanged: cos 2 psi, cos 2 p and ln s change signs.

    factors: (K,) of the functions.
    """
    sign = np.append(np.where(np.isin(factors, (1, 2)), -1, 1), -1).astype(np.float32)
    lobe = found.bottom.shape[1] - len(sign)
    ends = [np.r_[n - 1, 1 : n - 1, 0] for n in (lobe, found.coat.shape[1])]
    bottom = np.concatenate([found.bottom[:, ends[0]], found.bottom[:, lobe:] * sign], axis=1)
    return Layerings(bottom, found.coat[:, ends[1]], found.code * sign, found.root * sign)


def fresh(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Untrained parameters "layerer.*", which change no code (He et al. 2015)."""
    rng, last = np.random.default_rng(seed), f"layerer.{len(arch.layerer)}.weight"
    params = {}
    for name, shape in arch.parameter_shapes().items():
        if name.startswith("layerer."):
            scale = 0.0 if len(shape) == 1 or name == last else np.sqrt(2 / shape[0])
            params[name] = (scale * rng.standard_normal(shape)).astype(np.float32)
    return params


def widened(model: Model, arch: Architecture) -> dict[str, np.ndarray]:
    """Parameters "layerer.*" of two widths, with the same results as a network of one width.

    Features of a width become half of those of both, so that it sees their geometric mean.
    """
    params = {name: x for name, x in model.params.items() if name.startswith("layerer.")}
    first, last = "layerer.0.weight", f"layerer.{len(arch.layerer)}"
    rest, own = np.split(params[first], [model.arch.rest])
    more = arch.rest - model.arch.rest
    sides = np.split(own, [LOBE_FEATURES[1]])
    sides = [np.concatenate([x[:2] / 2, x[2:], x[:2] / 2]) for x in sides]
    params[first] = np.concatenate([np.pad(rest, ((0, more), (0, 0))), *sides])
    params[f"{last}.weight"] = np.pad(params[f"{last}.weight"], ((0, 0), (0, more)))
    params[f"{last}.bias"] = np.pad(params[f"{last}.bias"], (0, more))
    return params


def loss(params: Params, arch: Architecture, batch: Layerings) -> jax.Array:
    """The loss of the module, the mean over a batch."""
    return jnp.mean(jnp.sqrt(KNEE**2 + squares(params, arch, batch)) - KNEE)


def squares(params: Params, arch: Architecture, batch: Layerings) -> Any:
    """q (N,) of the predicted codes."""
    z = layerer.layer(params, arch, batch.bottom, CoatParameters.of_columns(batch.coat.T))
    away = (batch.root @ (z[:, arch.lobe :] - batch.code)[..., None])[..., 0]
    return (away * away).sum(axis=-1)


def batches(found: Layerings, size: int, seed: int, step: int, steps: int) -> Layerings:
    """Batches (steps, size, ...) of `steps` steps from a step on, in `shuffled` epochs."""
    rows = shuffled(len(found.code), seed, step * size, steps * size)
    return Layerings(*(x[rows].reshape(steps, size, *x.shape[1:]) for x in found))


def shuffled(size: int, seed: int, start: int, count: int) -> np.ndarray:
    """The items `start` to `start + count` of an endless sequence of `size` items, as indices.

    Every epoch has each item once, shuffled anew. A training that was interrupted so continues to
    the same bits.
    """
    first, past = start // size, -(-(start + count) // size)
    seeds = [np.random.SeedSequence(seed, spawn_key=(0, k, 0)) for k in range(first, past)]
    items = np.concatenate([np.random.default_rng(x).permutation(size) for x in seeds])
    return items[start - first * size :][:count]
