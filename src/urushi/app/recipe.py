"""`urushi recipe`: measured paints that give a colour over a ground, checked by the random walk."""

import itertools
from dataclasses import dataclass
from typing import Any

import numpy as np
import tyro

from urushi.core import error_metrics as metrics
from urushi.errors import ParameterError
from urushi.ranges import Walks

#: Parts of a paint in a mixture, and thicknesses of its film (1 is 40 um of dry paint).
PARTS, THICKNESSES = (1, 2, 3, 4, 6, 8, 12, 16), (0.25, 0.5, 1.0, 2.0, 4.0, 8.0)

#: Candidates that are checked by the walk.
CHECKED = 16

#: Direction to the light and to the eye: 45 degrees and the normal, as colours are measured.
LIGHT, EYE = np.array([[0.5**0.5, 0.0, 0.5**0.5]]), np.array([[0.0, 0.0, 1.0]])

#: The varnished surface: smooth, so that no gloss is seen.
SURFACE: dict[str, Any] = {"alpha": 0.02, "ior": 1.5}


@dataclass(frozen=True)
class Recipe:
    """Find paints for a colour: two or three acrylics, their parts, the thickness of the film.

    The paints are `urushi.pigment`'s. The colour is what is seen at the normal, without
    gloss, under light from 45 degrees, through a surface of index 1.5; white is a Lambertian
    reflector. The formula of Kubelka (1948) finds candidates. Random walks choose the best and give
    the colour that is printed, with its distance dE in CIELAB (1976).

    Example: urushi recipe "#7a2f1e" --ground 0.8
    """

    color: tyro.conf.Positional[str]
    """The colour in sRGB: "#7a2f1e"."""
    ground: tuple[float, ...] = (0.8,)
    """Reflectance of the ground under the paint: one linear value, or three, in [0, 1]."""
    walks: Walks = 1 << 16
    """Random walks that check a candidate."""

    def run(self) -> int:
        import urushi

        target = linear(self.color)
        ground = urushi.diffuse(self.ground[0] if len(self.ground) == 1 else self.ground)

        def walked(parts: dict[str, int], thickness: float) -> np.ndarray:
            paint = urushi.pigment(parts)
            film = urushi.coat(ground, **SURFACE, **paint, thickness=thickness)
            return np.pi * urushi.simulate(film, EYE, LIGHT, walks=self.walks)[0][0]

        for count in (2, 3):
            likely = candidates(target, np.broadcast_to(ground.reflectance, 3), count)[:CHECKED]
            colors = [walked(*recipe) for recipe in likely]
            errors = [distance(color, target) for color in colors]
            best = int(np.argmin(errors))
            parts, thickness = likely[best]
            named = ", ".join(f"{part} {name}" for name, part in parts.items())
            print(f"{code(colors[best])}, dE {errors[best]:.1f}: {named}; thickness {thickness:g}")
        return 0


def candidates(
    target: np.ndarray, ground: np.ndarray, count: int
) -> list[tuple[dict[str, int], float]]:
    """Parts and thickness of films of `count` paints, the best by Kubelka's formula first.

    One of each choice of paints, for a target and a ground of reflectance (3,).
    """
    from urushi.measured import pigments  # lazily: it starts Dr.Jit

    ratios = np.array([r for r in itertools.product(PARTS, repeat=count) if np.gcd.reduce(r) == 1])
    found: list[tuple[float, dict[str, int], float]] = []
    for names in itertools.combinations(pigments.paints(), count):
        k, s = (x[:, None] * np.array(THICKNESSES)[:, None] for x in pigments.mixed(names, ratios))
        errors = distance(seen(pigments.over(k, s, ground)), target)
        i, j = np.unravel_index(np.argmin(errors), errors.shape)
        parts = dict(zip(names, ratios[i].tolist(), strict=True))
        found.append((float(errors[i, j]), parts, THICKNESSES[j]))
    return [recipe[1:] for recipe in sorted(found, key=lambda recipe: recipe[0])]


def seen(reflectance: np.ndarray) -> np.ndarray:
    """Colour through the surface of a diffuse reflectance below it (Saunderson 1942)."""
    from urushi.checks import AIR
    from urushi.core import fresnel
    from urushi.core.namespace import NUMPY
    from urushi.openpbr_surface import formulas

    eta = SURFACE["ior"] / AIR
    passed = [1 - fresnel.dielectric(w[0, 2], eta, NUMPY)[0] for w in (LIGHT, EYE)]
    internal = formulas.internal_reflectance(1 - formulas.mean_fresnel(eta), eta)
    return passed[0] * passed[1] / eta**2 * reflectance / (1 - internal * reflectance)


def distance(a: np.ndarray, b: np.ndarray) -> Any:
    """Distance (...) of linear sRGB colours (..., 3) in CIELAB of 1976, under D65."""
    from urushi.measured.rgl import XYZ_TO_SRGB

    def lab(color: np.ndarray) -> np.ndarray:
        to_xyz = np.linalg.inv(XYZ_TO_SRGB)
        share = np.maximum(color @ to_xyz.T / to_xyz.sum(axis=1), 0)
        f = np.where(share > 216 / 24389, np.cbrt(share), (24389 / 27 * share + 16) / 116)
        x, y, z = np.moveaxis(f, -1, 0)
        return np.stack([116 * y, 500 * (x - y), 200 * (y - z)], axis=-1)

    return np.linalg.norm(lab(a) - lab(b), axis=-1)


def linear(text: str) -> np.ndarray:
    """The linear colour (3,) of an sRGB code such as "#7a2f1e"."""
    try:
        digits = bytes.fromhex(text.removeprefix("#"))
    except ValueError:
        digits = b""
    if len(digits) != 3:
        raise ParameterError(f"the colour is '{text}'; give an sRGB code such as '#7a2f1e'")
    encoded = np.array(list(digits)) / 255  # IEC 61966-2-1
    return np.where(encoded <= 0.04045, encoded / 12.92, ((encoded + 0.055) / 1.055) ** 2.4)


def code(color: np.ndarray) -> str:
    """The sRGB code of a linear colour (3,), clipped to [0, 1]."""
    return "#" + bytes(np.round(255 * metrics.shown(color)).astype(np.uint8)).hex()
