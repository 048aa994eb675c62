"""Layering: coats over materials, by light transport or by the layering network.

Light transport through a coat at the probe pairs gives the code of a coated material, and at the
nodes its table (`urushi.material.coated_table`). The layering network maps codes to codes, for many
texels at once.
"""

import functools
import warnings
from dataclasses import replace
from typing import Any

import numpy as np
import numpy.typing as npt

from urushi import checks
from urushi.checks import CoatParameters, Widths
from urushi.core import appearance
from urushi.core.appearance import described
from urushi.core.microfacet import of_widths
from urushi.core.table import node_pairs, table_of_values
from urushi.errors import ParameterError, UrushiWarning
from urushi.material.coated_table import coated_table
from urushi.material.coated_values import coated_f
from urushi.material.energy import limit_albedo, nearest_within
from urushi.material.material import Coating, Material
from urushi.material.source import as_source
from urushi.material.symmetry import Deviations, deviations_of
from urushi.material.values import encode_source, model_for
from urushi.nets import lobe as lobes
from urushi.nets.transmittance import both_ways, table_beside
from urushi.nets.weights import Model, Weights, anisotropic_model, default_model
from urushi.parallel import fill_blocks
from urushi.walk import Dielectric, Stack
from urushi.walk.bottoms import Description
from urushi.walk.simulate import Compensation
from urushi.walk.stack import Coat
from urushi.walk.stack import under as described_under

#: Optical depth to which deeper media are cut: up to here the network is closest to a medium at
#: its own depth.
DEEPEST = 12.0

#: Largest ratio of two widths that is layered: OpenPBR's anisotropy of 0.9 has it. Errors up to
#: here are as small as at the trained ratios.
WIDEST = 1.25 * checks.TRAINED_WIDTH_RATIO


def layer(
    top: Dielectric,
    bottom: Any,
    *,
    albedo: npt.ArrayLike | None = None,
    sigma_t: npt.ArrayLike | None = None,
    g: npt.ArrayLike = checks.DEFAULT_COAT.g,
    color: npt.ArrayLike | None = None,
    body: npt.ArrayLike | None = None,
    body_color: npt.ArrayLike | None = None,
    thickness: float = 1.0,
    energy_compensation: bool = False,
    weights: Weights | None = None,
    fast: bool = False,
) -> Material:
    """Coat a material with a rough dielectric over a homogeneous medium of unit thickness.

    Args:
        top: the coat's interface, from `urushi.dielectric(alpha, ior=...)`, isotropic or
            anisotropic. A relative index of 1 is no interface: the coat is its medium.
        bottom: a Material, or anything that `encode` accepts; coats nest, and keep the indices that
            they were given as `ior` (see `under`). All layers share one tangent: a bottom that was
            `rotated` cannot get an anisotropic coat.
        albedo, sigma_t, g, color, body, body_color, thickness: of the medium, as in `urushi.coat`;
            a g of less than -0.95 is -0.95.
        energy_compensation: as in `urushi.coat`. The result has a table, which it is part of; coats
            over the code of the result do not see it.
        weights: as in `encode`, for a bottom that is not a Material.
        fast: whether the layering network computes the code, in milliseconds and less accurately.
            Otherwise light transport is computed, which takes some tenths of a second, and
            isotropic results have a table.

    Every parameter but the thickness is a scalar or one value per RGB channel.

    Returns:
        A Material of the bottom's channels, or of three if the bottom has one and a parameter has
        three. It is anisotropic if top or bottom are. It equals the bottom if the coat has neither
        an interface nor a medium.

    Raises:
        ParameterError: top is not a dielectric, or a parameter is out of range or of a wrong shape;
            or top is anisotropic and the bottom is rotated, or has weights for isotropic materials
            that are not the shipped ones; or the two widths of a surface have a ratio above 10; or
            anisotropic weights get energy_compensation.

    Warns:
        UrushiWarning: the medium is outside the network's training data, and the code is that of a
            similar medium (`within_training`).
    """
    if not isinstance(top, Dielectric):
        raise ParameterError(
            f"the top of a layering is a {type(top).__name__}; give the coat's interface, "
            "urushi.dielectric(alpha, ior=...)"
        )
    bottom = _below(under(bottom, top.eta), weights, isinstance(top.alpha, Widths))
    look = {"color": color, "body": body, "body_color": body_color}
    medium = described(
        "the coat's", g=g, thickness=thickness, albedo=albedo, sigma_t=sigma_t, **look
    )
    coat = Coat(top.alpha, top.eta, *medium, g).parameters  # type: ignore[arg-type]
    if bottom.channels not in (1, 3):
        names = checks.COAT_COLUMNS[2 if isinstance(top.alpha, Widths) else 1]
        columns = zip(names, coat.columns(), strict=True)
        name = next((name for name, value in columns if np.ndim(value)), None)
        if name:
            raise ParameterError(
                f"the coat's {name} has three values, but the bottom has {bottom.channels} "
                "channels; give a scalar"
            )
    if energy_compensation and bottom.model.widths == 2:
        raise ParameterError(
            "layer: energy_compensation needs a table, and anisotropic materials have none; give "
            "it to urushi.coat, and encode that"
        )
    coating = Coating(coat, top.ior is not None, bottom, fast, energy_compensation)
    coated = _coated(coating)
    if fast:
        checks.warn_of_training(checks.outside_training(coat), "layer: the coat's")
    return coated


