"""BSDFs of Mitsuba's as sources of `urushi.encode`, as materials, and at points of uv.

A source has the rough reflection alone, and the shares of the light that this excludes.
"""

from dataclasses import dataclass, replace
from functools import cached_property, partial
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

from urushi.core.direction_sets import direction
from urushi.core.table import node_pairs, table_of_values
from urushi.errors import ParameterError, PlatformError
from urushi.material import symmetry
from urushi.material.material import Material
from urushi.material.source import Source, as_source
from urushi.material.values import codes_of_values, encode_source, required_pairs
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import not_over_uv, varying_textures
from urushi.mitsuba.reading.nested import check_bottom
from urushi.mitsuba.reading.parameters import CoatTextures
from urushi.mitsuba.reading.probing import known_surface
from urushi.nets.lobe import LOBE_NUMBERS, with_two_widths
from urushi.nets.transmittance import remainder, table_beside
from urushi.nets.weights import Model

#: Samples by which the excluded shares of the light are measured, to about 0.2 %.
SAMPLES = 1 << 16


@dataclass(frozen=True)
class Layer:
    """A coat over a bottom, as a scene describes them."""

    coat: CoatTextures
    nested: Any  # the bottom, a BSDF of Mitsuba's, as the coat has it nested
    below: Any  # the same as it reflects below the coat, see `reading.changed`

    @property
    def relative(self) -> bool:
        """Whether the bottom reflects otherwise below the coat than in air."""
        return self.below is not self.nested

    @cached_property
    def numbers(self) -> dict[str, np.ndarray]:
        """The coat in the middle of uv, see `CoatTextures.numbers`; in all bands of constants."""
        with spectrum.reading_at(spectrum.FINE):
            return self.coat.numbers(spectrum.MIDDLE)


def bsdf_source(bsdf: "mi.BSDF") -> Source:
    """A BSDF at the middle of uv, seen from the side of its normal, as a source of `encode`.

    Raises:
        ParameterError: it has no rough reflection, because it is a mirror or only transmits; or it
            depends on a position that is not over uv.
        PlatformError: the variant is a scalar or polarized one.
    """
    name = bsdf.class_name()
    if mi.variant() is None or mi.variant().startswith("scalar") or mi.is_polarized:
        raise PlatformError(
            f"encode {name}: BSDFs cannot be read in the variant {mi.variant()}; choose "
            "llvm_ad_rgb or another vectorised one without polarization before loading the scene"
        )
    _check_encodable(bsdf, name)
    transmitted, mirrored = excluded_shares(bsdf)
    source = reflection_source(bsdf)
    if known_surface(bsdf).table_source():  # a lobe is for coats; without one, values say more
        source = source._replace(lobe=None, bare=False, tabulated=True, widths=1)
    return source._replace(
        transmitted=transmitted, mirrored=mirrored, textured=bool(varying_textures(bsdf))
    )


def reflection_source(bsdf: "mi.BSDF") -> Source:
    """`bsdf_source` of a BSDF that is known to be opaque and rough, and not to be textured."""
    known = known_surface(bsdf)
    if known.measured is not None and mi.is_rgb:
        return as_source(known.measured)  # what `urushi.load_measured` gives, to the bit

    lobes = probing.known_lobes(bsdf, spectrum.MIDDLE)
    if lobes is not None:
        bounded = np.delete(lobes, [4, 5], axis=-1)
        # Numbers of textures may leave the ranges of lobes that conserve energy.
        if ((bounded >= 0) & (bounded <= 1)).all() and (lobes[..., 4:6] >= 0).all():
            return Source(
                partial(probing.mean_values, bsdf),
                symmetric=True,
                tabulated=False,  # a lobe alone, a Lambertian, or `bsdf_source` knows more
                lobe=lobes[0],
                bare=known.lobe_only,
                widths=1 if lobes.shape[-1] == len(LOBE_NUMBERS) else 2,
            )

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return probing.mean_values(bsdf, wi, wo, probing.needed_repeats(bsdf, wi, wo, 1))

    wi, wo = (w[:64] for w in symmetry.asymmetry_pairs())
    noisy = probing.needed_repeats(bsdf, wi, wo, 1) > 1
    return Source(f, noisy=noisy, tabulated=not noisy)


