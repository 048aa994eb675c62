"""Derivatives of `layer_texels` and of anchors, the limit of the albedo included.

Rows (N, ...) are codes of one channel each. A pushforward gives the change of the result for a
change of the inputs, a pullback the gradient with respect to the inputs of a weighted sum of the
results. Both take the result itself, to find the codes that the limit scaled down. The limit's
factor is what the code's lobe leaves of the ceiling over the albedo of the rest, where this is
least; the gain follows its logarithm.
"""

from collections.abc import Callable
from typing import NamedTuple

import numpy as np

from urushi.checks import MIN_ALPHA, CoatParameters
from urushi.material import energy
from urushi.material.albedo_rule import albedo_rule
from urushi.material.fit import refined_slopes
from urushi.material.layer import absent
from urushi.material.lobe_albedo import lobe_albedos
from urushi.nets import derivatives
from urushi.nets import lobe as lobes
from urushi.nets.derivatives import decode_log
from urushi.nets.lobe import WIDTH_PLACES
from urushi.nets.weights import Model
from urushi.parallel import fill_blocks

#: Least reflectance of the diffuse surface at whose code the encoder is differentiated.
LEAST_REFLECTANCE = 0.02

#: Least 1 - albedo and least sigma_t at which the derivatives by the medium of a coat are taken: at
#: the ends of both ranges, the networks' slopes are farther from those of light transport.
MIN_ABSORPTION, MIN_DEPTH = 1e-3, 0.02

#: A code was scaled down if its gain is lower than the network's by more than rounding.
_ROUNDING = 1e-5

#: Step of the central differences of a lobe's albedo: its table is in single precision.
_LOBE_STEP = 1e-3


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
    dcoat: their changes. A coat that is absent changes the code of the bottom by its own change.
    """
    gain = model.arch.lobe
    dcoat = np.where(_without_meaning(coat), 0, dcoat)

    def block(z_bottom, coat, z, dz_bottom, dcoat):
        (inside, medium), none = _inside(coat), _absent(coat)
        dz = derivatives.layer_pushforward(
            model.params,
            model.arch,
            z_bottom,
            coat,
            np.where(none, 0, dz_bottom),
            np.where(medium, 0, dcoat),
        )
        dz += derivatives.layer_pushforward(
            model.params, model.arch, z_bottom, inside, 0 * dz_bottom, medium * dcoat
        )
        for row in _limited_coats(model, z_bottom, coat, z):
            dz[row, gain] += _log_factor(model, z[row]) @ dz[row]
        return dz + np.where(none & _rendered(model, z_bottom), dz_bottom, 0)

    return _fill_rows(model.arch.latent, block, z_bottom, coat, z, dz_bottom, dcoat)


def layer_pullback(
    model: Model, z_bottom: np.ndarray, coat: np.ndarray, z: np.ndarray, dz: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Return gradients (N, L) and (N, C) with respect to z_bottom and coat.

    dz (N, L): the weights of the codes z; the others as in `layer_pushforward`.
    """
    gain = model.arch.lobe

    def block(z_bottom, coat, z, dz):
        (inside, medium), none = _inside(coat), _absent(coat)
        kept, dz = np.where(none & _rendered(model, z_bottom), dz, 0), dz.copy()
        for row in _limited_coats(model, z_bottom, coat, z):
            dz[row] += dz[row, gain] * _log_factor(model, z[row])
        of_bottom, of_coat = derivatives.layer_pullback(
            model.params, model.arch, z_bottom, coat, dz
        )
        _, of_inside = derivatives.layer_pullback(model.params, model.arch, z_bottom, inside, dz)
        of_coat = np.where(medium, medium * of_inside, of_coat)
        return np.concatenate([np.where(none, kept, of_bottom), of_coat], axis=-1)

    both = _fill_rows(model.arch.latent + coat.shape[-1], block, z_bottom, coat, z, dz)
    of_coat = np.where(_without_meaning(coat), 0, both[:, model.arch.latent :])
    return both[:, : model.arch.latent], of_coat


