"""Printers of programs, one for each language."""

from urushi.export.languages.printer import Printer
from urushi.export.languages.python import Python
from urushi.export.languages.shading import Glsl, Hlsl, Osl, Slang, Wgsl

#: The printers by the names of their languages.
LANGUAGES: dict[str, type[Printer]] = {
    "glsl": Glsl,
    "wgsl": Wgsl,
    "hlsl": Hlsl,
    "slang": Slang,
    "osl": Osl,
    "python": Python,
}

__all__ = ["LANGUAGES", "Printer"]
