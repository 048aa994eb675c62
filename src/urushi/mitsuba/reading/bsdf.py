"""Mitsuba BSDFs as sources of `urushi.encode`: the rough reflection, and the shares it excludes."""

import mitsuba as mi
import numpy as np

from urushi.errors import ParameterError, PlatformError
from urushi.material.source import Source, as_source
from urushi.material.symmetry import ASYMMETRY_PAIRS, asymmetry_pairs, is_anisotropic
from urushi.mitsuba import spectrum
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.grid import not_over_uv, varying_textures
from urushi.mitsuba.reading.known import known_surface
from urushi.nets.lobe import LOBE_NUMBERS

#: Samples by which the excluded shares of the light are measured, to about 0.2 %.
SAMPLES = 1 << 16


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
    if known_surface(
        bsdf
    ).table_source():  # its lobe is for coats; without them, its values say more
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
                lambda wi, wo: _mean_values(bsdf, wi, wo, 1),
                symmetric=True,
                tabulated=False,  # a lobe alone, a Lambertian, or `bsdf_source` knows more
                lobe=lobes[0],
                bare=known.lobe_only,
                widths=1 if lobes.shape[-1] == len(LOBE_NUMBERS) else 2,
            )

    def f(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return _mean_values(bsdf, wi, wo, probing.needed_repeats(bsdf, wi, wo, 1))

    wi, wo = (w[:64] for w in asymmetry_pairs())
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
        uv = np.random.default_rng(0).random((ASYMMETRY_PAIRS, 2))
        source = source._replace(f=lambda wi, wo: probing.bsdf_values(bsdf, wi, wo, uv))
    return is_anisotropic(source)


def _mean_values(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, repeats: int) -> np.ndarray:
    """f (M, C) [1/sr] as the mean of `repeats` evaluations, many in one launch."""
    total, most = np.zeros((len(wi), 1)), max(probing.CHUNK // len(wi), 1)
    for start in range(0, repeats, most):
        times = np.arange(start, min(start + most, repeats), dtype=np.float32)
        a, b = (np.tile(w, (len(times), 1)) for w in (wi, wo))
        uv, time = np.full((len(a), 2), 0.5), np.repeat(times, len(wi))
        f = probing.bsdf_values(bsdf, a, b, uv, time)
        total = total + f.reshape(len(times), len(wi), -1).sum(axis=0)
    return total / repeats


def excluded_shares(bsdf: "mi.BSDF") -> tuple[float, float]:
    """Shares of diffuse light from above that are transmitted, and reflected by a smooth surface.

    Means over the channels, by the BSDF's own `sample`, whose weights are trusted.
    """
    excluded = mi.BSDFFlags.Transmission, mi.BSDFFlags.Null, mi.BSDFFlags.DeltaReflection
    if not any(mi.has_flag(bsdf.flags(), kind) for kind in excluded):
        return 0.0, 0.0
    rng = np.random.default_rng(0)
    u = rng.random((5, SAMPLES))
    cosine, sine = np.sqrt(u[0]), np.sqrt(1 - u[0])
    azimuth = 2 * np.pi * u[1]
    wi = np.stack([sine * np.cos(azimuth), sine * np.sin(azimuth), cosine], axis=-1)
    si = probing.interaction(wi.astype(np.float32), np.full((SAMPLES, 2), 0.5))
    context = mi.BSDFContext(mi.TransportMode.Importance)  # light, not radiance, which eta changes
    sample, weight = bsdf.sample(
        context, si, mi.Float(u[2]), mi.Point2f(np.ascontiguousarray(u[3:], np.float32))
    )
    kind = mi.UInt32(sample.sampled_type)
    through = mi.has_flag(kind, mi.BSDFFlags.Transmission) | mi.has_flag(kind, mi.BSDFFlags.Null)
    mirrored = mi.has_flag(kind, mi.BSDFFlags.DeltaReflection)
    energy = np.mean(
        [np.broadcast_to(x.numpy(), SAMPLES) for x in spectrum.to_channels(weight)], axis=0
    )
    energy = np.where(np.isfinite(energy), energy, 0.0)

    def share(which: "mi.Bool") -> float:
        return float((energy * np.broadcast_to(which.numpy(), SAMPLES)).mean())

    return share(through), share(mirrored)


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