def _without_meaning(coat: np.ndarray) -> np.ndarray:
    """Whether a parameter of coats (N, C) is the width of an index of 1, which is no interface."""
    return (coat[:, 1:2] == 1) & np.isin(np.arange(coat.shape[-1]), (0, 5))


def linearised(model: Model, f: np.ndarray, anchors: np.ndarray) -> np.ndarray:
    """Return the codes (N, L) at which derivatives of anchors (N, L) of f (N, P) are taken.

    They are the anchors, but for rests below that of a diffuse surface of `LEAST_REFLECTANCE`:
    networks see logarithms, whose derivatives mean nothing there, and that surface stands for them.
    """

    def block(f, z):
        encoding = _Encoding.of(model, f, z)
        return np.where(encoding.dark[:, None], encoding.encoded, z)

    return _fill_rows(model.arch.latent, block, f, anchors)


def encode_pushforward(
    model: Model, f: np.ndarray, z: np.ndarray, df: np.ndarray, dlobe: np.ndarray | None = None
) -> np.ndarray:
    """Return the change (N, L) of the codes z of f (N, P) for a change df (N, P).

    z (N, L): codes of `linearised`. dlobe (N, K): the change of their lobes, if these are known;
    None: they are fitted to f. The limit of a bottom's albedo is ignored, so that an optimiser can
    leave white.
    """
    arch, networks = model.arch, model.networks

    def block(f, z, df, *dlobe):
        lobe = z[:, : arch.lobe]
        of_lobe = dlobe[0] if dlobe else derivatives.lobe_pushforward(arch, f, df, lobe)
        encoding = _Encoding.of(model, f, z)
        drest = df - (derivatives.top_slopes(arch, lobe) * of_lobe[..., None]).sum(axis=1)
        drest = np.where(encoding.seen, drest, 0).astype(np.float32)
        dz = derivatives.encode_pushforward(model.params, arch, encoding.rest, drest)
        dz = np.concatenate([of_lobe, dz], axis=-1).astype(np.float32)
        for row in encoding.refined:
            dz[row, arch.lobe :] = refined_slopes(networks, f[row], z[row]) @ drest[row]
        return dz

    given = () if dlobe is None else (dlobe,)
    return _fill_rows(arch.latent, block, f, z, df, *given)


def encode_pullback(
    model: Model, f: np.ndarray, z: np.ndarray, dz: np.ndarray, fitted: bool = True
) -> tuple[np.ndarray, np.ndarray]:
    """Return gradients (N, P) and (N, K) with respect to f (N, P) and the lobes of codes z (N, L).

    dz (N, L): the weights of the codes. fitted: whether the lobes are fitted to f. Their gradients
    are then contained in the first result. The others as in `encode_pushforward`.
    """
    arch, networks = model.arch, model.networks

    def block(f, z, dz):
        lobe = z[:, : arch.lobe]
        encoding = _Encoding.of(model, f, z)
        of_rest = dz[:, arch.lobe :]
        of_f = derivatives.encode_pullback(model.params, arch, encoding.rest, of_rest)
        for row in encoding.refined:
            of_f[row] = of_rest[row] @ refined_slopes(networks, f[row], z[row])
        of_f = np.where(encoding.seen, of_f, 0)
        of_lobe = dz[:, : arch.lobe]
        of_lobe = of_lobe - (derivatives.top_slopes(arch, lobe) @ of_f[..., None])[..., 0]
        if fitted:
            of_f = of_f + derivatives.lobe_pullback(arch, f, of_lobe, lobe)
        return np.concatenate([of_f, of_lobe], axis=-1)

    both = _fill_rows(f.shape[-1] + arch.lobe, block, f, z, dz)
    return both[:, : f.shape[-1]], both[:, f.shape[-1] :]


