"""`urushi encode` and `urushi layer`: material files, and materials under a coat."""

import functools
import sys
from collections.abc import Callable, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro
from tqdm import tqdm

from urushi.app.describe import describe, is_description
from urushi.checks import DEFAULT_COAT
from urushi.errors import ParameterError, UrushiError
from urushi.files import SUFFIX, check_file, new_folder, tensor_file_kind

if TYPE_CHECKING:
    from urushi.material import Material

#: Mitsuba's variant in which scenes are read.
MODE = "llvm_ad_rgb"


@dataclass(frozen=True)
class Encode:
    """Encode BRDFs into material files: one latent code per colour channel.

    A source is a description as in Python, a measured BRDF (a MERL or an RGL file), or a BSDF of a
    Mitsuba scene file: SCENE.xml#ID, or SCENE.xml if it has only one. If one of several sources
    cannot be encoded, the others still are.

    Example: urushi encode "conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))" -o gold.safetensors

    Example: urushi encode merl/*.binary -o materials
    """

    sources: tyro.conf.Positional[tuple[str, ...]]
    """What to encode: descriptions such as "conductor(alpha=0.2, r0=0.9)", measured files, or
    SCENE.xml#ID."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Material file to write (.safetensors), or a folder that gets one file per source."""
    table: bool = False
    """Store a table of f with every material, by which it is evaluated. Default: automatic, with
    all materials of one width but those whose codes are exact."""
    no_table: bool = False
    """Store no table."""
    mode: Annotated[str, tyro.conf.arg(aliases=["-m"])] = MODE
    """Mitsuba variant for reading scene files."""
    weights: str | None = None
    """Weights file. Default: the shipped ones."""

    def run(self) -> int:
        from urushi.material.layer import encoded, warn_of

        if self.table and self.no_table:
            raise ParameterError("--table and --no-table are both given; give one of them, or none")
        targets, several, failures = self.targets(), len(self.sources) > 1, 0
        table = True if self.table else False if self.no_table else None
        bsdfs = functools.cache(functools.partial(scene_bsdfs, mode=self.mode))
        bar = tqdm(self.sources, unit="BRDF", disable=None if several else True)
        for name, target in zip(bar, targets, strict=True):
            try:
                material, deviations = encoded(opened(name, bsdfs), self.weights, table)
            except UrushiError as error:
                if not several:
                    raise
                failures += 1
                tqdm.write(f"urushi: {error}", file=sys.stderr)  # above the progress bar
                continue
            warn_of(deviations, name)
            material.save(target)
            tqdm.write(str(target))
        if failures:
            raise UrushiError(f"{failures} of {len(targets)} sources could not be encoded")
        return 0

    def targets(self) -> list[Path]:
        """The file to write for each source."""
        if not self.sources:
            raise ParameterError("there is nothing to encode; give a description or a file")
        if self.output.suffix == ".safetensors":
            if len(self.sources) > 1:
                raise ParameterError(
                    f"'{self.output}' is one file, but there are {len(self.sources)} sources; "
                    "give a folder for the materials"
                )
            return [self.output]
        if self.output.suffix and not self.output.is_dir():
            raise ParameterError(
                f"--output is '{self.output}', which ends neither in .safetensors nor is a folder; "
                "give a file of that kind, or a folder's name without a suffix"
            )
        names = []
        for number, text in enumerate(self.sources, 1):
            path, bsdf = scene_and_bsdf(text)
            if is_description(text):
                names.append(f"{text.strip().partition('(')[0]}-{number}")
            else:
                names.append(path.stem if bsdf is None else bsdf.replace("/", "-"))
        twice = next((name for name in names if names.count(name) > 1), None)
        if twice is not None:
            raise ParameterError(
                f"two of the sources are called '{twice}' and would be written to the same file; "
                "rename one, or encode it separately"
            )
        return [new_folder(self.output) / f"{name}.safetensors" for name in names]


def scene_and_bsdf(text: str) -> tuple[Path, str | None]:
    """The path of a source, and the BSDF's id if it is written SCENE.xml#ID."""
    path, mark, bsdf = text.rpartition("#")
    if mark and path.endswith(".xml"):
        return Path(path), bsdf
    return Path(text), None


def scene_bsdfs(path: Path, mode: str = MODE) -> list[Any]:
    """The different BSDFs of a scene's shapes; `mode`: the Mitsuba variant."""
    from urushi.app.render import load_scene, set_variant

    set_variant(mode)
    bsdfs = [shape.bsdf() for shape in load_scene(path, {}).shapes() if shape.bsdf()]
    return list({id(bsdf): bsdf for bsdf in bsdfs}.values())


