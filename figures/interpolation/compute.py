"""Ways from one coated metal to another: in the latent space, of the BRDFs, and of the parameters.

    python -m figures.interpolation.compute

The reference is the exact blend of the two ends, (1 - t) f_a + t f_b, by the walk. E against it is
measured at pairs of directions for `urushi.lerp`, for linear blends of the codes as in Fan et al.
(2022), and for the stack whose parameters are blended, also by the walk.
"""

import functools
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any, NamedTuple

import mitsuba as mi
import numpy as np

import urushi
from figures import results
from figures.sphere import render
from urushi.core import direction_sets
from urushi.core.error_metrics import stack_error
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("interpolation")
SHARES = (0.0, 0.25, 0.5, 0.75, 1.0)
#: Pixels of a sphere, samples of a pixel, and pairs and walks for E.
SIZE, SAMPLES, PAIRS, WALKS = 96, 192, 300, 1 << 14
SEED = 9

RGB = tuple[float, float, float]


class Coated(NamedTuple):
    """A coat of index 1.5 over a metal: GGX widths, the medium, and the metal's reflectance."""

    alpha: float
    albedo: RGB
    sigma_t: RGB
    bottom_alpha: float
    r0: RGB


GOLD, COPPER, SILVER = (1.0, 0.78, 0.34), (0.95, 0.64, 0.54), (0.97, 0.96, 0.92)
CLEAR: dict[str, RGB] = {"albedo": (0.0, 0.0, 0.0), "sigma_t": (0.0, 0.0, 0.0)}
ENDS = {
    "colour": (
        Coated(0.1, (0.9, 0.15, 0.05), (0.6, 1.5, 2.0), 0.2, GOLD),
        Coated(0.1, (0.1, 0.4, 0.9), (2.0, 1.5, 0.6), 0.2, SILVER),
    ),
    "depth": (
        Coated(0.1, (0.9, 0.9, 0.9), (0.0, 0.0, 0.0), 0.2, GOLD),
        Coated(0.1, (0.9, 0.9, 0.9), (4.0, 4.0, 4.0), 0.2, GOLD),
    ),
    "roughness": (
        Coated(0.05, **CLEAR, bottom_alpha=0.1, r0=COPPER),
        Coated(0.4, **CLEAR, bottom_alpha=0.5, r0=COPPER),
    ),
}
METHODS = ("lerp", "linear in the codes", "parameters")
REFERENCE = "BRDFs"


def main() -> None:
    """Compute what is missing and write results.json."""
    mi.set_variant("llvm_ad_rgb")
    found = results.collect(PARTS, {name: functools.partial(part, name) for name in ENDS})
    head = {"weights": default_model().fingerprint}
    results.write(FOLDER / "results.json", {**head, "ways": found})


def part(name: str) -> dict[str, Any]:
    """Errors of one way; its spheres are written as `NAME.npz`, rows of methods by columns."""
    found = errors(*ENDS[name])
    results.write_pictures(PARTS / f"{name}.npz", pictures(*ENDS[name]))
    return found


def errors(a: Coated, b: Coated, walks: int = WALKS) -> dict[str, Any]:
    """Of each method, E and the relative difference of reflected light, by share of b.

    `noise` holds E of one standard error of the reference.
    """
    rng = np.random.default_rng(SEED)
    wi, wo = direction_sets.cosine_pairs(rng, PAIRS, lowest_cosine=0.02)
    (f_a, se_a), (f_b, se_b) = (simulated(end, wi, wo, walks, i) for i, end in enumerate((a, b)))
    ends = material(a), material(b)
    found: dict[str, Any] = {name: {"E": [], "light": []} for name in METHODS}
    noise = []
    for number, t in enumerate(SHARES):
        exact = (1 - t) * f_a + t * f_b
        values = {
            "lerp": urushi.lerp(*ends, t).f(wi, wo),
            "linear in the codes": linear(*ends, t).f(wi, wo),
            "parameters": simulated(between(a, b, t), wi, wo, walks, 2 + number)[0],
        }
        for name, f in values.items():
            found[name]["E"].append(_e(f, exact, wi, wo))
            weight = (wi[:, 2] * wo[:, 2])[:, None]
            found[name]["light"].append(float((f * weight).sum() / (exact * weight).sum() - 1))
        spread = np.sqrt(((1 - t) * se_a) ** 2 + (t * se_b) ** 2)
        noise.append(_e(exact + spread, exact, wi, wo))
    for name in METHODS:
        found[name] = {key: results.rounded(x) for key, x in found[name].items()}
    return found | {"noise": results.rounded(np.array(noise))}


