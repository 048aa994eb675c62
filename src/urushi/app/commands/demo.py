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

    def run(self) -> int:
        from urushi.app.demo import run

        run.run(self.output)
        return 0