def under(bottom: Any, index: npt.ArrayLike) -> Any:
    """A source of `encode` below a medium.

    Coats whose index is absolute keep it: they are layered again. Conductors of complex index get
    the index relative to the medium. All others stay as they are: measured and other BRDFs, and
    materials without a known coat that are no conductors.

    index: of the medium, a number or one per channel, relative to the one that lies above now.
    """
    if not isinstance(bottom, Material):
        return described_under(bottom, index)
    index = np.asarray(index, np.float64)
    if bottom.coating is not None:
        coating = bottom.coating
        if coating.absolute:
            ratio = coating.coat.eta / index
            ratio = checks.eta(ratio, "the lower coat's relative index", any_shape=True)
            coating = coating._replace(coat=coating.coat._replace(eta=ratio))
        else:
            coating = coating._replace(bottom=under(coating.bottom, index))
        return replace(_coated(coating), rotation=bottom.rotation)
    size = bottom.model.arch.lobe
    index = index.astype(np.float32)
    if not (bottom.latents[:, 5] > 0).any() or (index == 1).all():
        return bottom
    rest = bottom.latents[:, size:]
    latents = np.concatenate([lobes.under(bottom.latents[:, :size], index), rest], axis=1)
    table = bottom.table
    if table is not None and not bottom.beside_lobe:
        wi, wo = (w[:, None] for w in node_pairs())
        old, new = (lobes.f(z[:, :size], wi, wo) for z in (bottom.latents, latents))
        table = table_of_values(np.exp(table.reshape(old.shape).astype(np.float32)) + new - old)
    return replace(bottom, latents=latents, table=table)


def stacked(stack: Stack, model: Model) -> Material | None:
    """The material of a stack, coat by coat by light transport.

    None if only random walks know it: the bottom has no f, or a coat has energy compensation and
    two widths.
    """
    if not isinstance(stack.bottom, Description):
        return None
    if stack.is_anisotropic and model.widths == 1:
        return None
    compensated = stack.coats[0].energy_compensation
    if compensated and model.widths == 2:
        return None
    material = encode_source(stack.bottom, model)[0]
    for place, coat in reversed(list(enumerate(stack.coats))):
        compensates = compensated and place == 0
        coating = Coating(coat.parameters, coat.ior is not None, material, compensated=compensates)
        material = _coated(coating)
    return material


def _coated(coating: Coating) -> Material:
    """The material that a coating describes, with its energy compensation."""
    coat, _, bottom, fast, compensated = coating
    material = layer_material(coat, bottom, fast)
    if compensated:
        f, wi = bottom.f([appearance.WI], [appearance.WO])[0], [[0.0, 0.0, 1.0]]
        pairs = node_pairs()
        lobe = Compensation(coat, bottom.directional_albedo(wi)[0], f).f(*pairs)
        values = np.exp(own_table(material).astype(np.float32)).reshape(len(lobe), -1)
        own = material.latents[:, : material.model.arch.lobe]
        values += lobe / both_ways(own, *(w[:, None] for w in pairs))
        material = replace(material, table=table_of_values(values), beside_lobe=True)
    return replace(material, coating=coating)


