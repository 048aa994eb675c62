"""OpenPBR's closed forms against random walks: `python -m benchmarks.rivals.openpbr_recipes`.

Prints the table of `benchmarks.quality.conformance` for the plugin `openpbr` and for the forms of
`research.rivals.openpbr_recipe`. With `--pictures DIR` it draws, for each of them, spheres of the
six materials with the largest E.
"""

import argparse
from functools import partial
from pathlib import Path

import mitsuba as mi
import numpy as np
from benchmarks.quality import conformance, sphere
from benchmarks.quality.conformance import Brdf, Errors, Reference
from matplotlib import pyplot as plt
from research.rivals import openpbr_recipe

from urushi.files import new_folder

#: Number of materials that are drawn, and walks for a node of a sphere of the reference.
WORST, SPHERE_WALKS = 6, 4


def _recipe(parameters: dict, form: openpbr_recipe.Recipe) -> Brdf:
    return lambda wi, wo: openpbr_recipe.f(parameters, wi, wo, form)


#: The implementations by name: from parameters to f.
MODELS = {"urushi": conformance.model} | {
    form: partial(_recipe, form=form) for form in openpbr_recipe.RECIPES
}


def draw(path: Path, reference: Reference, errors: Errors, name: str) -> None:
    """Spheres of the worst materials: the walk above, the implementation below."""
    light = sphere.exposed(sphere.own_environments()[0])
    names = list(reference.parameters)
    figure, axes = plt.subplots(2, WORST, figsize=(1.5 * WORST, 3.4), squeeze=False)
    for column, k in enumerate(np.argsort(errors.error)[::-1][:WORST]):
        parameters = reference.parameters[names[k]]
        walk = conformance.model(parameters, walks=SPHERE_WALKS)
        for place, f in zip(axes[:, column], (walk, MODELS[name](parameters)), strict=True):
            place.imshow(np.clip(sphere.render(f, [light])[0], 0, 1) ** (1 / 2.2))
            place.set(xticks=[], yticks=[])
        title = f"{names[k]}, E {100 * errors.error[k]:.1f} %".replace(", ", ",\n", 1)
        axes[0, column].set_title(title, fontsize=7)
    for place, label in zip(axes[:, 0], ("walk", name), strict=True):
        place.set_ylabel(label, fontsize=8)
    figure.tight_layout(pad=0.3)
    figure.savefig(path, dpi=110)
    plt.close(figure)


def main() -> None:
    """Print the table, and draw the pictures if a folder is given."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--pictures", type=Path, help="folder for pictures")
    folder = parser.parse_args().pictures
    mi.set_variant("llvm_ad_rgb")
    reference = conformance.read()
    results = {
        name: conformance.errors(conformance.evaluated(build, reference), reference)
        for name, build in MODELS.items()
    }
    print(conformance.table(reference, results))
    for name, errors in results.items() if folder else ():
        draw(new_folder(folder) / f"{name}.png", reference, errors, name)


if __name__ == "__main__":
    main()
