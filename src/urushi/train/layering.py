"""The layering network: a regression from the code of a bottom and a coat to the code of both.

Codes are fixed numbers of the basis, so that this is a single well-posed fit. Bottoms and coated
materials are those of `urushi.train.tables`, computed by light transport. The error of a code by d
is measured at the probe pairs,

    q(d) = sum_p w_p (U_p d)^2,

the mean square of the relative error of f, weighted by light. The loss is sqrt(e^2 + q) - e, about
the error E of the result: stacks that are hard to predict count linearly.
"""

from collections.abc import Callable
from typing import Any, NamedTuple

import jax
import jax.numpy as jnp
import numpy as np

from urushi.checks import CoatParameters
from urushi.core.probe_pairs import probe_pairs
from urushi.nets import code_fit, layerer
from urushi.nets import lobe as lobes
from urushi.nets.basis import Basis
from urushi.nets.mlp import Params
from urushi.nets.networks import Architecture
from urushi.train.basis_fit import at_probes
from urushi.train.batches import shuffled
from urushi.train.tables import TableStore

#: Error below which the loss is quadratic.
KNEE = 0.01

#: Weight of the measure beside the light.
FLOOR = 0.02

#: Examples whose codes are solved at once.
BLOCK = 256


class Layerings(NamedTuple):
    """Examples: bottoms under coats."""

    bottom: np.ndarray  # float32 (N, L) codes
    coat: np.ndarray  # float32 (N, 5), `CoatParameters`
    code: np.ndarray  # float32 (N, K) of the coated material, without its lobe
    root: np.ndarray  # float32 (N, K, K), q(d) = |root d|^2

    def taken(self, rows: np.ndarray) -> "Layerings":
        """The examples of some rows."""
        return Layerings(*(x[rows] for x in self))


def layerings(basis: Basis, store: TableStore) -> tuple[Layerings, np.ndarray]:
    """All examples of a store, and the numbers (N,) of their stacks."""
    held = store.read(("table", "lobe", "over", "coated", "stack"))
    logs = at_probes(held["table"], len(basis.measure))
    found = examples(basis, held["lobe"], np.exp(logs), held["over"], np.exp(held["coated"]))
    return found, np.repeat(held["stack"], held["over"].shape[1])


def examples(
    basis: Basis, lobe: np.ndarray, rest: np.ndarray, coats: np.ndarray, coated: np.ndarray
) -> Layerings:
    """Examples of bottoms with lobes (M, L) and rests (M, P) under coats (M, C, 5).

    coated: (M, C, P) the rests of the coated materials. Values are at the probe pairs.
    """
    pairs, each = probe_pairs(len(basis.measure)), coats.shape[1]
    bottom = np.concatenate([lobe, code_fit.solve_codes(basis, rest)], axis=1, dtype=np.float32)
    flat = coats.reshape(-1, 5)
    top = lobes.of_coat(flat[:, 0], flat[:, 1]).astype(np.float32)
    coated = coated.reshape(len(flat), -1)
    code = code_fit.solve_codes(basis, coated)
    root = np.empty((len(code), *basis.prior.shape), np.float32)
    for first in range(0, len(code), BLOCK):
        rows = slice(first, first + BLOCK)
        f = np.exp(basis.probe_rows[:, 0] + code[rows] @ basis.probe_rows[:, 1:].T)
        light = (f + lobes.f(top[rows, None], *pairs)) @ basis.measure
        weights = basis.measure * (f / light[:, None] + FLOOR)
        form = code_fit.weighted_products(basis.probe_rows[:, 1:], weights)
        form += 1e-9 * np.eye(len(basis.prior))
        root[rows] = np.swapaxes(np.linalg.cholesky(form), 1, 2)
    return Layerings(np.repeat(bottom, each, axis=0), flat.astype(np.float32), code, root)


def fresh(arch: Architecture, seed: int) -> dict[str, np.ndarray]:
    """Untrained parameters "layerer.*", which change no code (He et al. 2015)."""
    rng, last = np.random.default_rng(seed), f"layerer.{len(arch.layerer)}.weight"
    params = {}
    for name, shape in arch.parameter_shapes().items():
        if name.startswith("layerer."):
            scale = 0.0 if len(shape) == 1 or name == last else np.sqrt(2 / shape[0])
            params[name] = (scale * rng.standard_normal(shape)).astype(np.float32)
    return params


def loss(
    params: Params, arch: Architecture, batch: Layerings
) -> tuple[jax.Array, dict[str, jax.Array]]:
    """The loss of the module over a batch, and the terms to log."""
    size = jnp.sqrt(KNEE**2 + squares(params, arch, batch)) - KNEE
    return jnp.mean(size), {"loss": jnp.mean(size)}


def squares(params: Params, arch: Architecture, batch: Layerings) -> Any:
    """q (N,) of the predicted codes."""
    z = layerer.layer(params, arch, batch.bottom, CoatParameters(*batch.coat.T))
    away = (batch.root @ (z[:, arch.lobe :] - batch.code)[..., None])[..., 0]
    return (away * away).sum(axis=-1)


def batches(found: Layerings, size: int, seed: int) -> Callable[[int, int], Layerings]:
    """Batches (steps, size, ...) of `steps` steps from a step on, in shuffled epochs."""
    order = shuffled(len(found.code), seed)

    def taken(step: int, steps: int) -> Layerings:
        rows = order(step * size, steps * size)
        return Layerings(*(x[rows].reshape(steps, size, *x.shape[1:]) for x in found))

    return taken