def _e(f: np.ndarray, exact: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    return float(stack_error(f.T, exact.T, wi[:, 2], wo[:, 2]).mean())


def between(a: Coated, b: Coated, t: float) -> Coated:
    """The stack with blended parameters."""
    both = zip(a, b, strict=True)
    mixed = [((1 - t) * np.asarray(x) + t * np.asarray(y)).tolist() for x, y in both]
    return Coated(*mixed)


def simulated(
    stack: Coated, wi: np.ndarray, wo: np.ndarray, walks: int, seed: int
) -> tuple[np.ndarray, np.ndarray]:
    """f (n, 3) by the walk, and its standard error."""
    base = urushi.conductor(alpha=stack.bottom_alpha, r0=stack.r0)
    medium = {"sigma_t": stack.sigma_t, "albedo": stack.albedo}
    coated = urushi.coat(base, stack.alpha, 1.5, **medium)
    return urushi.simulate(coated, wi, wo, walks=walks, seed=SEED + seed)


def material(stack: Coated) -> urushi.Material:
    """The stack by the networks."""
    top = urushi.dielectric(alpha=stack.alpha, eta=1.5)
    base = urushi.conductor(alpha=stack.bottom_alpha, r0=stack.r0)
    return urushi.layer(top, base, sigma_t=stack.sigma_t, albedo=stack.albedo)


def linear(a: urushi.Material, b: urushi.Material, t: float) -> urushi.Material:
    """The blend of the codes themselves."""
    return urushi.Material(np.float32((1 - t) * a.latents + t * b.latents), a.model)


def pictures(a: Coated, b: Coated) -> dict[str, np.ndarray]:
    """Spheres (shares, SIZE, SIZE, 3) of each method and of the reference."""
    ends = material(a), material(b)
    found: dict[str, list[np.ndarray]] = {name: [] for name in (*METHODS, REFERENCE)}
    with TemporaryDirectory() as folder:
        for t in SHARES:
            for name, blend in (("lerp", urushi.lerp), ("linear in the codes", linear)):
                path = Path(folder) / f"{name} {t}.safetensors"
                blend(*ends, t).save(path)
                found[name].append(_sphere({"type": "neural_brdf", "filename": str(path)}))
            found["parameters"].append(_sphere(_walk(between(a, b, t))))
            blended = {"type": "blendbsdf", "weight": t, "a": _walk(a), "b": _walk(b)}
            found[REFERENCE].append(_sphere(blended))
    return {name: np.array(spheres) for name, spheres in found.items()}


def _sphere(bsdf: dict[str, Any]) -> np.ndarray:
    return render(bsdf, SIZE, SAMPLES, SEED)


def _walk(stack: Coated) -> dict[str, Any]:
    def rgb(value: RGB) -> dict[str, Any]:
        return {"type": "rgb", "value": list(value)}

    return {
        "type": "layered",
        "alpha": stack.alpha,
        "int_ior": 1.5,
        "ext_ior": 1.0,
        "albedo": rgb(stack.albedo),
        "sigma_t": rgb(stack.sigma_t),
        "bottom": {
            "type": "roughconductor",
            "distribution": "ggx",
            "alpha": stack.bottom_alpha,
            "material": "none",
            "specular_reflectance": rgb(stack.r0),
        },
    }


if __name__ == "__main__":
    main()