def has_two_widths(bsdf: "mi.BSDF") -> bool:
    """Whether a BSDF is anisotropic, so that its codes need two widths.

    Textures count by their values at random points of uv; a random BSDF counts as isotropic.
    """
    latents = known_surface(bsdf).latents
    if latents is not None:
        return latents.model.widths == 2
    lobes = probing.known_lobes(bsdf, spectrum.MIDDLE)
    if lobes is not None and lobes.shape[-1] > len(LOBE_NUMBERS) and not varying_textures(bsdf):
        return not np.array_equal(lobes[..., 0], lobes[..., 6])
    source = reflection_source(bsdf)
    if varying_textures(bsdf) and not (source.noisy or not_over_uv(bsdf)):
        uv = np.random.default_rng(0).random((symmetry.ASYMMETRY_PAIRS, 2))
        source = source._replace(f=lambda wi, wo: probing.bsdf_values(bsdf, wi, wo, uv))
    return symmetry.is_anisotropic(source)


def excluded_shares(bsdf: "mi.BSDF") -> tuple[float, float]:
    """Shares of diffuse light from above that are transmitted, and reflected by a smooth surface.

    Means over the channels, by the BSDF's own `sample`, whose weights are trusted.
    """
    excluded = mi.BSDFFlags.Transmission, mi.BSDFFlags.Null, mi.BSDFFlags.DeltaReflection
    if not any(mi.has_flag(bsdf.flags(), kind) for kind in excluded):
        return 0.0, 0.0
    u = np.random.default_rng(0).random((5, SAMPLES))
    si = probing.interaction(direction(np.sqrt(u[0]), u[1]), np.full((SAMPLES, 2), 0.5))
    context = mi.BSDFContext(mi.TransportMode.Importance)  # light, not radiance, which eta changes
    sample, weight = bsdf.sample(
        context, si, mi.Float(u[2]), mi.Point2f(np.ascontiguousarray(u[3:], np.float32))
    )
    kind = mi.UInt32(sample.sampled_type)
    through = mi.has_flag(kind, mi.BSDFFlags.Transmission) | mi.has_flag(kind, mi.BSDFFlags.Null)
    mirrored = mi.has_flag(kind, mi.BSDFFlags.DeltaReflection)
    energy = dr.mean(weight)
    energy = dr.select(dr.isfinite(energy), energy, 0)
    shares = [dr.mean(dr.select(which, energy, 0)).numpy() for which in (through, mirrored)]
    return float(shares[0][0]), float(shares[1][0])


def _check_encodable(bsdf: "mi.BSDF", name: str) -> None:
    """Refuse a BSDF that has no value in the middle of uv, or no rough reflection."""
    if stranger := not_over_uv(bsdf):
        raise ParameterError(
            f"encode {name}: the BSDF depends on {stranger} and not on uv; "
            "give a texture over uv, or a constant"
        )
    flags, has = bsdf.flags(), mi.has_flag
    if has(flags, mi.BSDFFlags.DiffuseReflection) or has(flags, mi.BSDFFlags.GlossyReflection):
        return
    if has(flags, mi.BSDFFlags.DeltaReflection):
        raise ParameterError(
            f"encode {name}: the BSDF is perfectly smooth, but a material must be rough; "
            "give its rough variant, such as 'roughconductor' of alpha 0.01"
        )
    raise ParameterError(
        f"encode {name}: the BSDF reflects nothing but only transmits; a material must be opaque"
    )


def nested_latents(bottom: "mi.BSDF", model: Model) -> Any:
    """The codes of a bottom that has codes of the same weights, or None."""
    nested = known_surface(bottom).latents
    same = nested is not None and nested.model.fingerprint == model.fingerprint
    return nested if same else None


