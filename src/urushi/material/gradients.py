"""Derivatives of `layer_texels` and `limited_codes`, the limit of the albedo included.

Rows (N, ...) are codes of one channel each. A pushforward gives the change of the result for a
change of the inputs, a pullback the gradient with respect to the inputs of a weighted sum of the
results. Both take the result itself, to find the codes that the limit scaled down. The limit's
factor is what the code's lobe leaves of the ceiling over the albedo of the rest, where this is
least; the gain follows its logarithm.
"""

from collections.abc import Callable

import numpy as np

from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.errors import ParameterError
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.layer import PRESENT, presence
from urushi.material.lobe_albedo import lobe_albedos
from urushi.nets import derivatives
from urushi.nets.derivatives import decode_log
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.networks import UrushiNetworks
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: A code was scaled down if its gain is lower than the network's by more than rounding.
_ROUNDING = 1e-5

#: Step of the central differences of a lobe's albedo: its table is in single precision.
_LOBE_STEP = 1e-3


def check_differentiable(model: Model, where: str) -> None:
    """Check that these networks have derivatives.

    Raises:
        ParameterError: they are networks of another system.
    """
    if not isinstance(model.networks, UrushiNetworks):
        raise ParameterError(
            f"{where}: gradients are requested, but networks such as those of Fan et al. (2022) "
            "do not support them; use the shipped networks"
        )


def layer_pushforward(
    model: Model,
    z_bottom: np.ndarray,
    coat: np.ndarray,
    z: np.ndarray,
    dz_bottom: np.ndarray,
    dcoat: np.ndarray,
) -> np.ndarray:
    """Return the change (N, L) of `layer_texels`' codes z (N, L).

    z_bottom (N, L): the bottoms' codes; coat (N, C): columns `checks.COAT_COLUMNS`; dz_bottom and
    dcoat: their changes. The blend of nearly absent coats with the bottom is neglected.
    """
    gain = model.arch.lobe

    def block(z_bottom, coat, z, dz_bottom, dcoat):
        dz = derivatives.layer_pushforward(
            model.params, model.arch, z_bottom, coat, dz_bottom, dcoat
        )
        for row in _limited_coats(model, z_bottom, coat, z):
            of_z, of_bottom = _log_factor(model, z[row], z_bottom[row])
            dz[row, gain] += of_z @ dz[row] + of_bottom @ dz_bottom[row]
        return dz

    return _fill_rows(model.arch.latent, block, z_bottom, coat, z, dz_bottom, dcoat)


