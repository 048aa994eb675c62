"""Trained networks as one value, and the file that they are kept in."""

import functools
import hashlib
import json
import os
from collections.abc import Mapping
from dataclasses import dataclass
from typing import Any

import numpy as np

from urushi.errors import FileError, ParameterError
from urushi.nets import kinds, tensorfile
from urushi.nets.architecture import Params
from urushi.nets.networks import Networks

FORMAT_VERSION = 1


@dataclass(frozen=True, eq=False)
class Model:
    """Networks: sizes, parameters and where they come from. Build it with `Model.of` or `load`.

    Attributes:
        arch: the sizes, an architecture of a kind in `kinds`.
        params: read-only float32 NumPy arrays by name.
        header: free JSON values: preset, seed, data, metrics, versions.
        fingerprint: twelve hexadecimal digits that identify arch and params, not the header.
    """

    arch: Any
    params: Mapping[str, np.ndarray]
    header: Mapping[str, Any]
    fingerprint: str

    @classmethod
    def of(cls, arch: Any, params: Params, header: Mapping[str, Any]) -> "Model":
        """Check parameters (arrays of NumPy or JAX) and make them a model.

        Raises:
            ParameterError: a parameter is missing, unknown, of a wrong shape or not finite.
        """
        shapes = kinds.of(arch).shapes(arch)
        unmatched = sorted(set(shapes) ^ set(params))
        if unmatched:
            state = "missing" if unmatched[0] in shapes else "unknown"
            raise ParameterError(f"the parameter '{unmatched[0]}' is {state} in these networks")
        checked = {name: _checked(name, params[name], shape) for name, shape in shapes.items()}
        return cls(arch, checked, dict(header), fingerprint(arch, checked))

    @functools.cached_property
    def networks(self) -> Networks:
        """What the model can do: encode, layer, evaluate, and propose directions."""
        return kinds.of(self.arch).bind(self.params, self.arch)


def _checked(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    array = np.array(value, dtype=np.float32, order="C")  # a copy
    if array.shape != shape:
        raise ParameterError(
            f"the parameter '{name}' has shape {array.shape}, but its architecture asks for {shape}"
        )
    if not np.isfinite(array).all():
        raise ParameterError(f"the parameter '{name}' holds a number that is not finite")
    array.flags.writeable = False
    return array


def fingerprint(arch: Any, params: Params) -> str:
    """Return the first twelve hexadecimal digits of SHA-256 over sizes, names and arrays."""
    digest = hashlib.sha256(arch.to_json().encode())
    for name in sorted(params):
        digest.update(name.encode() + b"\0")
        digest.update(np.asarray(params[name], dtype="<f4").tobytes())
    return digest.hexdigest()[:12]


def save(path: str | os.PathLike, arch: Any, params: Params, header: Mapping[str, Any]) -> Model:
    """Write networks to a safetensors file; returns them as a model.

    header: JSON values that say where they come from.

    Raises:
        ParameterError: as of `Model.of`.
        FileError: the file cannot be written.
    """
    model = Model.of(arch, params, header)
    description = {
        "version": FORMAT_VERSION,
        "architecture": json.loads(arch.to_json()),
        "header": dict(header),
    }
    tensorfile.write(path, "weights", description, model.params)
    return model


def load(path: str | os.PathLike) -> Model:
    """Read a file of `save`.

    Raises:
        FileError: missing, truncated, foreign, of another version, or the arrays do not fit.
    """
    description, arrays = tensorfile.read(path, "weights")
    if description.get("version") != FORMAT_VERSION:
        raise FileError(
            f"'{path}' has version {description.get('version')!r} of the weights format, "
            f"this Urushi reads version {FORMAT_VERSION}; install the Urushi that wrote it"
        )
    try:
        arch = kinds.read(description.get("architecture"))
        return Model.of(arch, arrays, description.get("header") or {})
    except (ParameterError, TypeError, ValueError) as error:
        raise FileError(f"the weights file '{path}' is damaged: {error}") from error
