"""`urushi layer`: coating a material file."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from urushi.app.describe import describe, is_description


@dataclass(frozen=True)
class Layer:
    """Coat a material with a dielectric layer and a medium, in the latent space.

    Each number may be one value, or three for red, green and blue.

    Example: urushi layer gold.safetensors --alpha 0.05 --eta 1.5 --albedo 0.8 --sigma-t 0.2 1 3
    -o lacquered.safetensors
    """

    material: tyro.conf.Positional[str]
    """Material file to coat, or a description as in Python."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Material file to write (.safetensors)."""
    alpha: tuple[float, ...] = (0.05,)
    """GGX width of the coat's surface, in [0.01, 1]."""
    eta: tuple[float, ...] = (1.5,)
    """Its index of refraction relative to the medium above, in (1, 3]."""
    albedo: tuple[float, ...] = (0.0,)
    """Single-scattering albedo of the medium, in [0, 1]."""
    sigma_t: tuple[float, ...] = (0.0,)
    """Optical depth of the medium, zero or more."""
    g: tuple[float, ...] = (0.0,)
    """Henyey-Greenstein asymmetry of the medium, in (-1, 1)."""

    def run(self) -> int:
        import urushi

        top = urushi.dielectric(scalar_or_rgb(self.alpha), scalar_or_rgb(self.eta))
        if is_description(self.material):
            bottom = urushi.encode(describe(self.material))
        else:
            bottom = urushi.load(self.material)
        coated = urushi.layer(
            top,
            bottom,
            albedo=scalar_or_rgb(self.albedo),
            sigma_t=scalar_or_rgb(self.sigma_t),
            g=scalar_or_rgb(self.g),
        )
        coated.save(self.output)
        print(self.output)
        return 0


def scalar_or_rgb(values: tuple[float, ...]) -> Any:
    """One value as a number; several as they are, for the range checks to judge."""
    return values[0] if len(values) == 1 else values