def choose(bsdfs: Sequence[Any], name: str | None, path: Path) -> Any:
    """The BSDF with the id `name`, or the only one if `name` is None."""
    if not bsdfs:
        raise ParameterError(f"'{path}' has no BSDF on a shape; give a scene with one")
    by_id = {bsdf.id(): bsdf for bsdf in bsdfs if bsdf.id()}
    names = ", ".join(sorted(by_id)) or "none"
    if len(by_id) < len(bsdfs):
        names += "; give the others an id in the file to select them"
    if name is None and len(bsdfs) == 1:
        return bsdfs[0]
    if name is None:
        raise ParameterError(
            f"'{path}' has {len(bsdfs)} BSDFs; select one by '{path}#ID' with an ID from: {names}"
        )
    if name not in by_id:
        raise ParameterError(f"'{path}' has no BSDF '{name}' on a shape; it has: {names}")
    return by_id[name]


def opened(text: str, bsdfs: Callable[[Path], Sequence[Any]] = scene_bsdfs) -> Any:
    """What `urushi.encode` takes: a description, a measured BRDF or a BSDF of a scene.

    bsdfs: as of `scene_bsdfs`.
    """
    from urushi.measured import load_measured

    if is_description(text):
        return describe(text)
    path, name = scene_and_bsdf(text)
    check_file(
        path,
        f"'{path}' is neither a file nor a description; give a measured BRDF or a Mitsuba scene "
        'file, or write for example "conductor(alpha=0.2, r0=0.9)"',
    )
    return choose(bsdfs(path), name, path) if path.suffix == ".xml" else load_measured(path)


@dataclass(frozen=True)
class Layer:
    """Coat a material with a rough dielectric interface and a medium.

    Every parameter of the coat is one value, or three for red, green and blue. The defaults make a
    clear coat of glass in air.

    Example: urushi layer gold.safetensors --alpha 0.05 --ior 1.5 --albedo 0.8 --sigma-t 0.2 1 3
    -o lacquered.safetensors
    """

    material: tyro.conf.Positional[str]
    """Material to coat: a material file, a measured BRDF (MERL or RGL), a BSDF of a Mitsuba scene
    file, SCENE.xml#ID, or a description as in Python, such as "conductor(alpha=0.2, r0=0.9)"."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Material file to write (.safetensors)."""
    alpha: tuple[float, ...] | None = None
    """GGX width (roughness) of the coat's interface, in [0.01, 1]. Default: 0.1."""
    alpha_u: tuple[float, ...] | None = None
    """In place of --alpha: the width along the tangent, the x axis of the directions."""
    alpha_v: tuple[float, ...] | None = None
    """In place of --alpha: the width across the tangent."""
    ior: tuple[float, ...] | None = None
    """Index of refraction of the coat. Default: BK7 glass, 1.5046. Coats below it keep
    theirs."""
    eta: tuple[float, ...] | None = None
    """In place of --ior: its ratio to the index of the medium above, in [0.5, 3]."""
    albedo: tuple[float, ...] | None = None
    """Single-scattering albedo of the medium inside the coat, in [0, 1]. Default: 0."""
    sigma_t: tuple[float, ...] | None = None
    """Optical depth of the medium, 0 to 1e6. Default: 0, a clear coat."""
    color: tuple[float, ...] | None = None
    """In place of --albedo and --sigma-t: the colour of a clear coat, in [0, 1], which it transmits
    twice at normal incidence, at thickness 1."""
    body: tuple[float, ...] | None = None
    """With or without --color: opacity of a paint's pigment at thickness 1, in [0, 1]. Default: 1
    with --body-color, otherwise 0."""
    body_color: tuple[float, ...] | None = None
    """Diffuse reflectance of the pigment where it is opaque, in [0, 1]. Default: 0.8."""
    thickness: float = 1.0
    """Factor of the optical depth, zero or more."""
    g: tuple[float, ...] = (DEFAULT_COAT.g,)
    """Henyey-Greenstein asymmetry of the medium, in (-1, 1): above 0 it scatters forwards."""
    weights: str | None = None
    """Weights file. Default: the shipped ones."""

    def run(self) -> int:
        import urushi

        def given(*names: str) -> dict[str, Any]:
            """One value as a number; other counts than one and three are refused later."""
            values = {name: getattr(self, name) for name in names}
            return {k: x[0] if x is not None and len(x) == 1 else x for k, x in values.items()}

        coated = urushi.layer(
            urushi.dielectric(**given("alpha", "alpha_u", "alpha_v", "ior", "eta")),
            read_material(self.material, self.weights),
            **given("albedo", "sigma_t", "g", "color", "body", "body_color"),
            thickness=self.thickness,
        )
        coated.save(self.output)
        print(self.output)
        return 0


def read_material(text: str, weights: str | None) -> "Material":
    """The material of a file of `urushi encode`, or of one of its sources."""
    import urushi

    if not is_description(text) and (Path(text).suffix == SUFFIX or tensor_file_kind(text)):
        return urushi.load(text, weights)
    return urushi.encode(opened(text), weights)
