"""Functions of one material, beside those of the basis that all materials share.

The functions of the basis are too smooth for some materials: sharp metals below smooth coats, and
measured ones. What tables of the material at a few points of its axes have beyond their codes are
functions of its own, by which the codes of all points are fitted again. The points are the farthest
from sums of those before, one after the other, as in a reduced basis (Prud'homme et al. 2002).
"""

from collections.abc import Callable
from dataclasses import replace

import numpy as np

from urushi.core.spanning import spanning
from urushi.nets import basis
from urushi.nets.weights import Model

#: Most tables that are computed, and most functions.
TABLES, FUNCTIONS = 16, 12

#: Root mean square of the relative error of f, by the light, below which nothing is lacking.
ENOUGH = 3e-3

#: [1/sr] Least g: extrapolated bottoms may reflect less than nothing.
LEAST = 1e-9


def own_functions(
    model: Model,
    g: np.ndarray,
    passed: np.ndarray,
    rests: np.ndarray,
    tables: Callable[[np.ndarray], np.ndarray],
) -> np.ndarray:
    """Functions float32 (N, F) of a material at the nodes of `core.table`; F is 0 if none lack.

    Their numbers have a mean square of one in the tables that they were made of.

    Args:
        model: of one width.
        g: (M, P) [1/sr] of `nets.transmittance` at the probe pairs.
        passed: (M, P) T(wi) T(wo) there.
        rests: (M, K) of the codes of g.
        tables: from indices (n,) among the M to g (n, N) [1/sr] at the nodes of `core.table`.
    """
    own = model.networks.basis
    g = np.maximum(g, LEAST)
    light = own.measure * passed * g
    light /= light.sum(axis=1, keepdims=True)
    lacks = np.log(g) - basis.decode_log(rests[:, None], own.probe_rows(0.0))
    lacks = (np.sqrt(light) * lacks).astype(np.float64)
    found, _ = spanning(lacks, ENOUGH, TABLES)
    if not found:
        return np.empty((len(own.rows), 0), np.float32)
    chosen = np.array(found)
    lacking = np.log(np.maximum(tables(chosen), LEAST)) - basis.decode_log(
        rests[chosen, None], own.rows
    )
    squares, axes = np.linalg.eigh(lacks[chosen] @ lacks[chosen].T)
    kept = np.flatnonzero(squares > ENOUGH**2)[-FUNCTIONS:]
    return lacking.T @ (axes[:, kept] / np.sqrt(len(chosen))).astype(np.float32)


def extended(model: Model, functions: np.ndarray) -> Model:
    """The model with the functions of `own_functions` behind those of its basis."""
    count, params = functions.shape[1], model.params
    if not count:
        return model
    size = model.arch.functions
    prior = np.pad(params["basis.prior"], (0, count))
    prior[size:, size:] = np.eye(count)
    more = {
        "basis.rows": np.concatenate([params["basis.rows"], functions], axis=1),
        "basis.prior": prior,
        "proposal.weight": np.pad(params["proposal.weight"], [(0, count), (0, 0)]),
    }
    arch = replace(model.arch, functions=size + count)
    return replace(model, arch=arch, params={**params, **more})
