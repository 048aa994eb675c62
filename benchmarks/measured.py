"""Measured materials: files of RGL and MERL, and tables of neural fits that stand in for MERL's."""

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
from benchmarks.measures import Brdf
from benchmarks.rivals import nbrdf

import urushi
from urushi.measured import Merl, load_measured
from urushi.measured.merl import SHAPE
from urushi.measured.tabulated import MeasuredSurface, bin_centres


@dataclass(frozen=True)
class Measured:
    """A measured material.

    Attributes:
        name: name of the material, unique in its set.
        path: a MERL or RGL file, or an archive (.npz) of networks of 675 weights by name. The table
            of the network `name` in MERL's bins stands in for a measured file.
    """

    name: str
    path: Path

    @property
    def kind(self) -> str:
        return {".bsdf": "RGL", ".npz": "stand-in"}.get(self.path.suffix, "MERL")

    def load(self) -> MeasuredSurface:
        """The BRDF, as the walk samples it."""
        if self.path.suffix != ".npz":
            return load_measured(self.path)
        with np.load(self.path) as archive:
            weights = archive[self.name].astype(np.float64)
        angles = (a.ravel() for a in np.broadcast_arrays(*bin_centres(SHAPE)))
        table = nbrdf.unpacked(weights).at(nbrdf.vectors(*angles))
        return Merl(table.reshape(*SHAPE, 3))


def reciprocal(source: Any) -> Brdf:
    """f of a source, averaged over the exchange of wi and wo.

    RGL files are only as reciprocal as their measurement; most methods are exactly reciprocal, and
    an error that none of them can avoid would hide their differences.
    """
    return lambda wi, wo: 0.5 * (source.f(wi, wo) + source.f(wo, wi))


def materials(paths: Sequence[Path]) -> list[Measured]:
    """All materials of files, folders and archives."""
    found: list[Measured] = []
    for path in paths:
        if path.suffix == ".npz":
            with np.load(path) as archive:
                found += [Measured(name, path) for name in archive.files]
        else:
            files = sorted(path.iterdir()) if path.is_dir() else [path]
            found += [Measured(f.stem, f) for f in files if f.suffix in (".binary", ".bsdf")]
    return found


def coated(material: Any, coat: dict, layer: Callable[..., Any] = urushi.layer) -> Any:
    """The material under a coat; layer: of the material's system."""
    medium = {name: value for name, value in coat.items() if name not in ("alpha", "eta")}
    return layer(urushi.dielectric(coat["alpha"], coat["eta"]), material, **medium)
