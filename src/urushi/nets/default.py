"""The networks that are used when none are named."""

import functools
from pathlib import Path

from urushi.errors import FileError
from urushi.nets import weights

#: The file in the folder `weights` beside this module.
DEFAULT_WEIGHTS = "quick.safetensors"


def default_path() -> Path:
    """Return where the shipped weights lie, present or not."""
    return Path(__file__).with_name("weights") / DEFAULT_WEIGHTS


@functools.cache
def default_model() -> weights.Model:
    """Load the shipped networks, once a process.

    Raises:
        FileError: they are missing from this installation, or damaged.
    """
    if not default_path().exists():
        raise FileError(
            f"Urushi's trained weights '{default_path()}' are missing; install the package again, "
            "or make them with 'urushi train --preset quick'"
        )
    return weights.load(default_path())
