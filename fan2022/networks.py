"""The paper's trained networks as one value: projection, layering, evaluation and sampling."""

import functools
import hashlib
import json
import os
import threading
from collections.abc import Mapping
from typing import Any

import numpy as np

from fan2022.architecture import ALL, LATENT, PaperArchitecture, shapes
from fan2022.inference import direction_inputs, evaluate, isotropic, layer
from fan2022.pairs import stratified_pairs
from urushi.checks import CoatParameters, one_width
from urushi.errors import ParameterError
from urushi.nets import weights
from urushi.nets.mlp import Params
from urushi.parallel import fill_blocks
from urushi.walk import analytic

#: The system that weights files name.
KIND = "paper"

#: Number of direction pairs at which a BRDF is evaluated for its projection: the authors' number
#: for one step, and eight strata for each of the four angles.
PAIRS = 4096

#: Codes of many Lambertian BRDFs, as of a texture, are interpolated between codes of the
#: reflectances (k / LEVELS)².
LEVELS = 32

#: Maximum number of different interfaces in one layering: a texture of widths would take hours.
MAX_TOPS = 256

#: Number of codes that are kept, of the BRDFs projected last.
KEPT = 1 << 14


@functools.cache
def projection_pairs() -> tuple[np.ndarray, np.ndarray]:
    """The pairs at which a BRDF is projected: stratified, as in the training data."""
    wi, wo = stratified_pairs(np.random.default_rng(0), PAIRS)
    wi.flags.writeable = wo.flags.writeable = False
    return wi, wo