def bottom_material(model: Model, bottom: "mi.BSDF", where: str) -> Material:
    """The material of a bottom that is the same everywhere, at the bands that are read."""
    nested = nested_latents(bottom, model)
    if nested is not None and nested.material is not None:
        own, count = nested.material, spectrum.channel_count()
        if own.channels != count and own.channels == spectrum.COUNT:
            bands = list(spectrum.FINE_AT_RGB)
            table = None if own.table is None else own.table[..., bands]
            own = replace(own, latents=own.latents[bands], table=table)
        return own
    check_bottom(bottom, where)
    source = reflection_source(bottom)
    name = f"{where}: the nested BSDF"
    material, deviations = encode_source(source, model, name=name)
    for sentence in deviations.warnings():
        mi.Log(mi.LogLevel.Warn, f"{where}: {sentence}")
    if model.widths == 1 and source.lobe is not None and not source.bare:
        opened = reflection_source(known_surface(bottom).table_source() or bottom)
        checked = opened._replace(f=lambda wi, wo: probing.check_values(opened.f(wi, wo), where))
        lobe = material.latents[:, : model.arch.lobe]
        table = table_beside(symmetry.symmetrise(checked, *node_pairs())[0], lobe)
        material = replace(material, table=table, beside_lobe=True)
    return material


def probed_codes(
    model: Model,
    bottom: "mi.BSDF",
    uv: np.ndarray,
    where: str,
    kept: slice = probing.ALL,
    *,
    bounded: bool = False,
) -> np.ndarray:
    """Codes (M, C, L) of a bottom at points uv (M, 2).

    kept: of the channels, which C are.
    bounded: whether they have the bottom's albedo, which takes several times as many evaluations.
    """
    nested = nested_latents(bottom, model)
    if nested is not None:
        return nested.at(uv)[:, kept]
    lobe = known_lobes(model, bottom, uv, where, kept)
    if lobe is not None and known_surface(bottom).lobe_only:
        for reach in (lobe[..., :4], lobe[..., 6:]):  # all but the index
            np.minimum(reach, 1, out=reach)
        rest = np.broadcast_to(model.networks.empty_rest(), (*lobe.shape[:2], model.arch.rest))
        return np.concatenate([lobe, rest], axis=-1)
    probes = model.networks.pairs()
    average = probing.needed_averaging(bottom, *probes, uv, where, model.widths, kept)
    pairs = required_pairs(None, model, table=False) if bounded else probes
    f = probing.texel_values(bottom, *pairs, uv, average, kept)
    f = probing.check_values(f, where)[:, :, None]
    lobe = None if lobe is None else lobe[:, :, None]  # each row is a material of its own
    codes = codes_of_values(f, model, lobe) if bounded else model.networks.encode(f, lobe)
    return codes[:, :, 0]


def probed_tables(
    model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str, kept: slice
) -> list[np.ndarray]:
    """ln g (C, M, U, V, W) at points uv (M, 2), and known lobes (C, M, N), if any."""
    exact = known_surface(bottom).table_source() or bottom
    known = known_lobes(model, bottom, uv, where, kept)
    wi, wo = (w.reshape(-1, 3) for w in node_pairs())
    average = probing.needed_averaging(exact, *model.networks.pairs(), uv, where, kept=kept)
    f = probing.texel_values(exact, wi, wo, uv, average, kept)
    f = np.moveaxis(probing.check_values(f, where), 1, 0)
    if known is not None:
        known = np.moveaxis(known, 1, 0)
        f = remainder(f, known[..., None, :], wi, wo)
    logs = np.moveaxis(table_of_values(f.reshape(-1, len(wi)).T), -1, 0)
    tables = logs.reshape(*f.shape[:2], *logs.shape[1:])
    return [tables] if known is None else [tables, known]


def known_lobes(
    model: Model, bottom: "mi.BSDF", uv: np.ndarray, where: str, kept: slice
) -> np.ndarray | None:
    """Lobes (M, C, N) at points uv (M, 2) as codes have them; None: they are fitted."""
    found = probing.known_lobes(bottom, uv)
    if found is None:
        return None
    found = probing.check_values(found[:, kept], where)
    if found.shape[-1] < model.arch.lobe:
        found = with_two_widths(found)
    # Codes of one width fit a lobe of two.
    return found if found.shape[-1] == model.arch.lobe else None
