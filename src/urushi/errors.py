"""Errors that a user can cause, and warnings. Each is one sentence: problem, place, cure."""

from collections.abc import Collection
from difflib import get_close_matches


class UrushiError(Exception):
    """Base of every error that Urushi raises on purpose."""


class ParameterError(UrushiError, ValueError):
    """An argument has the wrong value, shape or type."""


class FileError(UrushiError, OSError):
    """A file is missing, truncated, foreign, inconsistent or cannot be written."""


class PlatformError(UrushiError, RuntimeError):
    """Something that the machine must provide (libLLVM, a package, a device) is missing or
    unsuitable."""


class UrushiWarning(UserWarning):
    """A result may not be what the user intended."""


def choice(name: str, names: Collection[str]) -> str:
    """The cure of a misspelt name, as the end of a sentence."""
    near = get_close_matches(name.lower(), names, 1)
    listed = ", ".join(names) if len(names) <= 24 else "the names in its documentation"
    return f"did you mean {near[0]}?" if near else f"choose one of {listed}"
