"""OpenPBR's bases that transmit light: bodies of glass, and thin walls.

A `body` mixes two-sided BSDFs by the shares of the base: opaque, an interface with a
medium below it (`glass`), a thin wall that scatters light (`sheet`), and slabs of the plugins
`layered` and `neural_layered` (`slab`): coats on glass, panes, and panes with coats on both sides.
Departures from the specification: a share that is opaque looks the same from inside; both sides of
a thin wall have the coat; specular_weight changes the index of the body, whatever lies above it.
"""

from urushi.openpbr_surface.transmission.body import define
from urushi.openpbr_surface.transmission.shares import transmits

__all__ = ["define", "transmits"]
