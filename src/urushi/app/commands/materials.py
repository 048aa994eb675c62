"""`urushi materials`: the library of described materials."""

from dataclasses import dataclass


@dataclass(frozen=True)
class Materials:
    """List the materials of the library, with their descriptions.

    Every command that takes a description takes these names, too, as in
    `urushi view "vermilion urushi"`.

    Example: urushi materials
    """

    def run(self) -> int:
        from urushi.app.describe import library

        for name, description in library().items():
            print(f"{name}\n    {description}")
        return 0
