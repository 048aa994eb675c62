"""Registration of the plugins with Mitsuba, in every variant that is set."""

from collections.abc import Callable, Mapping
from functools import partial
from typing import Any, NamedTuple, NoReturn

import mitsuba as mi

from urushi import platform
from urushi.errors import PlatformError


class PluginSet(NamedTuple):
    """The plugins of one part of the package."""

    # Imports them, in a variant that is set: by name, what makes a `Surface`, a BSDF or an emitter
    # from properties.
    load: Callable[[], Mapping[str, Callable[[Any], Any]]]
    bsdfs: tuple[str, ...]  # their names
    emitters: tuple[str, ...] = ()


def register(*sets: PluginSet) -> None:
    """Register plugins in the current variant, if any, and in all that are set later.

    The package registers its own when it is imported. An extension calls this once, for its own.
    """

    def on_variant(old: str | None, new: str) -> None:
        if new.startswith("llvm"):
            platform.require_llvm()  # an old LLVM would crash when the first kernel is compiled
        from urushi.material.source import as_source
        from urushi.mitsuba.reading.bottoms import bsdf_source
        from urushi.mitsuba.reading.changed import relative_to_index
        from urushi.walk.stack import under

        as_source.register(mi.BSDF, bsdf_source)  # for `urushi.encode`
        under.register(mi.BSDF, relative_to_index)  # for `urushi.layer`
        supported = not (new.startswith("scalar") or mi.is_polarized)
        for each in sets:
            made = each.load() if supported else {}
            for name in each.bsdfs:
                refuse = partial(_refuse, name, new)
                mi.register_bsdf(name, partial(_bsdf, made[name]) if made else refuse)
            for name in each.emitters:
                mi.register_emitter(name, made[name] if made else partial(_refuse, name, new))

    mi.detail.add_variant_callback(on_variant)
    if mi.variant() is not None:
        on_variant(None, mi.variant())


def _bsdf(make: Callable, props: "mi.Properties") -> "mi.BSDF":
    """The BSDF of a maker of surfaces or of BSDFs."""
    from urushi.mitsuba.surface import Surface, bsdf_of

    made = make(props)
    return bsdf_of(made, props) if isinstance(made, Surface) else made


def _refuse(name: str, variant: str, props: "mi.Properties") -> NoReturn:
    """Say which variants work."""
    raise PlatformError(
        f"'{name}' does not work in the variant {variant}; choose llvm_ad_rgb, llvm_ad_mono, "
        "llvm_ad_spectral or their cuda_ad_* counterparts, for instance by "
        "mi.set_variant('cuda_ad_rgb', 'llvm_ad_rgb')"
    )


def _load() -> dict[str, Any]:
    from urushi.mitsuba.plugins.coated import is_slab
    from urushi.mitsuba.plugins.layered import Layered
    from urushi.mitsuba.plugins.measured_brdf import MeasuredBRDF
    from urushi.mitsuba.plugins.neural_brdf import NeuralBRDF
    from urushi.mitsuba.plugins.neural_layered import NeuralLayered
    from urushi.mitsuba.plugins.neural_slab import NeuralSlab
    from urushi.mitsuba.reading.nested import is_dielectric, nested_bsdf

    def coat_or_slab(props):
        nested = nested_bsdf(props, optional=True)
        transmits = nested is None or is_dielectric(nested) or is_slab(nested)
        return (NeuralSlab if transmits else NeuralLayered)(props)

    return {
        "layered": Layered,
        "neural_layered": coat_or_slab,
        "neural_brdf": NeuralBRDF,
        "measured_brdf": MeasuredBRDF,
    }


#: The plugins of the core.
PLUGINS = PluginSet(_load, ("layered", "neural_layered", "neural_brdf", "measured_brdf"))
