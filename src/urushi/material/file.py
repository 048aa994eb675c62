"""The file of a material: its latent codes and the fingerprint of the networks they belong to.

If the material has a table, the file also holds the table and has a higher version: an older Urushi
would evaluate the codes, or mistake the table of a rest for a table of f.
"""

import os
from typing import Any, NamedTuple

import numpy as np

from urushi import files
from urushi.checks import COAT_COLUMNS
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
        coat: (P, C) or (P, 1) the columns of `checks.CoatParameters` of the topmost coat, or None.
        absolute: whether the coat's index is absolute.
        bottom: the material under the coat, None without.
    """

    latents: np.ndarray
    anchors: np.ndarray
    table: np.ndarray | None = None
    rotation: float = 0.0
    beside_lobe: bool = False
    coat: np.ndarray | None = None
    absolute: bool = False
    bottom: "StoredMaterial | None" = None


def write(path: str | os.PathLike, material: StoredMaterial, fingerprint: str) -> None:
    """Write a material that belongs to the networks of `fingerprint`.

    Raises:
        FileError: the file cannot be written.
    """
    description, arrays = _contents(material)
    files.write_tensors(path, "material", {**description, "weights": fingerprint}, arrays)


def _contents(material: StoredMaterial) -> tuple[dict[str, Any], dict[str, np.ndarray]]:
    """The description and the arrays of a material and of those under its coats."""
    version = CODES_VERSION
    if material.table is not None:
        version = FORMAT_VERSION if material.beside_lobe else TABLE_VERSION
    description: dict[str, Any] = {"version": version}
    if material.rotation:
        description["rotation"] = material.rotation
    arrays = {"latents": material.latents}
    if not np.array_equal(material.latents, material.anchors):
        arrays["anchors"] = material.anchors
    if material.table is not None:
        arrays["table"] = material.table
    if material.coat is not None and material.bottom is not None:
        arrays["coat"] = material.coat
        below, others = _contents(material.bottom)
        description |= {"absolute": material.absolute, "bottom": below}
        arrays |= {f"bottom.{name}": array for name, array in others.items()}
    return description, arrays


def read(path: str | os.PathLike, model: Model | None) -> tuple[StoredMaterial, Model]:
    """Return what a file holds that was made with the networks of `model`, and these networks.

    model: None: the shipped networks by which it was made.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, "material")
    made_with = description.get("weights")
    model = of_fingerprint(made_with) if model is None else model
    check_weights(path, made_with, model)
    return _stored(path, description, arrays, model.arch.latent), model


def _stored(
    path: str | os.PathLike, description: dict[str, Any], arrays: dict[str, np.ndarray], width: int
) -> StoredMaterial:
    """A material of codes of a width, from its description and its arrays."""
    version = description.get("version")
    if version not in (CODES_VERSION, TABLE_VERSION, FORMAT_VERSION):
        raise FileError(
            f"'{path}' has version {version!r} of the material format, "
            f"this Urushi reads versions {CODES_VERSION} to {FORMAT_VERSION}; "
            "install the Urushi that wrote it"
        )
    latents = arrays.get("latents")
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
    stored = StoredMaterial(latents, anchors, table, float(rotation), version == FORMAT_VERSION)
    coat, below = arrays.get("coat"), description.get("bottom")
    if coat is None or not isinstance(below, dict):
        return stored
    names = {len(names) for names in COAT_COLUMNS.values()}
    if coat.ndim != 2 or len(coat) not in names or not np.isfinite(coat).all():
        raise FileError(f"the material file '{path}' is damaged: its coat is not a coat's numbers")
    prefix = "bottom."
    under = {n.removeprefix(prefix): array for n, array in arrays.items() if n.startswith(prefix)}
    absolute = bool(description.get("absolute"))
    return stored._replace(coat=coat, absolute=absolute, bottom=_stored(path, below, under, width))


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
