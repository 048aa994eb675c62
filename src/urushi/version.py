"""The package's version, on the lowest floor so that every file format can record it."""

__version__ = "0.1.0"
