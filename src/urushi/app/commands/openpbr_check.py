"""`urushi openpbr-check`: errors of an implementation of OpenPBR against random walks."""

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

import numpy as np

from urushi.app.commands.render import set_variant
from urushi.app.commands.simulate import read_arrays

if TYPE_CHECKING:
    from urushi.openpbr_surface.conformance import Errors, Reference


@dataclass(frozen=True)
class OpenPBRCheck:
    """Compare an implementation of OpenPBR with random walks: 40 coated materials.

    Prints E and the error of the albedo, in per cent, of the plugin openpbr or of another renderer.
    docs/conformance.md describes the materials and the reference file.

    Example: urushi openpbr-check

    Example: urushi openpbr-check --values my_renderer.npz
    """

    values: Path | None = None
    """NPZ file of another renderer: f of shape (40, 300, 3). It is compared instead."""
    reference: Path | None = None
    """File of the reference. Default: the one that ships."""

    def run(self) -> int:
        from urushi.openpbr_surface import conformance

        if self.values is None:
            set_variant("llvm_ad_rgb")
        reference = conformance.read(self.reference)
        if self.values is None:
            name, f = "urushi", conformance.evaluated(conformance.model, reference)
        else:
            name, (f,) = self.values.stem, read_arrays(self.values, "f")
        print(table(reference, {name: conformance.errors(f, reference)}))
        return 0


def table(reference: "Reference", results: "Mapping[str, Errors]") -> str:
    """The errors as text: one line for each material, then mean and 95th percentile."""
    from urushi.openpbr_surface import conformance

    noise = 100 * conformance.noise(reference)
    error, albedo = (
        np.array([100 * getattr(r, name) for r in results.values()]) for name in ("error", "albedo")
    )
    heads = "".join(f"{name:>16}" for name in results)
    lines = [
        "E and error of the albedo [%], against random walks",
        f"{'':30}{heads}{'noise':>8}",
    ]
    for k, name in enumerate(reference.parameters):
        lines.append(f"{name:30}{_cells(error[:, k], albedo[:, k], '+')}{noise[k]:8.2f}")
    albedo = np.abs(albedo)
    lines.append(f"{'mean':30}{_cells(error.mean(1), albedo.mean(1))}{noise.mean():8.2f}")
    highs = (np.percentile(x, 95, axis=1) for x in (error, albedo))
    return "\n".join([*lines, f"{'95th percentile':30}{_cells(*highs)}"])


def _cells(errors: np.ndarray, albedos: np.ndarray, sign: str = "") -> str:
    return "".join(f"{e:8.2f}{a:{sign}8.1f}" for e, a in zip(errors, albedos, strict=True))
