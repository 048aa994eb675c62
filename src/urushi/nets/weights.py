"""Trained networks as one value, their file format, and the networks that Urushi ships."""

import functools
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np

from urushi import files
from urushi.errors import FileError, ParameterError
from urushi.nets.architecture import Architecture, parameter_shapes
from urushi.nets.mlp import Params
from urushi.nets.networks import Networks, UrushiNetworks

#: Version of the file format.
FORMAT_VERSION = 1

#: Names of the shipped networks: files in the folder `weights`. The second are for anisotropic
#: materials, which are made with them unless a user names others.
DEFAULT, ANISOTROPIC = "default", "anisotropic"


@dataclass(frozen=True)
class ArchitectureKind:
    """The functions by which models and weights files handle one class of architectures.

    Attributes:
        architecture: the class; it has `latent`, `to_json` and `from_json`.
        parameter_shapes: maps an architecture to its parameters' shapes by name.
        networks: makes networks of parameters and an architecture.
    """

    architecture: Any
    parameter_shapes: Callable[[Any], dict[str, tuple[int, ...]]]
    networks: Callable[[Params, Any], Networks]


#: Kinds of architectures by the name that files record as `kind`; "urushi" is the default.
_kinds = {"urushi": ArchitectureKind(Architecture, parameter_shapes, UrushiNetworks)}


def register_kind(name: str, kind: ArchitectureKind) -> None:
    """Register another kind of architecture for models and weights files."""
    _kinds[name] = kind


def _kind_of(arch: Any) -> ArchitectureKind:
    """The kind of an architecture."""
    return next(kind for kind in _kinds.values() if isinstance(arch, kind.architecture))


def _read_architecture(path: str | os.PathLike, description: Any) -> Any:
    """The architecture that a weights file describes.

    Raises:
        FileError: no kind of this name is registered.
        ParameterError: the description does not fit its kind.
    """
    name = description.get("kind", "urushi") if isinstance(description, dict) else "urushi"
    if name not in _kinds:
        raise FileError(
            f"'{path}' holds networks of the kind {name!r}, but only {', '.join(_kinds)} can be "
            "read; register that kind first"
        )
    return _kinds[name].architecture.from_json(json.dumps(description))


@dataclass(frozen=True, eq=False)
class Model:
    """Trained networks: architecture, parameters and origin. Make one by `Model.of` or `read`.

    Attributes:
        arch: the architecture, of a registered kind.
        params: read-only float32 NumPy arrays by name.
        header: any JSON values: preset, seed, data, metrics, versions.
        fingerprint: twelve hexadecimal digits that identify arch and params, but not the header.
    """

    arch: Any
    params: Mapping[str, np.ndarray]
    header: Mapping[str, Any]
    fingerprint: str

    @classmethod
    def of(cls, arch: Any, params: Params, header: Mapping[str, Any]) -> "Model":
        """Make a model of parameters (arrays of NumPy or JAX).

        Raises:
            ParameterError: a parameter is missing, unknown, of a wrong shape or not finite.
        """
        shapes = _kind_of(arch).parameter_shapes(arch)
        unmatched = sorted(set(shapes) ^ set(params))
        if unmatched:
            state = "missing" if unmatched[0] in shapes else "unknown"
            raise ParameterError(f"the parameter '{unmatched[0]}' is {state} in these networks")
        checked = {name: _checked(name, params[name], shape) for name, shape in shapes.items()}
        return cls(arch, checked, dict(header), fingerprint(arch, checked))

    @property
    def widths(self) -> int:
        """GGX widths of a surface: 2 if the networks are for anisotropic materials, otherwise 1."""
        return getattr(self.arch, "widths", 1)

    @functools.cached_property
    def networks(self) -> Networks:
        """The networks: encoder, layerer, evaluation and proposals."""
        return _kind_of(self.arch).networks(self.params, self.arch)


