"""The whole system of Neural Layered BRDFs (Fan, Wang, Hašan, Yang and Yan, SIGGRAPH 2022).

Networks, data and training are as published. This is an extension: it has its own functions, of the
names of Urushi's, and the rest of Urushi does not import it. Importing it registers the Mitsuba
plugins `fan2022_brdf` and `fan2022_layered`.
"""

from urushi.fan2022 import plugins
from urushi.fan2022.kernels import separate_kernels
from urushi.fan2022.material import Material, encode, layer, load
from urushi.fan2022.networks import PaperNetworks
from urushi.mitsuba import register

__all__ = ["Material", "PaperNetworks", "encode", "layer", "load", "separate_kernels"]

register.register(plugins.ROOM)
