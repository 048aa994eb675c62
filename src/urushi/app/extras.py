"""Packages that only some commands need."""

import importlib

from urushi.errors import PlatformError

#: The extras of the package and what each brings.
EXTRAS = {
    "train": ("jax", "optax", "zarr"),
    "cluster": ("distributed",),
    "eval": ("matplotlib",),
}


def require(extra: str) -> None:
    """Raise PlatformError unless the packages of an extra can be imported."""
    for package in EXTRAS[extra]:
        try:
            importlib.import_module(package)
        except ImportError as error:
            raise PlatformError(
                f"this command needs the package '{package}'; pip install 'urushi[{extra}]'"
            ) from error
