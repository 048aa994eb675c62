"""Checkpoints: a stage's whole state in one file, with the preset that it belongs to."""

import os
from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import jax
import jax.numpy as jnp
import numpy as np

from urushi.errors import FileError
from urushi.nets import tensorfile

FORMAT_VERSION = 1


@dataclass(frozen=True)
class Checkpoint:
    """Where a training stands.

    Attributes:
        stage: the name of one of the training's stages.
        step: steps of that stage that are done.
        seconds: time spent so far, all stages together.
        state: as the stage's next step finds it, any tree of arrays.
        networks: the parameters that the stage before has finished.
    """

    stage: str
    step: int
    seconds: float
    state: Any
    networks: dict[str, Any]


def save(path: str | os.PathLike, point: Checkpoint, identity: Mapping[str, Any]) -> None:
    """Write a checkpoint; readers see the old file or the new one.

    `identity` (JSON values: preset and data) must be the same on `load`.
    """
    description = {
        "version": FORMAT_VERSION,
        "stage": point.stage,
        "step": point.step,
        "seconds": point.seconds,
        "identity": dict(identity),
    }
    arrays = {name: np.asarray(leaf) for name, leaf in _named_leaves(point)}
    tensorfile.write(path, "checkpoint", description, arrays)


def load(path: Path, like: Mapping[str, Checkpoint], identity: Mapping[str, Any]) -> Checkpoint:
    """Read a checkpoint.

    Args:
        path: the file.
        like: each stage's beginning, for the structure and the shapes.
        identity: the preset and data that the checkpoint must belong to.

    Raises:
        FileError: missing, truncated, foreign, or of another training.
    """
    description, arrays = tensorfile.read(path, "checkpoint")
    if description.get("version") != FORMAT_VERSION or description.get("identity") != identity:
        raise FileError(
            f"'{path}' is a checkpoint of another preset, data or version; "
            "delete it, or choose another run folder"
        )
    beginning = like[description["stage"]]
    expected = _named_leaves(beginning)
    sizes = {name: leaf.size for name, leaf in expected}  # a file has no arrays without axes
    if {name: array.size for name, array in arrays.items()} != sizes:
        raise FileError(f"'{path}' has other arrays than its preset asks for; delete it")
    structure = jax.tree.structure((beginning.state, beginning.networks))
    leaves = [jnp.asarray(arrays[name].reshape(leaf.shape)) for name, leaf in expected]
    state, networks = jax.tree.unflatten(structure, leaves)
    return Checkpoint(
        description["stage"], description["step"], description["seconds"], state, networks
    )


def _named_leaves(point: Checkpoint) -> list[tuple[str, Any]]:
    leaves, _ = jax.tree_util.tree_flatten_with_path((point.state, point.networks))
    return [(jax.tree_util.keystr(path), leaf) for path, leaf in leaves]
