"""The whole system of Neural Layered BRDFs (Fan, Wang, Hašan, Yang and Yan, SIGGRAPH 2022).

Networks, data and training are as published. The rest of Urushi does not import this package;
after `register`, weights files, materials and plugins can hold its networks.
"""


def register() -> None:
    """Let Urushi read the paper's weights and data."""
    from urushi.fan2022.architecture import PaperArchitecture, parameter_shapes
    from urushi.fan2022.networks import PaperNetworks
    from urushi.fan2022.palette import Palette
    from urushi.nets import weights
    from urushi.train.data import distribution

    weights.register_kind(
        "paper", weights.ArchitectureKind(PaperArchitecture, parameter_shapes, PaperNetworks)
    )
    distribution.register_source("palette", Palette)
