"""The whole system of Neural Layered BRDFs (Fan, Wang, Hašan, Yang and Yan, SIGGRAPH 2022).

Networks, data and training are as published. The package is a part of the repository, beside
Urushi, which does not know it: it has its own command (`python -m fan2022`) and functions of the
names of Urushi's. Importing it registers the Mitsuba plugins `fan2022_brdf` and `fan2022_layered`.
"""

from fan2022 import plugins
from fan2022.kernels import separate_kernels
from fan2022.material import Material, encode, layer, load
from fan2022.networks import PaperNetworks
from urushi.mitsuba import register

__all__ = ["Material", "PaperNetworks", "encode", "layer", "load", "separate_kernels"]

register.register(plugins.PLUGINS)
