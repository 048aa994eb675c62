"""The file of a material: its latent codes and the fingerprint of the networks they belong to.

Where a material has decoders of its own, they follow, and the version is higher: an older Urushi
would evaluate the codes.
"""

import os
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.material.table import SHAPE
from urushi.nets import former
from urushi.nets.weights import Model, of_fingerprint

#: Versions of files without and with decoders of their own.
CODES_VERSION, FORMAT_VERSION = 2, 3


class StoredMaterial(NamedTuple):
    """What a file holds.

    Attributes:
        latents, anchors: (C, L).
        table: (U, V, W, C), or None.
        rotation: [degrees] of the tangent.
    """

    latents: np.ndarray
    anchors: np.ndarray
    table: np.ndarray | None
    rotation: float


def write(
    path: str | os.PathLike,
    latents: np.ndarray,
    anchors: np.ndarray,
    fingerprint: str,
    table: np.ndarray | None = None,
    rotation: float = 0.0,
) -> None:
    """Write latents and anchors (C, L) that belong to the networks of `fingerprint`.

    table: float16 (U, V, W, C) of ln f, see `urushi.material.table`. rotation: [degrees] of the
    tangent.

    Raises:
        FileError: the file cannot be written.
    """
    version = CODES_VERSION if table is None else FORMAT_VERSION
    description: dict[str, Any] = {"version": version, "weights": fingerprint}
    if rotation:
        description["rotation"] = rotation
    arrays = {"latents": latents}
    if not np.array_equal(latents, anchors):
        arrays["anchors"] = anchors
    if table is not None:
        arrays["table"] = table
    files.write_tensors(path, "material", description, arrays)


def read(path: str | os.PathLike, model: Model | None) -> tuple[StoredMaterial, Model]:
    """Return what a file holds that was made with the networks of `model`, and these networks.

    model: None: the shipped networks by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, "material")
    former.refuse_codes(path, description.get("weights"))
    version = description.get("version")
    if version not in (CODES_VERSION, FORMAT_VERSION):
        raise FileError(
            f"'{path}' has version {version!r} of the material format, "
            f"this Urushi reads versions {CODES_VERSION} and {FORMAT_VERSION}; "
            "install the Urushi that wrote it"
        )
    made_with = description.get("weights")
    model = of_fingerprint(made_with) if model is None else model
    check_weights(path, made_with, model)
    latents = arrays.get("latents")
    width = model.arch.latent
    if latents is None or latents.ndim != 2 or not len(latents) or latents.shape[1] != width:
        raise FileError(f"the material file '{path}' is damaged: it has no latents (C, {width})")
    anchors = arrays.get("anchors", latents)
    if anchors.shape != latents.shape:
        raise FileError(
            f"the material file '{path}' is damaged: its anchors have shape {anchors.shape}, its "
            f"latents {latents.shape}"
        )
    for codes in (latents, anchors):
        if codes.dtype != np.float32 or not np.isfinite(codes).all():
            raise FileError(f"the material file '{path}' is damaged: a code is not finite float32")
    table = arrays.get("table")
    if (table is None) != (version == CODES_VERSION):
        state = "no table" if table is None else "a table"
        raise FileError(
            f"the material file '{path}' is damaged: a file of version {version} has {state}"
        )
    shape = (*SHAPE, len(latents))
    if table is not None and (
        table.shape != shape or table.dtype != np.float16 or not np.isfinite(table).all()
    ):
        raise FileError(
            f"the material file '{path}' is damaged: its table is not finite float16 {shape}"
        )
    rotation = description.get("rotation", 0.0)
    if not isinstance(rotation, int | float) or not np.isfinite(rotation):
        raise FileError(f"the material file '{path}' is damaged: its rotation is no angle")
    return StoredMaterial(latents, anchors, table, float(rotation)), model


def check_weights(path: str | os.PathLike, made_with: object, model: Model) -> None:
    """Check that a file was made with the networks of `model`, by its fingerprint.

    Raises:
        FileError: it was made with others.
    """
    if model.fingerprint != made_with:
        raise FileError(
            f"'{path}' and the weights do not belong together: it was encoded with weights "
            f"{made_with}, these are {model.fingerprint}; load those weights or encode the "
            "material again"
        )
