"""Registration of the plugins with Mitsuba, in every variant that is set."""

from collections.abc import Callable
from typing import Any, NamedTuple

import mitsuba as mi

from urushi import platform
from urushi.errors import PlatformError


class Room(NamedTuple):
    """The plugins of one part of the package."""

    # Makes their constructors by name in the current variant, from the class of
    # `plugins.base.define_proposal_bsdf`.
    define: Callable[[type], dict[str, Any]]
    bsdfs: tuple[str, ...]  # their names
    emitters: tuple[str, ...] = ()


def register(*rooms: Room) -> None:
    """Register plugins in the current variant, if any, and in all that are set later.

    The package registers its own when it is imported. An extension calls this once, for its own.
    """

    def on_variant(old: str | None, new: str) -> None:
        _on_variant(new, rooms)

    mi.detail.add_variant_callback(on_variant)
    if mi.variant() is not None:
        on_variant(None, mi.variant())


def supported(variant: str) -> bool:
    """Whether plugins work in this variant, which is the current one."""
    return not (variant.startswith("scalar") or mi.is_polarized)


def _on_variant(new: str, rooms: tuple[Room, ...]) -> None:
    """Define the plugins' classes: a class belongs to the variant in which it was defined."""
    if new.startswith("llvm"):
        platform.require_llvm()  # an old LLVM would crash when the first kernel is compiled
    from urushi.material.source import as_source
    from urushi.mitsuba.reading.below import bsdf_under
    from urushi.mitsuba.reading.bsdf import bsdf_source
    from urushi.walk.stack import under

    as_source.register(mi.BSDF, bsdf_source)  # for `urushi.encode`
    under.register(mi.BSDF, bsdf_under)  # for `urushi.layer`
    made: dict[str, Any] = {}
    if supported(new):
        from urushi.mitsuba.plugins.base import define_proposal_bsdf

        proposal_bsdf = define_proposal_bsdf()
        for room in rooms:
            made |= room.define(proposal_bsdf)
    for room in rooms:
        for name in room.bsdfs:
            mi.register_bsdf(name, made.get(name) or _refusal(name, new))
        for name in room.emitters:
            mi.register_emitter(name, made.get(name) or _refusal(name, new))


def _define(proposal_bsdf: type) -> dict[str, Any]:
    from urushi.mitsuba.plugins import (
        base,
        layered,
        measured_brdf,
        neural_brdf,
        neural_layered,
        neural_slab,
    )
    from urushi.mitsuba.plugins.coated import is_dielectric, is_slab
    from urushi.mitsuba.reading.parameters import nested_bsdf

    neural_bsdf = base.define_neural_bsdf(proposal_bsdf)
    coat, slab = neural_layered.define(neural_bsdf), neural_slab.define(proposal_bsdf)

    def coat_or_slab(props):
        nested = nested_bsdf(props, optional=True)
        transmits = nested is None or is_dielectric(nested) or is_slab(nested)
        return (slab if transmits else coat)(props)

    return {
        "layered": layered.define(proposal_bsdf),
        "neural_layered": coat_or_slab,
        "neural_brdf": neural_brdf.define(neural_bsdf),
        "measured_brdf": measured_brdf.define(proposal_bsdf),
    }


#: The plugins of the core.
ROOM = Room(_define, ("layered", "neural_layered", "neural_brdf", "measured_brdf"))


def _refusal(name: str, variant: str):
    """A constructor that says which variants work."""

    def refuse(props):
        raise PlatformError(
            f"'{name}' does not work in the variant {variant}; choose llvm_ad_rgb, llvm_ad_mono, "
            "llvm_ad_spectral or their cuda_ad_* counterparts, for instance by "
            "mi.set_variant('cuda_ad_rgb', 'llvm_ad_rgb')"
        )

    return refuse
