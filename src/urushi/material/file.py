"""The file of a material: its latent codes and the fingerprint of the networks they belong to.

If the material has a table, the file also holds the table and has a higher version: an older Urushi
would evaluate the codes, or mistake the table of a rest for a table of f.
"""

import os
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.material.table import SHAPE
from urushi.nets.weights import Model, of_fingerprint

#: Versions of files without a table, with one of all of f, and with one beside the lobe.
CODES_VERSION, TABLE_VERSION, FORMAT_VERSION = 2, 3, 4


class StoredMaterial(NamedTuple):
    """What a file holds.

    Attributes:
        latents, anchors: (C, L).
        table: (U, V, W, C), or None.
        rotation: [degrees] of the tangent.
        beside_lobe: whether the table leaves the lobe out.
    """

    latents: np.ndarray
    anchors: np.ndarray
    table: np.ndarray | None = None
    rotation: float = 0.0
    beside_lobe: bool = False


def write(path: str | os.PathLike, material: StoredMaterial, fingerprint: str) -> None:
    """Write a material that belongs to the networks of `fingerprint`.

    Raises:
        FileError: the file cannot be written.
    """
    version = CODES_VERSION
    if material.table is not None:
        version = FORMAT_VERSION if material.beside_lobe else TABLE_VERSION
    description: dict[str, Any] = {"version": version, "weights": fingerprint}
    if material.rotation:
        description["rotation"] = material.rotation
    arrays = {"latents": material.latents}
    if not np.array_equal(material.latents, material.anchors):
        arrays["anchors"] = material.anchors
    if material.table is not None:
        arrays["table"] = material.table
    files.write_tensors(path, "material", description, arrays)


def read(path: str | os.PathLike, model: Model | None) -> tuple[StoredMaterial, Model]:
    """Return what a file holds that was made with the networks of `model`, and these networks.

    model: None: the shipped networks by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, "material")
    version = description.get("version")
    if version not in (CODES_VERSION, TABLE_VERSION, FORMAT_VERSION):
        raise FileError(
            f"'{path}' has version {version!r} of the material format, "
            f"this Urushi reads versions {CODES_VERSION} to {FORMAT_VERSION}; "
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
        raise FileError(f"the material file '{path}' is damaged: its rotation is not an angle")
    beside_lobe = version == FORMAT_VERSION
    return StoredMaterial(latents, anchors, table, float(rotation), beside_lobe), model


def check_weights(path: str | os.PathLike, made_with: object, model: Model) -> None:
    """Check that a file was made with the networks of `model`, by its fingerprint.

    Raises:
        FileError: it was made with others.
    """
    if model.fingerprint != made_with:
        raise FileError(
            f"'{path}' does not match the weights: it was encoded with weights "
            f"{made_with}, but these are {model.fingerprint}; load those weights or encode the "
            "material again"
        )
