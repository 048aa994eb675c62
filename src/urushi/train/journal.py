"""The run folder: the last checkpoint, and a log with one JSON object a line."""

import json
from collections.abc import Mapping, Sequence
from pathlib import Path
from typing import Any

from urushi.files import atomic_write
from urushi.train import checkpoint
from urushi.train.checkpoint import Checkpoint


class Journal:
    """Keeps one training's checkpoint and log.

    Args:
        folder: the run folder.
        identity: JSON values of preset and data; a checkpoint of another identity is refused.
        stages: the stages' names, in order.
    """

    def __init__(self, folder: Path, identity: Mapping[str, Any], stages: Sequence[str]) -> None:
        self._checkpoint = folder / "checkpoint.safetensors"
        self._log = folder / "log.jsonl"
        self._identity = identity
        self._stages = stages

    def begun(self) -> bool:
        """Whether there is a checkpoint."""
        return self._checkpoint.exists()

    def clear(self) -> None:
        """Forget an earlier training's log."""
        self._log.unlink(missing_ok=True)

    def restore(self, beginnings: Mapping[str, Checkpoint]) -> Checkpoint | None:
        """The last checkpoint, or None; log lines of steps that it has not done are removed."""
        if not self.begun():
            return None
        point = checkpoint.load(self._checkpoint, beginnings, self._identity)
        if self._log.exists():
            lines = self._log.read_text().splitlines(keepends=True)
            with atomic_write(self._log) as path:
                path.write_text("".join(x for x in lines if self._place(x) <= self._of(point)))
        return point

    def save(self, point: Checkpoint) -> None:
        """Replace the checkpoint."""
        checkpoint.save(self._checkpoint, point, self._identity)

    def log(self, point: Checkpoint, figures: Mapping[str, float]) -> None:
        """Append a line for the steps up to `point`."""
        rounded = {name: float(f"{value:.5g}") for name, value in figures.items()}
        entry = {"stage": point.stage, "step": point.step, "seconds": round(point.seconds, 1)}
        with self._log.open("a") as file:
            file.write(json.dumps(entry | rounded) + "\n")

    def _of(self, point: Checkpoint) -> tuple[int, int]:
        return self._stages.index(point.stage), point.step

    def _place(self, line: str) -> tuple[int, int]:
        """Stage and step of a log line; a line that a kill has torn comes after everything."""
        try:
            entry = json.loads(line)
        except ValueError:
            return len(self._stages), 0
        return self._stages.index(entry["stage"]), entry["step"]