def layer_material(coat: CoatParameters, bottom: Material, fast: bool = False) -> Material:
    """`layer` for checked parameters: arrays (C,), (1,) or ().

    A coat without an interface and without a medium changes nothing: the bottom is returned.
    """
    model = bottom.model
    coat = with_widths(model, coat)
    none = absent(coat)
    if none.all():
        return bottom
    if fast:
        codes = limit_albedo(model, predicted(model, bottom.latents, coat))
        codes = np.where(none[..., None], bottom.latents, codes)
        return Material(codes, model, rotation=bottom.rotation)
    codes = transported_codes(coat, bottom)
    if model.widths == 2:
        return Material(codes, model, rotation=bottom.rotation)
    table = coated_table(bottom, coat, codes[:, : model.arch.lobe])
    if none.any():
        table = np.where(none, own_table(bottom), table)
    return Material(codes, model, table, beside_lobe=True)


def transported_codes(coat: CoatParameters, bottom: Material) -> np.ndarray:
    """Codes float32 (C, L) of a material under checked coats, by light transport at the probe
    pairs. A table takes ten times as long."""
    model, pairs = bottom.model, bottom.model.networks.pairs()
    check_ratios(model, bottom.latents, coat)
    rest = coated_f(bottom, coat, *pairs).T
    return codes_of_rests(model, rest, coat, bottom.latents)


def codes_of_rests(
    model: Model, rest: np.ndarray, coat: CoatParameters, z: np.ndarray
) -> np.ndarray:
    """Codes (..., L) of bottoms z (..., L) under coats (...).

    rest: (..., P) f [1/sr] at the probe pairs without the lobes of the coats.
    """
    lobe = lobes.of_coat(coat.alpha, coat.eta).astype(np.float32)
    lobe = np.broadcast_to(lobe, (*rest.shape[:-1], model.arch.lobe))
    g = rest / both_ways(lobe[..., None, :], *model.networks.pairs())
    codes = nearest_within(model, model.networks.encode_rest(g, lobe))
    return np.where(absent(coat)[..., None], z, codes)


def warn_of(deviations: Deviations | None, name: str) -> None:
    """Warn of what a material cannot represent; name: of the source."""
    for sentence in deviations.warnings() if deviations else ():
        warnings.warn(f"{name}: {sentence}", UrushiWarning, stacklevel=3)


def own_table(material: Material) -> np.ndarray:
    """The table float16 (U, V, W, C) of a material beside its lobe."""
    if material.table is None or material.beside_lobe:
        return material.logs().astype(np.float16)
    return table_beside(material.f(*node_pairs()), material.latents[:, : material.model.arch.lobe])


def _below(bottom: Any, weights: Weights | None, anisotropic: bool) -> Material:
    """The bottom of a coat as a material; its weights are anisotropic if the coat is."""
    if anisotropic and weights is None:
        own = bottom.model if isinstance(bottom, Material) else default_model()
        if own.widths == 1:
            if own.fingerprint != default_model().fingerprint:
                raise ParameterError(
                    f"the coat's alpha_u and alpha_v differ, but the weights {own.fingerprint} of "
                    "the bottom are for isotropic materials; encode it with the shipped ones"
                )
            weights = anisotropic_model()
    if not isinstance(bottom, Material) or weights is not None:
        bottom, deviations = encoded(bottom, weights)
        warn_of(deviations, "layer: the bottom")
    if anisotropic and bottom.rotation % 180 != 0:
        raise ParameterError(
            f"the bottom is rotated by {bottom.rotation:g} degrees, and the coat's alpha_u and "
            "alpha_v differ, but all layers share one tangent; coat the bottom first, then rotate "
            "the result"
        )
    return bottom


