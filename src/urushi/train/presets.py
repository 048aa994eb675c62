"""The presets of `urushi train --preset NAME`: data, sizes and schedule, each a frozen value."""

import json
from dataclasses import asdict, dataclass, field
from typing import Any

from urushi.errors import ParameterError, choice
from urushi.nets import weights
from urushi.nets.networks import Architecture
from urushi.train.optimiser import Schedule
from urushi.train.tables import TableSpec


@dataclass(frozen=True)
class Preset:
    """A whole training: tables, basis and layering network."""

    name: str  # on the command line
    data: TableSpec
    schedule: Schedule  # of the layering network
    batch: int = 512  # examples in a step of the layering network
    seed: int = 0  # of the initial weights and of the order of the examples
    arch: Architecture = field(default_factory=Architecture)
    beginning: str = ""  # shipped weights of one width with which those of two widths begin

    def __post_init__(self) -> None:
        if self.data.probes != self.arch.probes:
            raise ParameterError(
                f"the data hold {self.data.probes} probes, but the architecture needs "
                f"{self.arch.probes}"
            )

    def to_dict(self) -> dict[str, Any]:
        """Describe the preset for JSON, in checkpoints and in the weights' header."""
        return {**asdict(self), "arch": json.loads(self.arch.to_json())}


def default() -> Preset:
    """The basis of one GGX width, and its layering network.

    Command: `urushi train --preset default`
    Time: an hour on two cores.
    Expected: E of hidden coated materials, code against transport, 0.5 % on average.
    """
    schedule = Schedule(steps=65_536, warmup=128, learning_rate=0.002, clip=0.05, average=0.9995)
    return Preset("default", TableSpec(stacks=3000, coats=32, probes=256), schedule)


def anisotropic() -> Preset:
    """The basis of two GGX widths, and its layering network.

    Command: `urushi train --preset anisotropic`
    Time: an hour on two cores.
    Expected: E of hidden coated materials, code against transport, 0.6 % on average.
    """
    schedule = Schedule(steps=12_288, warmup=128, learning_rate=0.002, clip=0.05, average=0.9995)
    return Preset(
        "anisotropic",
        TableSpec(stacks=1000, coats=8, probes=384, shard=5, widths=2),
        schedule,
        batch=256,
        arch=Architecture(60, 384, widths=2, azimuthal=(8, 8, 4, 4, 4)),
        beginning=weights.DEFAULT,
    )


def smoke() -> Preset:
    """A few stacks, to check that everything runs.

    Command: `urushi train --preset smoke`
    Time: half a minute on two cores.
    Expected: no useful weights.
    """
    schedule = Schedule(steps=128, warmup=16, learning_rate=0.002, average=0.95)
    return Preset(
        "smoke",
        TableSpec(stacks=40, coats=2, probes=256, shard=10),
        schedule,
        batch=32,
        arch=Architecture(functions=8, layerer=(32, 32)),
    )


_PRESETS = {preset.__name__: preset for preset in (default, anisotropic, smoke)}

#: The names that `--preset` takes.
NAMES = tuple(_PRESETS)


def get(name: str) -> Preset:
    """Find a preset by name."""
    if name not in _PRESETS:
        raise ParameterError(f"there is no preset '{name}'; {choice(name, NAMES)}")
    return _PRESETS[name]()
