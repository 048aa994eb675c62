"""The Mitsuba plugins of the extension: `openpbr`, `openpbr_emission` and `materialx`."""

from urushi.mitsuba.register import Room


def _define(proposal_bsdf: type) -> dict:
    from urushi.openpbr_surface.plugins import emission, materialx, openpbr

    return {
        "openpbr": openpbr.define(proposal_bsdf),
        "materialx": materialx.define(),
        "openpbr_emission": emission.define(),
    }


ROOM = Room(_define, bsdfs=("openpbr", "materialx"), emitters=("openpbr_emission",))
