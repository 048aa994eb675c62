"""Errors that a user can cause, and warnings. Each is one sentence: problem, place, cure."""


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