class _Encoding(NamedTuple):
    """How codes (N, L) depend on their values f (N, P).

    Attributes:
        rest: (N, P) [1/sr] the values that the encoder sees.
        seen: (N, P) whether a change of f changes them.
        encoded: (N, L) the encoder's codes of them.
        dark: (N,) whether they stand for a darker rest, see `linearised`.
        refined: (K,) rows of codes that were fitted, not encoded.
    """

    rest: np.ndarray
    seen: np.ndarray
    encoded: np.ndarray
    dark: np.ndarray
    refined: np.ndarray

    @classmethod
    def of(cls, model: Model, f: np.ndarray, z: np.ndarray) -> "_Encoding":
        """The dependence at f and codes z."""
        networks, gain = model.networks, model.arch.lobe
        lobe = z[:, :gain]
        rest = f - networks.top(z[:, None], *networks.pairs())
        least, seen = np.float32(LEAST_REFLECTANCE / np.pi), rest >= 0
        rest = np.maximum(rest, 0)
        dark = (rest.mean(axis=-1) < least) | energy.are_bare(model, z)
        rest[dark], seen[dark] = least, True
        none = np.array(lobes.no_lobe(model.widths), np.float32)
        encoded = networks.encode(rest, np.broadcast_to(none, lobe.shape))
        encoded = np.concatenate([lobe, encoded[:, gain:]], axis=-1)
        away = np.abs(encoded - z)[:, gain + 1 :].max(axis=-1) > _ROUNDING
        return cls(rest, seen, encoded, dark, np.flatnonzero(away & ~dark))


def _fill_rows(columns: int, block, *arrays: np.ndarray) -> np.ndarray:
    """The rows of block(*arrays) (N, columns), on all cores."""
    result = np.empty((len(arrays[0]), columns), np.float32)
    fill_blocks(result, block, *(np.asarray(array, np.float32) for array in arrays))
    return result


def _absent(coat: np.ndarray) -> np.ndarray:
    """`layer.absent` (N, 1) of coats (N, C)."""
    return absent(CoatParameters.of_columns(coat.T))[:, None]


def _rendered(model: Model, z: np.ndarray) -> np.ndarray:
    """Which numbers (N, L) of codes z (N, L) are rendered: not the rests of bare surfaces."""
    return (np.arange(z.shape[-1]) < model.arch.lobe) | ~energy.are_bare(model, z)[:, None]


def _limited_coats(
    model: Model, z_bottom: np.ndarray, coat: np.ndarray, z: np.ndarray
) -> np.ndarray:
    """The rows (K,) of codes z of coats (N, C) that the limit scaled down."""
    gain = model.arch.lobe
    unlimited = model.networks.layer(z_bottom, CoatParameters.of_columns(coat.T))
    return np.flatnonzero((z[:, gain] < unlimited[:, gain] - _ROUNDING) & ~_absent(coat)[:, 0])


def _inside(coat: np.ndarray) -> tuple[np.ndarray, np.ndarray]:
    """Coats (N, C) within `MIN_ABSORPTION` and `MIN_DEPTH`, and shares (N, C) of their derivatives.

    These are the derivatives by the medium, if a coat is outside. The share is less than one of
    albedo and g, which have no effect without a medium; it is zero of all other derivatives.
    """
    inside, medium = coat.copy(), np.zeros_like(coat)
    inside[:, 2] = np.minimum(coat[:, 2], 1 - MIN_ABSORPTION)
    inside[:, 3] = np.maximum(coat[:, 3], MIN_DEPTH)
    medium[:, 2:5] = (inside != coat).any(axis=-1, keepdims=True)
    medium[:, [2, 4]] *= (coat[:, 3] / inside[:, 3])[:, None]
    return inside, medium


def _log_factor(model: Model, z: np.ndarray) -> np.ndarray:
    """Gradient (L,) of the logarithm of the limit's factor by a code z (L,).

    The gradient of ln f of the rest does not change with the gain, so that limited codes may stand
    for unlimited ones.
    """
    rest, rest_slopes, top, top_slopes = _albedos(model, z)
    allowed = np.maximum(1 - energy.MARGIN - top, energy.LEAST_REST)
    at = int((rest / allowed).argmax())
    of_allowed = 1 / allowed[at] if allowed[at] > energy.LEAST_REST else 0.0
    of_rest = -rest_slopes(at) / max(rest[at], energy.LEAST_ALBEDO)
    return np.concatenate([-of_allowed * top_slopes(at), of_rest]).astype(np.float32)


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
