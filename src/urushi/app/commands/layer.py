"""`urushi layer`: a material under a coat."""

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any

import tyro

from urushi.app.describe import describe, is_description
from urushi.checks import DEFAULT_COAT

if TYPE_CHECKING:
    from urushi.material import Material


@dataclass(frozen=True)
class Layer:
    """Coat a material with a rough dielectric interface and a medium, in the latent space.

    Every parameter of the coat is one value, or three for red, green and blue. The defaults make a
    clear coat of glass in air.

    Example: urushi layer gold.safetensors --alpha 0.05 --ior 1.5 --albedo 0.8 --sigma-t 0.2 1 3
    -o lacquered.safetensors
    """

    material: tyro.conf.Positional[str]
    """Material to coat: a material file, a measured BRDF (MERL or RGL), or a description as in
    Python, such as "conductor(alpha=0.2, r0=0.9)"."""
    output: Annotated[Path, tyro.conf.arg(aliases=["-o"])]
    """Material file to write (.safetensors)."""
    alpha: tuple[float, ...] | None = None
    """GGX width (roughness) of the coat's interface, in [0.01, 1]. Default: 0.1."""
    alpha_u: tuple[float, ...] | None = None
    """In place of --alpha: the width along the tangent, the x axis of the directions."""
    alpha_v: tuple[float, ...] | None = None
    """In place of --alpha: the width across the tangent."""
    ior: tuple[float, ...] | None = None
    """Index of refraction of the coat. Default: that of BK7 glass, 1.5046. Coats below it keep
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
    """Weights file of the networks. Default: the shipped ones."""

    def run(self) -> int:
        import urushi

        def given(*names: str) -> dict[str, Any]:
            values = {name: getattr(self, name) for name in names}
            return {name: x if x is None else scalar_or_rgb(x) for name, x in values.items()}

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
    """The material of a file of `urushi encode`, or an encoded description or measured file.

    Raises:
        UrushiError: as of `urushi.load`, `urushi.encode`, `urushi.load_measured` and `describe`.
    """
    import urushi

    if is_description(text):
        return urushi.encode(describe(text), weights, table=False)
    if Path(text).suffix == ".safetensors":
        return urushi.load(text, weights)
    return urushi.encode(urushi.load_measured(text), weights)


def scalar_or_rgb(values: tuple[float, ...]) -> Any:
    """One value as a number; several unchanged: the range checks refuse other counts than three."""
    return values[0] if len(values) == 1 else values
