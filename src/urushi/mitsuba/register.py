"""Registration of the plugins with Mitsuba, in every variant that is set."""

from collections.abc import Callable

import mitsuba as mi

from urushi import platform
from urushi.errors import PlatformError

PLUGINS = (
    "layered",
    "neural_layered",
    "neural_brdf",
    "measured_brdf",
    "openpbr",
    "materialx",
)

_registered = False


def register(prepare: Callable[[], None] = lambda: None) -> None:
    """Register the plugins in the current variant, if any, and in all that are set later.

    prepare: called before the plugins of a variant are defined.
    """
    global _registered
    if _registered:
        return
    _registered = True

    def on_variant(old: str | None, new: str) -> None:
        prepare()
        _on_variant(old, new)

    mi.detail.add_variant_callback(on_variant)
    if mi.variant() is not None:
        on_variant(None, mi.variant())


def supported(variant: str) -> bool:
    """Whether plugins work in this variant, which is the current one."""
    return not (variant.startswith("scalar") or mi.is_polarized)


def _on_variant(old: str | None, new: str) -> None:
    """Define the plugins' classes: a class belongs to the variant in which it was defined."""
    if new.startswith("llvm"):
        platform.require_llvm()  # an old LLVM would crash when the first kernel is compiled
    from urushi.material.source import as_source
    from urushi.mitsuba.reading.bsdf import bsdf_source

    as_source.register(mi.BSDF, bsdf_source)  # for `urushi.encode`
    if not supported(new):
        for name in PLUGINS:
            mi.register_bsdf(name, _refusal(name, new))
        mi.register_emitter("openpbr_emission", _refusal("openpbr_emission", new))
        return
    from urushi.mitsuba.plugins import (
        base,
        layered,
        materialx,
        measured_brdf,
        neural_brdf,
        neural_layered,
        openpbr,
        openpbr_emission,
    )

    proposal_bsdf = base.define_proposal_bsdf()
    neural_bsdf = base.define_neural_bsdf(proposal_bsdf)
    mi.register_bsdf("layered", layered.define(proposal_bsdf))
    mi.register_bsdf("neural_layered", neural_layered.define(neural_bsdf))
    mi.register_bsdf("neural_brdf", neural_brdf.define(neural_bsdf))
    mi.register_bsdf("measured_brdf", measured_brdf.define(proposal_bsdf))
    mi.register_bsdf("openpbr", openpbr.define(proposal_bsdf))
    mi.register_bsdf("materialx", materialx.define())
    emission = openpbr_emission.define()
    mi.register_emitter("openpbr_emission", lambda props: emission(props))


def _refusal(name: str, variant: str):
    """A constructor that says which variants work."""

    def refuse(props):
        raise PlatformError(
            f"'{name}' does not work in the variant {variant}; choose llvm_ad_rgb, llvm_ad_mono, "
            "llvm_ad_spectral or their cuda_ad_* counterparts, for instance by "
            "mi.set_variant('cuda_ad_rgb', 'llvm_ad_rgb')"
        )

    return refuse
