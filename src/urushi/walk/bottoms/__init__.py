"""Bottoms of stacks, one file each: description, BRDF, sampling, and how training draws it.

Importing this package imports all its files. Each registers its BRDFs in `KINDS` and the function
that describes it in `MAKERS`, so that a new bottom is a new file.
"""

import importlib
import pkgutil

from urushi.walk.bottoms.bottom import KINDS, MAKERS, Bottom, Description, Rough, Value

__all__ = ["KINDS", "MAKERS", "Bottom", "Description", "Rough", "Value"]

for _file in pkgutil.iter_modules(__path__):
    importlib.import_module(f"{__name__}.{_file.name}")
