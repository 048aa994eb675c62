"""Trained networks as one value, their file, and the networks that ship with Urushi."""

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


@dataclass(frozen=True)
class System:
    """A kind of architecture: how a weights file describes it, and the networks that it makes.

    Attributes:
        architecture: its class, with `latent`, `to_json` and `from_json`.
        parameter_shapes: from an architecture, the parameters' shapes by name.
        networks: from parameters and an architecture, the networks.
    """

    architecture: Any
    parameter_shapes: Callable[[Any], dict[str, tuple[int, ...]]]
    networks: Callable[[Params, Any], Networks]


#: The systems that weights may belong to, by the name in their files.
_systems = {"urushi": System(Architecture, parameter_shapes, UrushiNetworks)}


def register_system(name: str, system: System) -> None:
    """Let weights files and models hold networks of another system."""
    _systems[name] = system


def _system_of(arch: Any) -> System:
    """The system that an architecture belongs to."""
    return next(system for system in _systems.values() if isinstance(arch, system.architecture))


def _read_architecture(description: Any) -> Any:
    """The architecture of a weights file's description; one without `kind` is Urushi's own.

    Raises:
        ParameterError: the kind is unknown, or the description does not fit its kind.
    """
    name = description.get("kind", "urushi") if isinstance(description, dict) else "urushi"
    if name not in _systems:
        raise ParameterError(
            f"the architecture is of kind {name!r}; this Urushi knows {', '.join(_systems)}"
        )
    return _systems[name].architecture.from_json(json.dumps(description))


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
        shapes = _system_of(arch).parameter_shapes(arch)
        unmatched = sorted(set(shapes) ^ set(params))
        if unmatched:
            state = "missing" if unmatched[0] in shapes else "unknown"
            raise ParameterError(f"the parameter '{unmatched[0]}' is {state} in these networks")
        checked = {name: _checked(name, params[name], shape) for name, shape in shapes.items()}
        return cls(arch, checked, dict(header), fingerprint(arch, checked))

    @functools.cached_property
    def networks(self) -> Networks:
        """What the model can do: encode, layer, evaluate, and propose directions."""
        return _system_of(self.arch).networks(self.params, self.arch)


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
    files.write_tensors(path, "weights", description, model.params)
    return model


def read(path: str | os.PathLike) -> Model:
    """Read a file of `save`.

    Raises:
        FileError: missing, truncated, foreign, of another version, or the arrays do not fit.
    """
    description, arrays = files.read_tensors(path, "weights")
    if description.get("version") != FORMAT_VERSION:
        raise FileError(
            f"'{path}' has version {description.get('version')!r} of the weights format, "
            f"this Urushi reads version {FORMAT_VERSION}; install the Urushi that wrote it"
        )
    try:
        arch = _read_architecture(description.get("architecture"))
        return Model.of(arch, arrays, description.get("header") or {})
    except (ParameterError, TypeError, ValueError) as error:
        raise FileError(f"the weights file '{path}' is damaged: {error}") from error


#: Files in the folder `weights` beside this module, the default first.
SHIPPED = ("base", "small")

#: Networks as users may give them: a Model, one of `NAMES`, or a weights file.
Weights = Model | str | os.PathLike


def shipped_folder() -> Path:
    """Where the shipped weights lie."""
    return Path(__file__).with_name("weights")


@functools.cache
def load_shipped(name: str) -> Model:
    """Load the shipped networks of a name, once a process.

    Raises:
        FileError: they are missing from this installation, or damaged.
    """
    path = shipped_folder() / f"{name}.safetensors"
    if not path.exists():
        raise FileError(
            f"Urushi's trained weights '{path}' are missing; install the package again, "
            f"or make them with 'urushi train --preset {name}'"
        )
    return read(path)


def default_model() -> Model:
    """The networks that are used when none are named.

    Raises:
        FileError: as of `load`.
    """
    return load_shipped(SHIPPED[0])


def find(given: Weights | None) -> Model:
    """The networks that a user means; None: the default ones.

    Raises:
        FileError: there is no such file, and no shipped networks of that name.
    """
    if isinstance(given, Model):
        return given
    if given is None:
        return default_model()
    if str(given) in SHIPPED:
        return load_shipped(str(given))
    if not Path(given).exists():
        raise FileError(
            f"there are no weights '{given}'; give a file, or one of {', '.join(SHIPPED)}"
        )
    return read(given)