def layer_pullback(
    model: Model, z_bottom: np.ndarray, coat: np.ndarray, z: np.ndarray, dz: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return gradients (N, L) and (N, C) with respect to z_bottom and coat.

    dz (N, L): the weights of the codes z; the others as in `layer_pushforward`.
    """
    gain = model.arch.lobe

    def block(z_bottom, coat, z, dz):
        dz, of_limit = dz.copy(), np.zeros_like(dz)
        for row in _limited_coats(model, z_bottom, coat, z):
            of_z, of_bottom = _log_factor(model, z[row], z_bottom[row])
            of_limit[row] = dz[row, gain] * of_bottom
            dz[row] += dz[row, gain] * of_z
        of_bottom, of_coat = derivatives.layer_pullback(
            model.params, model.arch, z_bottom, coat, dz
        )
        return np.concatenate([of_bottom + of_limit, of_coat], axis=-1)

    both = _fill_rows(model.arch.latent + coat.shape[-1], block, z_bottom, coat, z, dz)
    return both[:, : model.arch.latent], both[:, model.arch.latent :]


def encode_pushforward(model: Model, f: np.ndarray, z: np.ndarray, df: np.ndarray) -> np.ndarray:
    """Return the change (N, L) of `limited_codes`' codes z of f (N, P) for a change df (N, P)."""

    gain = model.arch.lobe

    def block(f, z, df):
        lobe = z[:, :gain]
        dz = derivatives.encode_pushforward(model.params, model.arch, f, df, lobe)
        for row in _limited_rows(model, z, _encoded(model, f, lobe)):
            dz[row, gain] += _log_share(model, z[row], 1 - energy.MARGIN)[0] @ dz[row]
        return dz

    return _fill_rows(model.arch.latent, block, f, z, df)


def encode_pullback(model: Model, f: np.ndarray, z: np.ndarray, dz: np.ndarray) -> np.ndarray:
    """Return the gradient (N, P) with respect to f (N, P); dz (N, L): the weights of codes z."""

    gain = model.arch.lobe

    def block(f, z, dz):
        dz, lobe = dz.copy(), z[:, :gain]
        for row in _limited_rows(model, z, _encoded(model, f, lobe)):
            dz[row] += dz[row, gain] * _log_share(model, z[row], 1 - energy.MARGIN)[0]
        return derivatives.encode_pullback(model.params, model.arch, f, dz, lobe)

    return _fill_rows(f.shape[-1], block, f, z, dz)


def _fill_rows(columns: int, block, *arrays: np.ndarray) -> np.ndarray:
    """The rows of block(*arrays) (N, columns), on all cores."""
    result = np.empty((len(arrays[0]), columns), np.float32)
    fill_blocks(result, block, *(np.asarray(array, np.float32) for array in arrays))
    return result


def _unlimited(model: Model, z_bottom: np.ndarray, coat: np.ndarray) -> np.ndarray:
    """The layerer's output before energy is limited: codes (N, L)."""
    return model.networks.layer(z_bottom, CoatParameters.of_columns(coat.T))


def _encoded(model: Model, f: np.ndarray, lobe: np.ndarray) -> np.ndarray:
    """The encoder's output for f (N, P) before energy is limited: codes (N, L)."""
    assert isinstance(model.networks, UrushiNetworks)  # for the type checker
    return model.networks.encode(f, lobe)


def _limited_rows(model: Model, z: np.ndarray, unlimited: np.ndarray) -> np.ndarray:
    """The rows (K,) of codes that the limit scaled down."""
    gain = model.arch.lobe
    return np.flatnonzero(z[:, gain] < unlimited[:, gain] - _ROUNDING)


def _limited_coats(
    model: Model, z_bottom: np.ndarray, coat: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """The rows (K,) of codes z of coats (N, C) that the limit scaled down."""
    rows = _limited_rows(model, z, _unlimited(model, z_bottom, coat))
    chosen = CoatParameters.of_columns(coat[rows].T)
    return rows[presence(chosen.alpha, chosen.eta, chosen.sigma_t) >= PRESENT]


def _log_factor(model: Model, z: np.ndarray, z_bottom: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Gradients (L,) of the log of a coat's factor with respect to its and the bottom's code.

    The ceiling is a constant, or the largest albedo of a bottom that gains energy.
    """
    rest, rest_slopes, top, top_slopes = _albedos(model, energy.as_rendered(model, z_bottom))
    peak = int((rest + top).argmax())
    ceiling = rest[peak] + top[peak]
    if ceiling > 1 + energy.TOLERANCE:
        of_z, of_ceiling = _log_share(model, z, ceiling)
        of_bottom = of_ceiling * np.concatenate([top_slopes(peak), rest_slopes(peak)])
        return of_z, of_bottom.astype(np.float32)
    of_z, _ = _log_share(model, z, 1 - energy.MARGIN)
    return of_z, np.zeros_like(of_z)


def _log_share(model: Model, z: np.ndarray, ceiling: float) -> tuple[np.ndarray, float]:
    """Gradients of the log of the limit's factor by the code z (L,) and by the ceiling.

    The gradient of ln f of the rest does not change with the gain, so that limited codes may stand
    for unlimited ones.
    """
    rest, rest_slopes, top, top_slopes = _albedos(model, z)
    lobe = z[: model.arch.lobe]
    least = energy.least_rests(lobe)[0]
    allowed, seen = np.maximum(ceiling - top, least), ~energy.near_edge(lobe)
    at = int((seen * rest / allowed).argmax())
    of_allowed = 1 / allowed[at] if allowed[at] > least else 0.0
    of_rest = -rest_slopes(at) / max(rest[at], energy.LEAST_ALBEDO)
    of_z = np.concatenate([-of_allowed * top_slopes(at), of_rest])
    return of_z.astype(np.float32), float(of_allowed)


#: From an index of an angle to the derivatives of the albedo there.
_Slopes = Callable[[int], np.ndarray]


def _albedos(model: Model, z: np.ndarray) -> tuple[np.ndarray, _Slopes, np.ndarray, _Slopes]:
    """Directional albedos (D,) of the rest of a code z (L,) and of its lobe, and their slopes."""
    rule, lobe = albedo_rule(model.arch.widths), z[: model.arch.lobe]
    log_f, slopes = decode_log(model.params, model.arch, z[None, model.arch.lobe :], rule.features)
    f = np.exp(log_f)
    counts, at_angles = np.diff(rule.first, append=len(rule.weights)), rule.at_angles(f)

    def of_rest(angle: int) -> np.ndarray:
        of_angles = rule.interpolated_slopes(at_angles, angle)
        return (np.repeat(of_angles, counts) * rule.weights * f) @ slopes

    def of_top(angle: int) -> np.ndarray:
        stepped = np.concatenate([lobe + _LOBE_STEP * way * np.eye(len(lobe)) for way in (1, -1)])
        stepped = stepped.astype(np.float32)
        for place in WIDTH_PLACES[model.arch.widths]:
            stepped[:, place] = np.clip(stepped[:, place], MIN_ALPHA, 1)
        upper, lower = np.split(lobe_albedos(stepped, rule)[:, angle], 2)
        wide, narrow = np.split(stepped, 2)
        return (upper - lower) / (wide - narrow).diagonal()

    return rule.interpolated(at_angles), of_rest, lobe_albedos(lobe, rule), of_top
