"""`urushi eval`: errors of trained networks on held-out stacks."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Literal

import tyro

from urushi.app import extras
from urushi.errors import ParameterError


@dataclass(frozen=True)
class Evaluate:
    """Measure networks on layered materials that they were not trained on.

    Prints the errors E (of energy) and P (of pairs) of every kind of stack, in percent, beside the
    reference's own; how well laws of physics are kept; sizes and times. docs/conventions.md says
    what E and P are. The reference values are stored: it takes seconds.

    Example: urushi eval --weights runs/small/weights.safetensors -o runs/small/figures
    """

    weights: str | None = None
    """Networks: base (the default), small, or a weights file."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """Folder to write the figures (JSON) and plots to."""
    seed: int | None = None
    """Simulate other stacks by this seed instead of the stored ones; about ten minutes."""
    protocol: Literal["table", "adapter"] = "table"
    """What to measure: the table, or, at 10 to 20 minutes, the direction tables of 89 stacks by
    which the Neural Material Adapter was compared."""

    def run(self) -> int:
        if self.protocol == "adapter":
            from urushi.eval import adapter

            if self.seed is not None:
                raise ParameterError("--seed goes with the table; leave it out with adapter")
            print(adapter.report(self.weights, self.output))
            return 0
        if self.output is not None:
            extras.require("eval")
        from urushi.eval import report

        print(report.report(self.weights, self.output, seed=self.seed))
        return 0
