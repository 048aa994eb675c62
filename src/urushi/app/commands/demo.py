"""`urushi demo`: both methods on a tea caddy."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated

import tyro

from urushi.app.commands.render import set_variant
from urushi.ranges import Pixels, Range


@dataclass(frozen=True)
class Demo:
    """Render a lacquered tea caddy by the reference walk and by the networks, and compare.

    Writes both pictures (.exr), `comparison.png` and `report.json` into a folder, and the scene's
    files into its folder `scene`. Then prints what each method cost, what to look at and what to
    try next.

    Example: urushi demo -o out/demo
    """

    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])] = Path("out/demo")
    """Folder to write to. It is created if it is missing."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant."""
    width: Pixels = 400
    """Width of each picture in pixels."""
    height: Pixels = 400
    """Height of each picture in pixels."""
    spp: Annotated[int, Range(16, 1 << 16, " samples", step=16)] = 128
    """Samples per pixel of each picture, a multiple of 16."""

    def run(self) -> int:
        set_variant(self.mode)
        from urushi.app import demo
        from urushi.scenes.options import Options

        options = Options(width=self.width, height=self.height, spp=self.spp)
        print(demo.describe(demo.run(self.output, options), self.output))
        return 0
