"""`urushi encode` and `urushi layer`: making material files."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro

from urushi.errors import FileError, ParameterError


@dataclass(frozen=True)
class Encode:
    """Encode a BRDF into a material: latent codes, one set per colour channel.

    The source is a description as in Python, or a BSDF of a Mitsuba scene file.

    Example: urushi encode "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))" -o gold.safetensors
    """

    source: tyro.conf.Positional[str]
    """conductor(...), coat(...), ... as in Python, or a Mitsuba scene file (XML)."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Material file to write (.safetensors)."""
    bsdf: str | None = None
    """Which BSDF of the scene file: its id; needed when there are several."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant for reading a scene file."""

    def run(self) -> int:
        import urushi
        from urushi.app.describe import describe, is_description

        if is_description(self.source):
            if self.bsdf is not None:
                raise ParameterError("--bsdf chooses from a scene file; a description has no BSDFs")
            source = describe(self.source)
        else:
            source = scene_bsdf(Path(self.source), self.bsdf, self.mode)
        urushi.encode(source).save(self.output)
        print(self.output)
        return 0


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
        from urushi.app.describe import describe, is_description

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


def scene_bsdf(path: Path, name: str | None, mode: str) -> Any:
    """The BSDF of a scene file that has the id `name`, or its only one.

    Raises:
        FileError: the file is missing or no scene.
        ParameterError: there is no such BSDF, or several and none was named.
    """
    from urushi.app.commands.render import load_scene, set_variant

    if not path.is_file():
        raise FileError(
            f"'{path}' is neither a file nor a description; give a Mitsuba scene file, or write "
            'for example "conductor(alpha=0.2, r0=0.9)"'
        )
    set_variant(mode)
    scene = load_scene(path, {})
    found = {shape.bsdf().id(): shape.bsdf() for shape in scene.shapes() if shape.bsdf()}
    names = ", ".join(sorted(found)) or "none"
    if name is None and len(found) == 1:
        return next(iter(found.values()))
    if name is None:
        raise ParameterError(f"'{path}' has {len(found)} BSDFs; name one by --bsdf: {names}")
    if name not in found:
        raise ParameterError(f"'{path}' has no BSDF '{name}' on a shape; it has: {names}")
    return found[name]
