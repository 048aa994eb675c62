"""`urushi encode` and `urushi layer`: making material files."""

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

import tyro
from tqdm import tqdm

from urushi.app import extras
from urushi.app.describe import describe, is_description
from urushi.errors import FileError, ParameterError, UrushiError
from urushi.files import new_folder


@dataclass(frozen=True)
class Encode:
    """Encode BRDFs into materials: latent codes, one set per colour channel.

    A source is a description as in Python, a measured BRDF (a MERL or an RGL file), or a BSDF of a
    Mitsuba scene file. Several of the first two are encoded in parallel.

    Example: urushi encode "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))" -o gold.safetensors

    Example: urushi encode merl/*.binary -o materials
    """

    sources: tyro.conf.Positional[tuple[str, ...]]
    """conductor(...), coat(...), ... as in Python, measured files, or a Mitsuba scene (.xml)."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """File to write (.safetensors), or the folder for one file of each source."""
    bsdf: str | None = None
    """Which BSDF of the scene file: its id; needed when there are several."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = "llvm_ad_rgb"
    """Mitsuba variant for reading a scene file."""
    scheduler: str | None = None
    """Address of a Dask scheduler whose workers read and simulate; default: this machine."""
    weights: str | None = None
    """Networks: base (the default), small, or a weights file."""
    refine: bool = False
    """Bring codes closer to measured or unusual BRDFs by a few steps of optimisation."""

    def run(self) -> int:
        from urushi.material.batch import encode_all

        if self.scheduler is not None:
            extras.require("cluster")
        targets = self.targets()
        sources = [self.opened(text) for text in self.sources]
        errors = []
        with tqdm(total=len(sources), unit="BRDF", disable=len(sources) == 1 or None) as progress:
            made_all = encode_all(
                sources, model=self.weights, scheduler=self.scheduler, refine=self.refine
            )
            for index, made in made_all:
                if isinstance(made, UrushiError):
                    errors.append(made)
                else:
                    made.save(targets[index])
                    tqdm.write(str(targets[index]))
                progress.update()
        if len(sources) == 1 and errors:
            raise errors[0]
        if errors:
            raise UrushiError(
                f"{len(errors)} of {len(sources)} sources could not be encoded: "
                + "; ".join(map(str, errors))
            )
        return 0

    def targets(self) -> list[Path]:
        """The file that each source is encoded into."""
        if not self.sources:
            raise ParameterError("there is nothing to encode; give a description or a file")
        if self.output.suffix == ".safetensors":
            if len(self.sources) > 1:
                raise ParameterError(
                    f"'{self.output}' is one file for {len(self.sources)} sources; "
                    "give a folder for the materials"
                )
            return [self.output]
        names = [
            f"{text.strip().partition('(')[0]}-{number}"
            if is_description(text)
            else Path(text).stem
            for number, text in enumerate(self.sources, 1)
        ]
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ParameterError(
                f"two of the sources are called '{twice}' and would make the same file; "
                "rename one, or encode it by itself"
            )
        return [new_folder(self.output) / f"{name}.safetensors" for name in names]

    def opened(self, text: str) -> Any:
        """What `encode_all` takes for a source."""
        described = is_description(text)
        scene = not described and Path(text).suffix == ".xml"
        if self.bsdf is not None and not scene:
            raise ParameterError("--bsdf chooses from a scene file; other sources have no BSDFs")
        if described:
            return describe(text)
        if not Path(text).is_file():
            raise FileError(
                f"'{text}' is neither a file nor a description; give a measured BRDF or a Mitsuba "
                'scene file, or write for example "conductor(alpha=0.2, r0=0.9)"'
            )
        if not scene:
            return Path(text).absolute()  # a worker has another working folder
        if len(self.sources) > 1 or self.scheduler is not None:
            raise ParameterError(
                f"'{text}' is a scene file, which is encoded by itself and on this machine; "
                "leave out the other sources and --scheduler"
            )
        return scene_bsdf(Path(text), self.bsdf, self.mode)


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


def scene_bsdf(path: Path, name: str | None, mode: str) -> Any:
    """The BSDF of a scene file that has the id `name`, or its only one.

    Raises:
        FileError: the file is no scene.
        ParameterError: there is no such BSDF, or several and none was named.
    """
    from urushi.app.commands.render import load_scene, set_variant

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