class PaperNetworks:
    """The paper's networks. Make them of parameters, or by `read`.

    Attributes:
        arch, params, header, fingerprint: as of `nets.weights.Model`.
    """

    def __init__(self, arch: PaperArchitecture, params: Params, header: Mapping[str, Any]):
        """params: arrays of NumPy or JAX.

        Raises:
            ParameterError: a parameter is missing, unknown, of a wrong shape or not finite.
        """
        self.arch, self.header = arch, dict(header)
        self.params = weights.checked_parameters(params, shapes(ALL))
        self.fingerprint = weights.fingerprint(arch.to_json(), self.params)
        self._lock = threading.Lock()
        self._kept: dict[bytes, np.ndarray] = {}  # the oldest first

    @classmethod
    def read(cls, path: str | os.PathLike) -> "PaperNetworks":
        """Read a weights file of `save`.

        Raises:
            FileError: as of `nets.weights.read_file`.
        """
        return weights.read_file(
            path,
            KIND,
            lambda arch, *rest: cls(PaperArchitecture.from_json(json.dumps(arch)), *rest),
        )

    def save(self, path: str | os.PathLike) -> "PaperNetworks":
        """Write a weights file.

        Raises:
            FileError: the file cannot be written.
        """
        weights.write_file(path, self.arch.to_json(), self.params, self.header)
        return self

    def encode(self, f: Any) -> np.ndarray:
        """Codes (..., 32) of values f (..., PAIRS) [1/sr] at `projection_pairs`, by projection.

        A projection takes seconds for 16 pairs in a step, some minutes for 4,096. Codes are kept,
        so that equal BRDFs are projected once. Codes of more than `LEVELS` Lambertian BRDFs are
        interpolated: they vary smoothly with the BRDF.
        """
        values = np.asarray(f, np.float32)
        rows = values.reshape(-1, PAIRS)
        grey = np.ptp(rows, axis=1) <= 1e-4 * rows.max(axis=1)  # but for rounding
        if np.count_nonzero(grey) <= LEVELS:
            grey[:] = False
        codes = np.empty((len(rows), LATENT), np.float32)
        codes[~grey] = self._projected(rows[~grey])
        if grey.any():
            codes[grey] = self._interpolated(rows[grey].mean(axis=1))
        return codes.reshape(*values.shape[:-1], LATENT)

    def _interpolated(self, f: np.ndarray) -> np.ndarray:
        """Codes (M, 32) of Lambertian BRDFs f (M,), between codes of levels."""
        position = LEVELS * np.sqrt(np.pi * np.maximum(f, 0))
        lower = np.floor(position)
        levels, index = np.unique(np.stack([lower, lower + 1]), return_inverse=True)
        values = (levels[:, None] / LEVELS) ** 2 / np.float32(np.pi)
        below, above = self._projected(values.repeat(PAIRS, axis=1))[index.reshape(2, -1)]
        share = (position - lower)[:, None]
        return (1 - share) * below + share * above

    def _projected(self, f: np.ndarray) -> np.ndarray:
        """Codes (M, 32) of BRDFs f (M, PAIRS); the last `KEPT` are kept."""
        from fan2022.projection import project  # needs JAX

        keys = [hashlib.sha256(row.tobytes()).digest() for row in f]
        with self._lock:
            rows = {key: row for key, row in zip(keys, f, strict=True) if key not in self._kept}
            if rows:
                directions = direction_inputs(*projection_pairs())[None]
                codes, _ = project(self.params, directions, np.stack([*rows.values()]), self.arch)
                self._kept |= zip(rows, codes, strict=True)
            found = [self._kept[key] for key in keys]
            for key in list(self._kept)[:-KEPT]:
                del self._kept[key]
        return np.array(found, np.float32).reshape(-1, LATENT)

    def layer(self, z_bottom: np.ndarray, coat: CoatParameters) -> np.ndarray:
        """Codes (..., 32) by the layering network, whose inputs include the interface's code.

        A medium that scatters anisotropically is replaced by the similar isotropic one
        (`inference.isotropic`).

        z_bottom: codes (..., 32) of the bottoms. coat: checked parameters, arrays that broadcast
        against the leading shape of z_bottom.

        Raises:
            ParameterError: the coat has two widths, an index is below one, or there are too many
                different interfaces.
        """
        one_width(coat.alpha, "the coat's")
        coat = CoatParameters(*map(np.float32, coat))
        lowest = np.min(coat.eta)
        if lowest < 1:
            raise ParameterError(
                f"the coat's eta is {lowest:g}, and the paper's networks cover indices above 1 "
                "only; use Urushi's own networks or the random walk for it"
            )
        codes = self._top(coat.alpha, coat.eta), z_bottom
        medium = isotropic(coat.albedo, coat.sigma_t, coat.g)
        shape = np.broadcast_shapes(*(z.shape[:-1] for z in codes), *map(np.shape, medium))
        result = np.empty((*shape, LATENT), np.float32)
        parts = [np.broadcast_to(z, result.shape) for z in codes]
        parts += [np.broadcast_to(x, shape) for x in medium]
        fill_blocks(result, functools.partial(layer, self.params), *parts)
        return result

    def f(self, z: Any, wi: Any, wo: Any) -> Any:
        """Values (...) [1/sr]; the network's negative outputs become zero."""
        return np.maximum(evaluate(self.params, z, direction_inputs(wi, wo)), 0)

    def _top(self, alpha: Any, eta: Any) -> np.ndarray:
        """Codes (..., 32) of rough dielectrics."""
        alpha, eta = np.broadcast_arrays(np.float32(alpha), np.float32(eta))
        keys, index = np.unique(np.stack([alpha.ravel(), eta.ravel()]), axis=1, return_inverse=True)
        if keys.shape[1] > MAX_TOPS:
            raise ParameterError(
                f"the layering has {keys.shape[1]} different interfaces, and the paper's networks "
                f"need a second or more for each; give at most {MAX_TOPS} pairs of alpha and eta, "
                "or use Urushi's own networks"
            )
        codes = self.encode_bare("dielectric", dict(zip(("alpha", "eta"), keys, strict=True)))
        return codes[index.reshape(alpha.shape)]

    def encode_bare(self, kind: str, columns: dict[str, np.ndarray]) -> np.ndarray:
        """Codes (S, 32) of bare surfaces; kind, columns (S,): as of `analytic.rows`."""
        return self.encode(analytic.at_all(kind, columns, *projection_pairs()))