def encoded(
    source: Any, weights: Weights | None = None, table: bool | None = None
) -> tuple[Material, Deviations | None]:
    """`encode` without its warnings.

    Returns:
        The material, and the deviations of the source, if it is not a Material of these weights.
    """
    model = model_for(source, weights)
    if isinstance(source, Material) and source.model.fingerprint == model.fingerprint:
        return source, None
    material = stacked(source, model) if isinstance(source, Stack) else None
    if material is None:
        return encode_source(source, model, table=table)
    return material, deviations_of(as_source(source), widths=model.widths)


def with_widths(model: Model, coat: CoatParameters) -> CoatParameters:
    """The coat with as many widths as codes have; two may be equal."""
    if model.widths == 1:
        return coat._replace(alpha=checks.one_width(coat.alpha, "the coat's"))
    if isinstance(coat.alpha, Widths):
        return coat
    return coat._replace(alpha=Widths(coat.alpha, coat.alpha))


def predicted(model: Model, z: np.ndarray, coat: CoatParameters) -> np.ndarray:
    """Codes (N, L) by the layering network of bottoms z (N, L) under checked coats, arrays (N,).

    Either may have N = 1, and parameters may be (). The albedo is not limited.
    """
    check_ratios(model, z, coat)
    columns = [np.atleast_1d(p).astype(np.float32) for p in within_training(coat).columns()]
    count = np.broadcast_shapes(z.shape[:1], *(p.shape for p in columns))

    def layered(z: np.ndarray, *columns: np.ndarray) -> np.ndarray:
        return model.networks.layer(z, CoatParameters.of_columns(columns))

    return fill_blocks(np.empty((*count, z.shape[1]), np.float32), layered, z, *columns)


def within_training(coat: CoatParameters) -> CoatParameters:
    """Coats with similar media, in or near the range of the network's training data.

    Media of equal absorption and equal scattering times 1 - g transport light alike (van de Hulst
    1980). So g is moved into its range, and in media that are too deep further towards 0. Depths
    that remain above `DEEPEST` are cut. Coats of index 1, which have no interface, get the least
    width.
    """
    if (coat.eta == 1).any():
        smooth = functools.partial(np.where, coat.eta == 1, checks.MIN_ALPHA)
        coat = coat._replace(alpha=of_widths(smooth, coat.alpha))
    g = np.clip(coat.g, *checks.TRAINED_G)
    if np.array_equal(g, coat.g) and np.max(coat.sigma_t) <= DEEPEST:
        return coat
    scattering = coat.albedo * coat.sigma_t
    absorption = coat.sigma_t - scattering
    reduced = scattering * (1 - coat.g)
    least = 1 - reduced / np.maximum(DEEPEST - absorption, 1e-6)
    g = np.where(absorption + reduced / (1 - g) > DEEPEST, np.clip(least, np.minimum(g, 0), g), g)
    scattering = reduced / (1 - g)
    depth = absorption + scattering
    albedo = np.where(depth > 0, scattering / np.where(depth > 0, depth, 1), coat.albedo)
    return coat._replace(albedo=albedo, sigma_t=np.minimum(depth, DEEPEST), g=g)


def check_ratios(model: Model, z: np.ndarray, coat: CoatParameters) -> None:
    """Refuse two widths of coats, or of the lobes of bottoms z (..., L), that differ too much."""
    if model.widths == 1:
        return
    for owner, widths in (("bottom", lobes.width(z[..., : model.arch.lobe])), ("coat", coat.alpha)):
        larger, smaller = np.maximum(widths.u, widths.v), np.minimum(widths.u, widths.v)
        ratio = float(np.max(larger / np.maximum(smaller, checks.MIN_ALPHA)))
        if ratio > WIDEST * (1 + 1e-4):  # widths may be of single precision
            raise ParameterError(
                f"the {owner}'s alpha_u and alpha_v have a ratio of {ratio:.3g}, but codes "
                f"have ratios up to {WIDEST:g}; give closer widths, or use the random walk "
                "('layered', urushi.simulate)"
            )


def absent(coat: CoatParameters) -> np.ndarray:
    """Whether coats have neither an interface nor a medium; bool (...)."""
    return (np.asarray(coat.eta) == 1) & (np.asarray(coat.sigma_t) == 0)
