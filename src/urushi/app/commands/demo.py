"""`urushi demo`."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro


@dataclass(frozen=True)
class Demo:
    """Render a lacquered tea caddy by the reference walk and by the networks, side by side.

    Writes both pictures, their difference (EXR and PNG) and the error's figures.

    Example: urushi demo -o out/demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("out/demo")
    """Folder to write to."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    size: int = 400
    """Pixels across each picture."""
    spp: int = 128
    """Samples per pixel of each picture, a multiple of 16."""

    def run(self) -> int:
        from urushi.app.commands.render import set_variant
        from urushi.app.demo import run

        set_variant(self.mode)
        figures = run.run(self.output, size=self.size, spp=self.spp, variant=self.mode)
        print(run.describe(figures))
        print(self.output / "comparison.png")
        return 0
