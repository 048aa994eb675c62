"""Derivatives of `layer_texels` and `limited_codes`, the limit of the albedo included.

Rows (N, ...) are codes of one channel each. A pushforward gives the change of the result for a
change of the inputs, a pullback the gradient with respect to the inputs of a weighted sum of the
results. Both take the result itself, to find the codes that the limit scaled down: their gain
follows the logarithm of their greatest albedo, with the opposite sign.
"""

import numpy as np

from urushi.checks import CoatParameters
from urushi.errors import ParameterError
from urushi.material import energy
from urushi.nets import derivatives
from urushi.nets.derivatives import decode_log
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: A code was scaled down if its gain is lower than the network's by more than rounding.
_ROUNDING = 1e-5


def check_differentiable(model: Model, where: str) -> None:
    """Check that these networks have derivatives.

    Raises:
        ParameterError: they are networks of another system.
    """
    if not isinstance(model.networks, UrushiNetworks):
        raise ParameterError(
            f"{where}: gradients are asked for, but networks such as those of Fan et al. (2022) "
            "have none here; use 'base' or 'small'"
        )


def layer_pushforward(
    model: Model,
    z_bottom: np.ndarray,
    coat: np.ndarray,
    z: np.ndarray,
    dz_bottom: np.ndarray,
    dcoat: np.ndarray,
) -> np.ndarray:
    """Return the change (N, 32) of `layer_texels`' codes z (N, 32).

    z_bottom (N, 32): the bottoms' codes; coat (N, 5): alpha, eta, albedo, sigma_t, g; dz_bottom and
    dcoat: their changes.
    """

    def block(z_bottom, coat, z, dz_bottom, dcoat):
        dz = derivatives.layer_pushforward(
            model.params, model.arch, z_bottom, coat, dz_bottom, dcoat
        )
        rows = _limited_rows(z, _unlimited(model, z_bottom, coat))
        for row in rows:
            of_z, of_bottom = _log_factor(model, z[row], z_bottom[row])
            dz[row, 0] += of_z @ dz[row] + of_bottom @ dz_bottom[row]
        return dz

    return _fill_rows(model.arch.latent, block, z_bottom, coat, z, dz_bottom, dcoat)


def layer_pullback(
    model: Model, z_bottom: np.ndarray, coat: np.ndarray, z: np.ndarray, dz: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return gradients (N, 32) and (N, 5) with respect to z_bottom and coat.

    dz (N, 32): the weights of the codes z; the others as in `layer_pushforward`.
    """

    def block(z_bottom, coat, z, dz):
        dz, of_limit = dz.copy(), np.zeros_like(dz)
        for row in _limited_rows(z, _unlimited(model, z_bottom, coat)):
            of_z, of_bottom = _log_factor(model, z[row], z_bottom[row])
            of_limit[row] = dz[row, 0] * of_bottom
            dz[row] += dz[row, 0] * of_z
        of_bottom, of_coat = derivatives.layer_pullback(
            model.params, model.arch, z_bottom, coat, dz
        )
        return np.concatenate([of_bottom + of_limit, of_coat], axis=-1)

    both = _fill_rows(model.arch.latent + coat.shape[-1], block, z_bottom, coat, z, dz)
    return both[:, : model.arch.latent], both[:, model.arch.latent :]


def encode_pushforward(model: Model, f: np.ndarray, z: np.ndarray, df: np.ndarray) -> np.ndarray:
    """Return the change (N, 32) of `limited_codes`' codes z of f (N, P) for a change df (N, P)."""

    def block(f, z, df):
        dz = derivatives.encode_pushforward(model.params, model.arch, f, df)
        for row in _limited_rows(z, model.networks.encode(f)):
            dz[row, 0] -= _log_peak(model, z[row])[1] @ dz[row]
        return dz

    return _fill_rows(model.arch.latent, block, f, z, df)


def encode_pullback(model: Model, f: np.ndarray, z: np.ndarray, dz: np.ndarray) -> np.ndarray:
    """Return the gradient (N, P) with respect to f (N, P); dz (N, 32): the weights of codes z."""

    def block(f, z, dz):
        dz = dz.copy()
        for row in _limited_rows(z, model.networks.encode(f)):
            dz[row] -= dz[row, 0] * _log_peak(model, z[row])[1]
        return derivatives.encode_pullback(model.params, model.arch, f, dz)

    return _fill_rows(f.shape[-1], block, f, z, dz)


def _fill_rows(columns: int, block, *arrays: np.ndarray) -> np.ndarray:
    """The rows of block(*arrays) (N, columns), on all cores."""
    result = np.empty((len(arrays[0]), columns), np.float32)
    fill_blocks(result, block, *(np.asarray(array, np.float32) for array in arrays))
    return result


def _unlimited(model: Model, z_bottom: np.ndarray, coat: np.ndarray) -> np.ndarray:
    """What the layerer makes before energy is limited: codes (N, 32)."""
    return model.networks.layer(z_bottom, CoatParameters(*coat.T))


def _limited_rows(z: np.ndarray, unlimited: np.ndarray) -> np.ndarray:
    """The rows (K,) of codes that the limit scaled down."""
    return np.flatnonzero(z[:, 0] < unlimited[:, 0] - _ROUNDING)


def _log_factor(model: Model, z: np.ndarray, z_bottom: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (32,) of the log of a coat's factor with respect to its and the bottom's code.

    The ceiling is a constant, or the largest albedo of a bottom that gains energy.
    """
    of_z = -_log_peak(model, z)[1]
    peak, of_bottom = _log_peak(model, z_bottom)
    return of_z, of_bottom if peak > np.log1p(energy.TOLERANCE) else np.zeros_like(of_bottom)


def _log_peak(model: Model, z: np.ndarray) -> tuple[float, np.ndarray]:
    """The logarithm of a code's (32,) largest albedo, and its gradient (32,).

    The gradient of ln f does not change with the gain, so that limited codes may stand for
    unlimited ones.
    """
    rule = energy.albedo_rule()
    log_f, slopes = decode_log(model.params, model.arch, z[None], rule.features)
    f = np.exp(log_f)
    albedo = rule.albedo(f)
    largest = albedo.argmax()
    counts = np.diff(rule.first, append=len(rule.weights))
    shares = np.repeat(rule.interpolation[largest], counts) * rule.weights * f
    peak = max(albedo[largest], energy.LEAST_ALBEDO)
    return np.log(peak), (shares @ slopes / peak).astype(np.float32)
