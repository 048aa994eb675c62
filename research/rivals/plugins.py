"""The plugins `layered_belcour` and `layered_weidlich`, in every variant that is set."""

import mitsuba as mi

from research.rivals import layered_belcour, layered_weidlich
from urushi.mitsuba.plugins.base import define_proposal_bsdf
from urushi.mitsuba.register import supported


def register() -> None:
    """Register both plugins in the current variant, if any, and in all that are set later."""
    mi.detail.add_variant_callback(_on_variant)
    if mi.variant() is not None:
        _on_variant(None, mi.variant())


def _on_variant(old: str | None, new: str) -> None:
    if not supported(new):
        return
    base = define_proposal_bsdf()
    mi.register_bsdf("layered_belcour", layered_belcour.define(base))
    mi.register_bsdf("layered_weidlich", layered_weidlich.define(base))
