"""The networks that ship with Urushi, by name, and those that are used when none are named."""

import functools
import os
from pathlib import Path

from urushi.errors import FileError
from urushi.nets import weights
from urushi.nets.weights import Model

#: Files in the folder `weights` beside this module, the default first.
NAMES = ("base", "small")

#: Networks as users may give them: a Model, one of `NAMES`, or a weights file.
Weights = Model | str | os.PathLike


def folder() -> Path:
    """Where the shipped weights lie."""
    return Path(__file__).with_name("weights")


@functools.cache
def load(name: str) -> Model:
    """Load the shipped networks of a name, once a process.

    Raises:
        FileError: they are missing from this installation, or damaged.
    """
    path = folder() / f"{name}.safetensors"
    if not path.exists():
        raise FileError(
            f"Urushi's trained weights '{path}' are missing; install the package again, "
            f"or make them with 'urushi train --preset {name}'"
        )
    return weights.load(path)


def default_model() -> Model:
    """The networks that are used when none are named.

    Raises:
        FileError: as of `load`.
    """
    return load(NAMES[0])


def find(given: Weights | None) -> Model:
    """The networks that a user means; None: the default ones.

    Raises:
        FileError: there is no such file, and no shipped networks of that name.
    """
    if isinstance(given, Model):
        return given
    if given is None:
        return default_model()
    if str(given) in NAMES:
        return load(str(given))
    if not Path(given).exists():
        raise FileError(
            f"there are no weights '{given}'; give a file, or one of {', '.join(NAMES)}"
        )
    return weights.load(given)