def _checked(name: str, value: Any, shape: tuple[int, ...]) -> np.ndarray:
    """A read-only float32 copy of a parameter, after checks of its shape and values."""
    array = np.array(value, dtype=np.float32, order="C")
    if array.shape != shape:
        raise ParameterError(
            f"the parameter '{name}' has shape {array.shape}, but its architecture requires {shape}"
        )
    if not np.isfinite(array).all():
        raise ParameterError(f"the parameter '{name}' holds a number that is not finite")
    array.flags.writeable = False
    return array


def fingerprint(arch: Any, params: Params) -> str:
    """Return twelve hexadecimal digits of the SHA-256 of the architecture, names and arrays."""
    digest = hashlib.sha256(arch.to_json().encode())
    for name in sorted(params):
        digest.update(name.encode() + b"\0")
        digest.update(np.asarray(params[name], dtype="<f4").tobytes())
    return digest.hexdigest()[:12]


def save(path: str | os.PathLike, arch: Any, params: Params, header: Mapping[str, Any]) -> Model:
    """Write networks to a safetensors file and return them as a model.

    header: JSON values that describe their origin.

    Raises:
        ParameterError: as `Model.of`.
        FileError: the file cannot be written.
    """
    model = Model.of(arch, params, header)
    description = {
        "version": FORMAT_VERSION,
        "architecture": json.loads(arch.to_json()),
        "header": dict(header),
    }
    files.write_tensors(path, "weights", description, model.params)
    return model


def read(path: str | os.PathLike) -> Model:
    """Read a weights file that `save` wrote.

    Raises:
        FileError: the file is missing, truncated, foreign or of another version, its arrays do not
            fit its architecture.
    """
    description, arrays = files.read_tensors(path, "weights")
    if description.get("version") != FORMAT_VERSION:
        raise FileError(
            f"'{path}' has version {description.get('version')!r} of the weights format, "
            f"this Urushi reads version {FORMAT_VERSION}; install the Urushi that wrote it"
        )
    try:
        arch = _read_architecture(path, description.get("architecture"))
        return Model.of(arch, arrays, description.get("header") or {})
    except (ParameterError, TypeError, ValueError) as error:
        raise FileError(f"the weights file '{path}' is damaged: {error}") from error


#: Networks as a user may give them: a Model, a name of shipped ones, or a weights file.
Weights = Model | str | os.PathLike


def shipped_folder() -> Path:
    """The folder of the shipped weights."""
    return Path(__file__).with_name("weights")


@functools.cache
def shipped(name: str) -> Model:
    """The shipped networks `DEFAULT` or `ANISOTROPIC`, loaded once per process.

    Raises:
        FileError: the file is missing from this installation, or damaged.
    """
    path = shipped_folder() / f"{name}.safetensors"
    if not path.exists():
        raise FileError(f"Urushi's trained weights '{path}' are missing; install the package again")
    return read(path)


def default_model() -> Model:
    """The shipped networks of isotropic materials."""
    return shipped(DEFAULT)


def anisotropic_model() -> Model:
    """The shipped networks of anisotropic materials."""
    return shipped(ANISOTROPIC)


def of_fingerprint(fingerprint: object) -> Model:
    """The shipped networks of a fingerprint; the isotropic ones if no shipped networks have it."""
    other = anisotropic_model()
    return other if other.fingerprint == fingerprint else default_model()


def find(given: Weights | None) -> Model:
    """The networks that a user gave; the shipped ones for None.

    Raises:
        FileError: there is no such file, or it is damaged.
    """
    if isinstance(given, Model):
        return given
    if given is None or str(given) in (DEFAULT, ANISOTROPIC):
        return shipped(DEFAULT if given is None else str(given))
    if not Path(given).exists():
        raise FileError(
            f"there are no weights '{given}'; give a file, or '{DEFAULT}' for the shipped ones"
        )
    state = Path(given).stat()
    return _read_once(str(Path(given).absolute()), state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=8)
def _read_once(path: str, changed: int, size: int) -> Model:
    """A file's networks; the materials of a scene share them, with what the networks keep."""
    return read(path)
