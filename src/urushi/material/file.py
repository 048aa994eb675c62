"""The file of a material: its latent codes and the fingerprint of the networks they belong to.

Where a material has decoders of its own, they follow, and the version is higher: an older Urushi
would evaluate the codes.
"""

import os
from typing import NamedTuple

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.material.table import SHAPE
from urushi.nets import former
from urushi.nets.weights import Model

#: Versions of files without and with decoders of their own.
CODES_VERSION, FORMAT_VERSION = 2, 3


class StoredMaterial(NamedTuple):
    """What a file holds.

    Attributes:
        latents, anchors: (C, L).
        table: (U, V, W, C), or None.
    """

    latents: np.ndarray
    anchors: np.ndarray
    table: np.ndarray | None


def write(
    path: str | os.PathLike,
    latents: np.ndarray,
    anchors: np.ndarray,
    fingerprint: str,
    table: np.ndarray | None = None,
) -> None:
    """Write latents and anchors (C, L) that belong to the networks of `fingerprint`.

    table: float16 (U, V, W, C) of ln f, see `urushi.material.table`.

    Raises:
        FileError: the file cannot be written.
    """
    version = CODES_VERSION if table is None else FORMAT_VERSION
    description = {"version": version, "weights": fingerprint}
    arrays = {"latents": latents}
    if not np.array_equal(latents, anchors):
        arrays["anchors"] = anchors
    if table is not None:
        arrays["table"] = table
    files.write_tensors(path, "material", description, arrays)


def read(path: str | os.PathLike, model: Model) -> StoredMaterial:
    """Return what a file holds that was made with the networks of `model`.

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
    check_weights(path, description.get("weights"), model)
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
    return StoredMaterial(latents, anchors, table)


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
