"""The stages of a training, one file each, and their interface, `Stage` and `Task`."""

from abc import ABC, abstractmethod
from collections.abc import Callable, Collection
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from urushi.nets.architecture import FIXED, Architecture
from urushi.nets.mlp import Params
from urushi.train.examples import Depth
from urushi.train.optimiser import Loss, Schedule


class Task(NamedTuple):
    """The loss of a stage, and its batches."""

    loss: Loss  # from the parameters that learn and a batch to the loss and the terms to log
    # From the first step and the number of steps to their batches, stacked along a first axis. It
    # depends on its arguments alone, so that a training can be resumed.
    batches: Callable[[int, int], Any]


@dataclass(frozen=True)
class Stage(ABC):
    """One stage of a training. Every subclass is a frozen dataclass with its own options."""

    schedule: Schedule
    name: str = field(kw_only=True)  # in checkpoints and logs, unique in a preset
    trains: ClassVar[tuple[str, ...]]  # the networks that learn, some of `architecture.PARTS`

    def arch_before(self, arch: Architecture) -> Architecture:
        """Sizes of the networks before this stage, where they are `arch` during and after it."""
        return arch

    def begin(self, params: Params, arch: Architecture, seed: int) -> dict[str, Any]:
        """The parameters that learn, before the first step.

        Args:
            params: all parameters, of the sizes `arch_before`.
            arch: sizes of the networks during the stage.
            seed: the preset's.
        """
        return parameters_of(params, self.trains)

    @abstractmethod
    def task(self, params: Params, arch: Architecture, depths: list[Depth], seed: int) -> Task:
        """Prepare loss and batches; arguments as of `begin`.

        depths: the training examples by number of coats, from none up.
        """


def parameters_of(params: Params, networks: Collection[str]) -> dict[str, Any]:
    """The parameters of some networks that are trained at all."""
    return {
        name: value
        for name, value in params.items()
        if name.split(".")[0] in networks and name not in FIXED
    }
