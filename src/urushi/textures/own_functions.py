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


def with_own_functions(
    model: Model,
    g: np.ndarray,
    passed: np.ndarray,
    rests: np.ndarray,
    tables: Callable[[np.ndarray], np.ndarray],
) -> Model:
    """The model with functions of a material; the same model if nothing is lacking.

    Args:
        model: of one width.
        g: (M, P) [1/sr] of `nets.transmittance` at the probe pairs.
        passed: (M, P) T(wi) T(wo) there.
        rests: (M, K) of the codes of g.
        tables: from indices (n,) among the M to g (n, N) [1/sr] at the nodes of `core.table`.
    """
    own, size, parts = model.networks.basis, model.arch.functions, model.params
    g = np.maximum(g, LEAST)
    light = own.measure * passed * g
    light /= light.sum(axis=1, keepdims=True)
    lacks = np.log(g) - basis.decode_log(rests[:, None], own.probe_rows(0.0))
    lacks = (np.sqrt(light) * lacks).astype(np.float64)
    found, _ = spanning(lacks, ENOUGH, TABLES)
    if not found:
        return model
    chosen = np.array(found)
    lacking = np.log(np.maximum(tables(chosen), LEAST)) - basis.decode_log(
        rests[chosen, None], own.rows
    )
    squares, axes = np.linalg.eigh(lacks[chosen] @ lacks[chosen].T)
    kept = np.flatnonzero(squares > ENOUGH**2)[-FUNCTIONS:]
    functions = lacking.T @ axes[:, kept].astype(np.float32)
    prior = np.pad(own.prior, (0, len(kept)))
    prior[size:, size:] = np.eye(len(kept)) * len(chosen)
    params = {
        **parts,
        "basis.rows": np.concatenate([own.rows, functions], axis=1),
        "basis.prior": prior,
        "proposal.weight": np.pad(parts["proposal.weight"], [(0, len(kept)), (0, 0)]),
    }
    return replace(model, arch=replace(model.arch, functions=size + len(kept)), params=params)
