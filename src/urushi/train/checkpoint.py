"""Checkpoints and the run folder: the state of a stage in one file, and a log of JSON lines."""

import json
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi import files
from urushi.errors import FileError

FORMAT_VERSION = 2


@dataclass(frozen=True)
class Checkpoint:
    """The state of a training."""

    stage: str  # the name of one of the training's stages
    step: int  # number of completed steps of this stage
    seconds: float  # time spent so far, all stages together
    state: Any  # input of the stage's next step, any tree of arrays
    networks: dict[str, Any]  # the parameters that earlier stages have trained


def _named_leaves(point: Checkpoint) -> list[tuple[str, Any]]:
    leaves = jax.tree.leaves_with_path((point.state, point.networks))
    return [(jax.tree_util.keystr(path), leaf) for path, leaf in leaves]


class Journal:
    """The checkpoint and the log of one training, in its run folder."""

    def __init__(
        self, folder: Path, identity: Mapping[str, Any], data_seconds: float = 0.0
    ) -> None:
        self._checkpoint = folder / "checkpoint.safetensors"
        self._log = folder / "log.jsonl"
        self.identity = identity  # JSON values of preset and data, which a checkpoint must share
        self.data_seconds = data_seconds  # time spent on the data, by earlier runs too

    def begun(self) -> bool:
        """Whether the folder has a checkpoint."""
        return self._checkpoint.exists()

    def clear(self) -> None:
        """Delete the log of an earlier training."""
        self._log.unlink(missing_ok=True)

    def restore(self, beginnings: Mapping[str, Checkpoint]) -> Checkpoint | None:
        """The last checkpoint, or None.

        beginnings: each stage's first checkpoint, for the structure and the shapes.
        """
        if not self.begun():
            return None
        path = self._checkpoint
        description, arrays = files.read_tensors(path, "checkpoint")
        found = description.get("version"), description.get("identity")
        if found != (FORMAT_VERSION, self.identity):
            raise FileError(
                f"'{path}' is a checkpoint of another preset, data or version; "
                "delete it, or choose another run folder"
            )
        beginning = beginnings[description["stage"]]
        expected = _named_leaves(beginning)
        sizes = {name: leaf.size for name, leaf in expected}  # in a file, scalars are arrays of one
        if {name: array.size for name, array in arrays.items()} != sizes:
            raise FileError(f"'{path}' does not have the arrays that its preset needs; delete it")
        structure = jax.tree.structure((beginning.state, beginning.networks))
        leaves = [jnp.asarray(arrays[name].reshape(leaf.shape)) for name, leaf in expected]
        numbers = (description[name] for name in ("stage", "step", "seconds"))
        point = Checkpoint(*numbers, *jax.tree.unflatten(structure, leaves))
        self.data_seconds += description["data_seconds"]
        return point

    def save(self, point: Checkpoint, figures: Mapping[str, float] = {}) -> None:
        """Replace the checkpoint, and append figures of the steps up to it to the log."""
        description = {
            "version": FORMAT_VERSION,
            "stage": point.stage,
            "step": point.step,
            "seconds": point.seconds,
            "data_seconds": self.data_seconds,
            "identity": dict(self.identity),
        }
        arrays = {name: np.asarray(leaf) for name, leaf in _named_leaves(point)}
        files.write_tensors(self._checkpoint, "checkpoint", description, arrays)
        if figures:
            rounded = {name: float(f"{value:.5g}") for name, value in figures.items()}
            entry = {"stage": point.stage, "step": point.step, "seconds": round(point.seconds, 1)}
            with self._log.open("a") as file:
                file.write(json.dumps(entry | rounded) + "\n")
