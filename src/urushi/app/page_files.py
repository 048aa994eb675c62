"""The files of the page: the built page, the networks in half precision, and what it shows first.

The page is built from the folder `viewer` of the repository by `make viewer`.
"""

import json
from pathlib import Path
from typing import Any

import numpy as np
import safetensors.numpy

from urushi.app.describe import describe, is_description
from urushi.errors import FileError, ParameterError
from urushi.files import METADATA_KEY
from urushi.nets.architecture import Architecture
from urushi.nets.weights import FORMAT_VERSION, Model

#: Names of the files that are made, not built.
WEIGHTS_FILE, START_FILE = "weights.safetensors", "start.json"

#: Coats that the page has cards for.
MOST_COATS = 6


def page_files(material: str | None, weights: str | None) -> dict[str, bytes]:
    """The page's files by their paths relative to it, with "/" between folders.

    Args:
        material: what it shows first: a description, a material file or a measured file; None: its
            own first material.
        weights: weights file of the networks; None: the shipped ones.

    Raises:
        UrushiError: the material or the weights cannot be read, or the page was not built.
    """
    from urushi.nets.weights import find

    model = find(weights)
    folder = built_folder()
    built = {
        path.relative_to(folder).as_posix(): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }
    if "index.html" not in built:
        raise FileError(f"the page is missing in '{folder}'; run `make viewer` in the repository")
    start = {} if material is None else {"materials": [first_material(material, weights)]}
    made = {WEIGHTS_FILE: half_precision(model), START_FILE: json.dumps(start).encode()}
    return built | made


def built_folder() -> Path:
    """The folder of the built page."""
    return Path(__file__).with_name("page")


def half_precision(model: Model) -> bytes:
    """A weights file (safetensors) with the networks' parameters as half floats.

    Raises:
        ParameterError: the networks are of another kind, or a parameter is too large.
    """
    if not isinstance(model.arch, Architecture):
        raise ParameterError("the page runs Urushi's own networks only; give weights of those")
    largest = float(np.finfo(np.float16).max)
    if any(np.abs(array).max() > largest for array in model.params.values()):
        raise ParameterError("a parameter of the networks is too large for half precision")
    halves = {name: array.astype(np.float16) for name, array in model.params.items()}
    description = {
        "kind": "weights",
        "version": FORMAT_VERSION,
        "architecture": json.loads(model.arch.to_json()),
        "fingerprint": model.fingerprint,
    }
    return safetensors.numpy.save(halves, {METADATA_KEY: json.dumps(description, sort_keys=True)})


def first_material(text: str, weights: str | None) -> dict[str, Any]:
    """A material as the page reads it: as cards if it is described, otherwise by its codes."""
    if is_description(text):
        cards = _cards(describe(text))
        if cards is not None:
            return cards
    from urushi.app.commands.layer import read_material

    material = read_material(text, weights)
    if material.own_decoder is not None:
        raise ParameterError(
            f"'{text}' has a decoder of its own, which the page cannot evaluate; "
            "encode it without --own-decoder"
        )
    name = "Material" if is_description(text) else Path(text).stem
    codes = {
        "latents": _three(material.latents).ravel().tolist(),
        "anchors": _three(material.anchors).ravel().tolist(),
    }
    return {"name": name, "bottom": {"kind": "codes", **codes}, "coats": []}


def _three(codes: np.ndarray) -> np.ndarray:
    """Codes (3, L) of (3, L) or, for a grey material, (1, L)."""
    return np.broadcast_to(codes, (3, codes.shape[1]))


def _cards(described: Any) -> dict[str, Any] | None:
    """The cards of a description; None if the page has no cards for it."""
    from urushi.reference.stack import Conductor, Dielectric, Diffuse, Stack

    coats = described.coats if isinstance(described, Stack) else ()
    bottom = described.bottom if isinstance(described, Stack) else described
    if len(coats) > MOST_COATS:
        return None
    match bottom:
        case Conductor(alpha=alpha, r0=None, eta=eta, k=k):
            kind = {"kind": "conductor", "alpha": alpha, "eta": eta, "k": k}
        case Conductor(alpha=alpha, r0=r0):
            kind = {"kind": "conductor", "alpha": alpha, "r0": r0}
        case Dielectric(alpha=alpha, eta=eta):
            kind = {"kind": "dielectric", "alpha": alpha, "eta": eta}
        case Diffuse(reflectance=reflectance):
            kind = {"kind": "diffuse", "reflectance": reflectance}
        case _:
            return None
    cards = [
        {
            "alpha": coat.alpha,
            "eta": coat.eta,
            "albedo": coat.albedo,
            "sigmaT": coat.sigma_t,
            "g": coat.g,
        }
        for coat in coats
    ]
    return {"name": "Material", "bottom": kind, "coats": cards}
