"""Weights as one value, their file format, and the weights that Urushi ships."""

import functools
import hashlib
import json
import os
from collections.abc import Callable, Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import Any, TypeVar

import numpy as np

from urushi import files
from urushi.checks import real
from urushi.errors import FileError, ParameterError
from urushi.nets.basis import Basis, grid_of, on_grid
from urushi.nets.mlp import Params
from urushi.nets.networks import Architecture, Networks

#: Version of the file format.
FORMAT_VERSION = 1

#: Names of the shipped weights: files in the folder `weights`. The second are for anisotropic
#: materials, which are made with them unless a user names others.
DEFAULT, ANISOTROPIC = "default", "anisotropic"

#: The system that files name as `kind`. Files without the entry are Urushi's own.
KIND = "urushi"

Read = TypeVar("Read")


@dataclass(frozen=True, eq=False)
class Model:
    """Weights: architecture, parameters and origin. Make one by `Model.of` or `read`."""

    arch: Architecture
    params: Mapping[str, np.ndarray]  # read-only float32 arrays by name
    header: Mapping[str, Any]  # any JSON values: preset, seed, data, metrics, versions
    fingerprint: str  # twelve hexadecimal digits that identify arch and params, but not the header

    @classmethod
    def of(cls, arch: Architecture, params: Params, header: Mapping[str, Any]) -> "Model":
        """Make a model of parameters (arrays of NumPy or JAX).

        Raises:
            ParameterError: a parameter is missing, unknown, of a wrong shape or not finite.
        """
        checked = checked_parameters(params, arch.parameter_shapes())
        checked["basis.rows"] = on_grid(checked["basis.rows"])
        checked["basis.rows"].flags.writeable = False
        return cls(arch, checked, dict(header), fingerprint(arch.to_json(), checked))

    @property
    def widths(self) -> int:
        """GGX widths of a surface: 2 for anisotropic materials, otherwise 1."""
        return self.arch.widths

    @functools.cached_property
    def networks(self) -> Networks:
        """Codes, layering, evaluation and proposals."""
        rows, measure, prior = (
            self.params[f"basis.{name}"] for name in ("rows", "measure", "prior")
        )
        basis = Basis(rows, self.arch.factors, measure, prior.astype(np.float64), self.widths)
        return Networks(self.params, self.arch, basis)

    def __getstate__(self) -> dict[str, Any]:
        """What pickles and copies hold; `networks` follows from it, with functions in memory."""
        return {name: value for name, value in vars(self).items() if name != "networks"}


def checked_parameters(
    params: Params, shapes: Mapping[str, tuple[int, ...]]
) -> dict[str, np.ndarray]:
    """Read-only float32 copies of parameters, by name, of these shapes.

    Raises:
        ParameterError: a parameter is missing, unknown, of a wrong shape or not finite.
    """
    unmatched = sorted(set(shapes) ^ set(params))
    if unmatched:
        state = "missing" if unmatched[0] in shapes else "unknown"
        raise ParameterError(f"the parameter '{unmatched[0]}' is {state} in these weights")
    checked = {}
    for name, shape in shapes.items():
        array = checked[name] = np.array(real(params[name], np.float32), order="C")
        if array.shape != shape:
            raise ParameterError(
                f"the parameter '{name}' has shape {array.shape}, but its architecture requires "
                f"{shape}"
            )
        if not np.isfinite(array).all():
            raise ParameterError(f"the parameter '{name}' holds a number that is not finite")
        array.flags.writeable = False
    return checked


def fingerprint(arch: str, params: Params) -> str:
    """Twelve hexadecimal digits of the SHA-256 of an architecture's JSON, names and arrays."""
    digest = hashlib.sha256(arch.encode())
    for name in sorted(params):
        digest.update(name.encode() + b"\0")
        digest.update(np.asarray(params[name], dtype="<f4").tobytes())
    return digest.hexdigest()[:12]


def save(
    path: str | os.PathLike, arch: Architecture, params: Params, header: Mapping[str, Any]
) -> Model:
    """Write weights to a safetensors file and return them as a model.

    header: JSON values that describe their origin.

    Raises:
        ParameterError: as `Model.of`.
        FileError: the file cannot be written.
    """
    model = Model.of(arch, params, header)
    rows = model.params["basis.rows"]
    low, step = grid_of(rows)  # files hold the rows in 16 bits
    numbers = np.rint((rows - low) / step).astype(np.uint16)
    stored = {"basis.rows": numbers, "basis.grid": np.stack([low, step])}
    write_file(path, arch.to_json(), dict(model.params) | stored, header)
    return model


