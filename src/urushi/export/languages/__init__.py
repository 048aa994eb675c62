"""Printers of programs, one for each language."""

from urushi.export.languages.glsl import Glsl
from urushi.export.languages.hlsl import Hlsl, Slang
from urushi.export.languages.osl import Osl
from urushi.export.languages.printer import Printer
from urushi.export.languages.python import Python
from urushi.export.languages.wgsl import Wgsl

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
