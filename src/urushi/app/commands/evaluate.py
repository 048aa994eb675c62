"""`urushi eval`: errors of trained networks on held-out stacks."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Evaluate:
    """Measure networks on layered materials that they were not trained on.

    Prints the errors E (of energy) and P (of pairs) for each group of stacks, in percent, beside
    the reference's own; docs/conventions.md says what they mean.

    Example: urushi eval --weights runs/quick/weights.safetensors
    """

    weights: Path | None = None
    """Weights file; default: the one that is shipped."""
    output: Annotated[Path | None, tyro.conf.arg(aliases=["-o"])] = None
    """JSON file to write the figures to."""
    seed: int = 0
    """Seed of the held-out stacks."""

    def run(self) -> int:
        from urushi.eval import heldout

        print(heldout.report(self.weights, self.output, seed=self.seed))
        return 0
