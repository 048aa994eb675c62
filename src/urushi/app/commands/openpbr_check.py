"""`urushi openpbr-check`: errors of OpenPBR's implementations against random walks."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any
from zipfile import BadZipFile

import numpy as np

from urushi.app.commands.render import set_variant
from urushi.errors import FileError
from urushi.files import new_folder

if TYPE_CHECKING:
    from urushi.openpbr_surface.conformance import Errors, Reference

#: Number of materials that are drawn, and walks for a node of a sphere of the reference.
WORST, SPHERE_WALKS = 6, 4


@dataclass(frozen=True)
class OpenPBRCheck:
    """Compare implementations of OpenPBR with random walks: 40 coated materials.

    Prints E and the error of the albedo, in per cent, of the plugin openpbr and of three closed
    forms after the specification. docs/conformance.md describes the materials and the reference
    file.

    Example: urushi openpbr-check

    Example: urushi openpbr-check --values my_renderer.npz
    """

    values: Path | None = None
    """NPZ file of another renderer: f of shape (40, 300, 3). It is compared instead."""
    pictures: Path | None = None
    """Folder for pictures: spheres of the six materials with the largest E of each."""
    reference: Path | None = None
    """File of the reference. Default: the one that ships."""

    def run(self) -> int:
        from urushi.openpbr_surface import conformance

        if self.values is None:
            set_variant("llvm_ad_rgb")
        reference = conformance.read(self.reference)
        if self.values is not None:
            results = {self.values.stem: conformance.errors(_read(self.values), reference)}
        else:
            results = {}
            for name, build in _models().items():
                f = [build(p)(reference.wi, reference.wo) for p in reference.parameters.values()]
                results[name] = conformance.errors(np.stack(f), reference)
        print(table(reference, results, conformance.noise(reference)))
        if self.pictures is not None and self.values is None:
            folder = new_folder(self.pictures)
            for name, errors in results.items():
                path = folder / f"{name}.png"
                _draw(path, reference, errors, name)
                print(path)
        return 0


def _models() -> dict[str, Any]:
    """The implementations: functions from parameters to f, by name."""
    from urushi.openpbr_surface import conformance, recipe

    def by_recipe(form: recipe.Recipe) -> Any:
        return lambda parameters: lambda wi, wo: recipe.f(parameters, wi, wo, form)

    return {"urushi": conformance.model} | {form: by_recipe(form) for form in recipe.RECIPES}


def table(reference: "Reference", results: "dict[str, Errors]", noise: np.ndarray) -> str:
    """The errors as text: one line for each material, then mean and 95th percentile."""
    heads = "".join(f"{name:>16}" for name in results)
    lines = [
        "E and error of the albedo [%], against random walks",
        f"{'':30}{heads}{'noise':>8}",
    ]
    rows = [
        [(100 * r.error[k], 100 * r.albedo[k]) for r in results.values()] for k in range(len(noise))
    ]
    for name, row, own in zip(reference.parameters, rows, 100 * noise, strict=True):
        lines.append(f"{name:30}{_cells(row)}{own:8.2f}")
    means = [(100 * r.error.mean(), 100 * np.abs(r.albedo).mean()) for r in results.values()]
    highs = [
        (100 * np.percentile(r.error, 95), 100 * np.percentile(np.abs(r.albedo), 95))
        for r in results.values()
    ]
    lines.append(f"{'mean':30}{_cells(means, sign='')}{100 * noise.mean():8.2f}")
    lines.append(f"{'95th percentile':30}{_cells(highs, sign='')}")
    return "\n".join(lines)


def _cells(row: list[tuple[float, float]], sign: str = "+") -> str:
    return "".join(f"{e:8.2f}{a:{sign}8.1f}" for e, a in row)


def _read(path: Path) -> np.ndarray:
    """The array f of an NPZ file."""
    try:
        with path.open("rb") as file, np.load(file, allow_pickle=False) as archive:
            return archive["f"]
    except KeyError as error:
        raise FileError(f"'{path}' must hold the array f; {error.args[0]}") from error
    except (OSError, ValueError, EOFError, TypeError, BadZipFile) as error:
        reason = "it does not exist" if not path.exists() else "it is not an NPZ file"
        raise FileError(f"cannot read '{path}': {reason}; write it with numpy.savez") from error


def _draw(path: Path, reference: "Reference", errors: "Errors", name: str) -> None:
    """Spheres of the worst materials: the walk above, the implementation below."""
    from matplotlib import pyplot as plt

    from urushi.eval import environment, sphere
    from urushi.openpbr_surface import conformance

    light = sphere.exposed(environment.own()[0])
    worst = np.argsort(errors.error)[::-1][:WORST]
    names = list(reference.parameters)
    figure, axes = plt.subplots(2, WORST, figsize=(1.5 * WORST, 3.4), squeeze=False)
    for column, k in enumerate(worst):
        parameters = reference.parameters[names[k]]
        walk = conformance.model(parameters, walks=SPHERE_WALKS)
        for row, f in enumerate((walk, _models()[name](parameters))):
            picture = sphere.render(f, [light])[0]
            place = axes[row][column]
            place.imshow(np.clip(picture, 0, 1) ** (1 / 2.2))
            place.set_xticks([])
            place.set_yticks([])
        title = f"{names[k]}, E {100 * errors.error[k]:.1f} %".replace(", ", ",\n", 1)
        axes[0][column].set_title(title, fontsize=7)
    for row, label in enumerate(("walk", name)):
        axes[row][0].set_ylabel(label, fontsize=8)
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)