def write_file(
    path: str | os.PathLike, arch: str, params: Params, header: Mapping[str, Any]
) -> None:
    """Write the weights of any system to a file.

    arch: the text of a JSON object; its entry `kind` names another system than Urushi's.
    """
    description = {
        "version": FORMAT_VERSION,
        "architecture": json.loads(arch),
        "header": dict(header),
    }
    files.write_tensors(path, "weights", description, params)


def read(path: str | os.PathLike) -> Model:
    """Read a weights file that `save` wrote; a FileError as of `read_file`."""

    def made(arch: Any, params: dict[str, np.ndarray], header: Mapping[str, Any]) -> Model:
        if "basis.grid" in params:
            low, step = params.pop("basis.grid")
            if "basis.rows" in params:  # else it is missing, as `Model.of` says
                params["basis.rows"] = params["basis.rows"] * step + low
        return Model.of(Architecture(**arch), params, header)

    return read_file(path, KIND, made)


def read_file(
    path: str | os.PathLike,
    kind: str,
    make: Callable[[Any, dict[str, np.ndarray], Mapping[str, Any]], Read],
) -> Read:
    """Read a weights file that `write_file` wrote.

    Args:
        path: the file.
        kind: the system of the weights.
        make: from the architecture's JSON value, the parameters and the header to the result.

    Raises:
        FileError: the file is missing, truncated, foreign, of another version or of another system,
            or its arrays do not fit its architecture.
    """
    description, arrays = files.read_tensors(path, "weights", FORMAT_VERSION)
    arch = description.get("architecture")
    found = arch.get("kind", KIND) if isinstance(arch, dict) else KIND
    if found != kind:
        raise FileError(
            f"'{path}' holds networks of the system '{found}', but those of '{kind}' are needed; "
            f"use the functions, plugins and commands of the system '{found}' for this file"
        )
    try:
        return make(arch, arrays, description.get("header") or {})
    except (ParameterError, TypeError, ValueError) as error:
        raise FileError(f"the weights file '{path}' is damaged: {error}") from error


#: Weights as a user may give them: a Model, a name of shipped ones, or a weights file.
Weights = Model | str | os.PathLike

#: The folder of the shipped weights.
SHIPPED = Path(__file__).with_name("weights")


@functools.cache
def shipped(name: str) -> Model:
    """The shipped weights `DEFAULT` or `ANISOTROPIC`, loaded once per process."""
    path = SHIPPED / f"{name}.safetensors"
    if not path.exists():
        raise FileError(f"Urushi's trained weights '{path}' are missing; install the package again")
    return read(path)


def default_model() -> Model:
    """The shipped weights of isotropic materials."""
    return shipped(DEFAULT)


def anisotropic_model() -> Model:
    """The shipped weights of anisotropic materials."""
    return shipped(ANISOTROPIC)


def check_made_with(path: str | os.PathLike, made_with: object, fingerprint: str) -> None:
    """Refuse a file of codes unless the weights of `fingerprint` made it.

    made_with: the fingerprint in the file.
    """
    if made_with != fingerprint:
        raise FileError(
            f"'{path}' does not match the weights: it was encoded with weights {made_with}, but "
            f"these are {fingerprint}; load those weights or encode the material again"
        )


def model_of_file(path: str | os.PathLike, made_with: object, model: Model | None) -> Model:
    """The weights of a file of codes: `model`, or for None the shipped ones that made it."""
    if model is None:
        other = anisotropic_model()
        model = other if other.fingerprint == made_with else default_model()
    check_made_with(path, made_with, model.fingerprint)
    return model


def find(given: Weights | None) -> Model:
    """The weights that a user gave; the shipped ones for None.

    Raises:
        FileError: there is no such file, or it is damaged.
    """
    if isinstance(given, Model):
        return given
    if given is None or str(given) in (DEFAULT, ANISOTROPIC):
        return shipped(DEFAULT if given is None else str(given))
    path = files.as_path(given)
    files.check_file(
        path, f"there are no weights '{given}'; give a file, or '{DEFAULT}' for the shipped ones"
    )
    state = path.stat()
    return _read_once(str(path.absolute()), state.st_mtime_ns, state.st_size)


@functools.lru_cache(maxsize=8)
def _read_once(path: str, changed: int, size: int) -> Model:
    """A file's weights; the materials of a scene share them, with what they keep."""
    return read(path)
