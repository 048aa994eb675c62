"""The file of a material: its latent codes and the fingerprint of the networks they belong to."""

import os
from collections.abc import Sequence

import numpy as np

from urushi import files
from urushi.errors import FileError
from urushi.nets.weights import Model

FORMAT_VERSION = 2


def write(
    path: str | os.PathLike, latents: np.ndarray, anchors: np.ndarray, fingerprint: str
) -> None:
    """Write latents and anchors (C, 32) that belong to the networks of `fingerprint`.

    Raises:
        FileError: the file cannot be written.
    """
    description = {"version": FORMAT_VERSION, "weights": fingerprint}
    arrays = {"latents": latents}
    if not np.array_equal(latents, anchors):
        arrays["anchors"] = anchors
    files.write_tensors(path, "material", description, arrays)


def read(path: str | os.PathLike, models: Sequence[Model]) -> tuple[np.ndarray, np.ndarray, Model]:
    """Return a file's latents and anchors (C, 32), and the one of `models` that made it.

    Raises:
        FileError: missing, truncated, foreign, damaged, or made with other networks.
    """
    description, arrays = files.read_tensors(path, "material")
    if description.get("version") != FORMAT_VERSION:
        raise FileError(
            f"'{path}' has version {description.get('version')!r} of the material format, "
            f"this Urushi reads version {FORMAT_VERSION}; install the Urushi that wrote it"
        )
    model = matching_weights(path, description.get("weights"), models)
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
    return latents, anchors, model


def matching_weights(path: str | os.PathLike, made_with: object, models: Sequence[Model]) -> Model:
    """The one of `models` that a file was made with, by its fingerprint.

    Raises:
        FileError: it was made with others.
    """
    model = next((model for model in models if model.fingerprint == made_with), None)
    if model is None:
        loaded = " and ".join(model.fingerprint for model in models)
        raise FileError(
            f"'{path}' and the weights do not belong together: it was encoded with weights "
            f"{made_with}, these are {loaded}; load those weights or encode the material again"
        )
    return model
