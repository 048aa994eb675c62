"""The plugins `layered_belcour` and `layered_weidlich`, in every variant that is set."""

from research.rivals import layered_belcour, layered_weidlich
from urushi.mitsuba import register as plugins


def register() -> None:
    """Register both plugins in the current variant, if any, and in all that are set later."""
    plugins.register(plugins.Room(_define, ("layered_belcour", "layered_weidlich")))


def _define(proposal_bsdf: type) -> dict[str, type]:
    return {
        "layered_belcour": layered_belcour.define(proposal_bsdf),
        "layered_weidlich": layered_weidlich.define(proposal_bsdf),
    }
