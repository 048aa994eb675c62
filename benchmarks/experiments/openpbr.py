"""The plugin `openpbr` and OpenPBR's closed forms against walks; white furnaces; and its cost.

The 40 materials of `benchmarks.conformance`; random opaque coated materials over the normal ranges
of OpenPBR's parameters; white materials, which should reflect all of even light; and the processor
time of a render over that of `neural_layered`, both with textures, in one process by turns.
"""

from functools import partial
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks import conformance, spheres, timing
from benchmarks.experiment import BOTH, Experiment, Found, Options
from benchmarks.showing import rounded, table
from research.rivals import openpbr_recipe

from urushi.mitsuba.reading import probing

#: Random materials of each kind, their seed, and the least roughness, of the narrowest lobe.
COUNT, SEED, LEAST_ROUGHNESS = 200, 911, 0.1
#: White materials of a kind, samples of each at the cosines, and the seed.
WHITES, COATED, SAMPLES, FURNACE_SEED = 36, 10, 1 << 15, 3
FURNACE_COSINES = (1.0, 0.6, 0.3, 0.2)
WHITE = {"type": "rgb", "value": [1.0, 1.0, 1.0]}
RANGES = {
    "specular_roughness": (0.0, 1.0),
    "specular_ior": (1.1, 2.5),
    "specular_roughness_anisotropy": (0.0, 0.9),
    "base_diffuse_roughness": (0.0, 1.0),
    "thin_film_ior": (1.2, 2.4),
    "thin_film_thickness": (0.0, 1.0),
    "coat_roughness": (0.0, 1.0),
    "coat_ior": (1.1, 2.5),
}
ROUGH, INDEX, TURNED = "specular_roughness", "specular_ior", "specular_roughness_anisotropy"
METAL, COAT = {"base_metalness": 1.0}, {"coat_weight": 1.0}
#: White materials: parameters that are drawn, and those that stay.
FURNACES: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "dielectric": ((ROUGH, INDEX), {}),
    "metal": ((ROUGH,), METAL),
    "anisotropic dielectric": ((ROUGH, INDEX, TURNED), {}),
    "anisotropic metal": ((ROUGH, TURNED), METAL),
    "rough slab": ((ROUGH, INDEX, "base_diffuse_roughness"), {}),
    "index 0.7": ((ROUGH,), {INDEX: 0.7}),
    "index 0.7, rough slab": ((ROUGH,), {INDEX: 0.7, "base_diffuse_roughness": 1.0}),
    "film": ((ROUGH, "thin_film_ior", "thin_film_thickness"), {"thin_film_weight": 1.0}),
    **{
        f"{by} over {base}": (
            (ROUGH, INDEX, "coat_roughness", "coat_ior"),
            COAT | constants | {"reference": by == "walks"},
        )
        for by in ("codes", "walks")
        for base, constants in (("dielectric", {}), ("metal", METAL))
    },
}


def draw(rng: np.random.Generator, anisotropic: bool) -> dict[str, Any]:
    """Parameters of a material: a third metals, a third dielectrics, a third mixtures."""

    def uniform(low: float, high: float) -> float:
        return float(rng.uniform(low, high))

    material: dict[str, Any] = {
        "base_color": tuple(rng.uniform(0, 1, 3).tolist()),
        "base_diffuse_roughness": uniform(0, 1),
        "base_metalness": (0.0, 1.0, uniform(0, 1))[rng.integers(3)],
        "specular_weight": (1.0, uniform(0, 1))[rng.integers(2)],
        "specular_roughness": uniform(LEAST_ROUGHNESS, 1),
        "specular_ior": uniform(1.2, 2.0),
        "coat_weight": (1.0, uniform(0, 1))[rng.integers(2)],
        "coat_color": tuple(rng.uniform(0.1, 1, 3).tolist()),
        "coat_roughness": uniform(LEAST_ROUGHNESS, 1),
        "coat_ior": uniform(1.2, 2.0),
        "coat_darkening": (1.0, uniform(0, 1))[rng.integers(2)],
    }
    if material["base_metalness"] > 0:
        material["specular_color"] = tuple(rng.uniform(0.5, 1, 3).tolist())
    if anisotropic:
        chosen = rng.integers(1, 4)  # the base, the coat, or both
        for bit, name in enumerate(("specular", "coat")):
            if chosen & (1 << bit):
                material[f"{name}_roughness_anisotropy"] = uniform(0, 0.8)
    return material


def model(name: str, parameters: dict[str, Any]) -> conformance.Brdf:
    """f of the plugin, or of one of the closed forms `openpbr_recipe.RECIPES`."""
    if name == "urushi":
        return conformance.model(parameters)
    return lambda wi, wo: openpbr_recipe.f(parameters, wi, wo, name)


def conforming(name: str, _: Options) -> Found:
    """E and the albedo's error of an implementation for each of the 40 materials."""
    reference = conformance.read()
    found = conformance.errors(conformance.evaluated(partial(model, name), reference), reference)
    noise = rounded(conformance.noise(reference))
    return {"E": rounded(found.error), "albedo": rounded(found.albedo), "noise": noise}


def random(anisotropic: bool, options: Options) -> Found:
    """E, errors of the albedo, and E of the walks' noise, of random materials."""
    rng = np.random.default_rng((SEED, int(anisotropic)))
    drawn = [draw(rng, anisotropic) for _ in range(options.count(COUNT))]
    wi, wo = conformance.pairs()
    f, se = (np.stack(x) for x in zip(*map(conformance.simulate, drawn), strict=True))
    values = np.stack([conformance.model(parameters)(wi, wo) for parameters in drawn])
    names = {str(k): parameters for k, parameters in enumerate(drawn)}
    reference = conformance.Reference(names, wi, wo, f, se)
    found = conformance.errors(values, reference)
    noise = rounded(conformance.noise(reference))
    return {"E": rounded(found.error), "albedo": rounded(found.albedo), "noise": noise}


def furnace(name: str, options: Options) -> list[float]:
    """Reflected shares less one of white materials at `FURNACE_COSINES`: mean, least, greatest."""
    names, constants = FURNACES[name]
    rng, rows = np.random.default_rng(FURNACE_SEED), []
    samples = options.count(SAMPLES, 64)
    index = np.arange(samples)
    u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
    for _ in range(options.count(COATED if "coat_weight" in constants else WHITES)):
        drawn = {key: float(rng.uniform(*RANGES[key])) for key in names}
        bsdf = mi.load_dict({"type": "openpbr", "base_color": WHITE, **drawn, **constants})
        for cosine in FURNACE_COSINES:
            sine = (1 - cosine**2) ** 0.5
            wi = np.tile([sine * np.cos(0.87), sine * np.sin(0.87), cosine], (samples, 1))
            uv = np.full((samples, 2), 0.5)
            si = probing.interaction(wi, uv, np.arange(samples, dtype=np.float32))
            _, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
            rows.append(weight[0].numpy().mean(dtype=np.float64) - 1)
    return rounded([np.mean(rows), np.min(rows), np.max(rows)])


def cost(options: Options) -> float:
    """Time of a render with textures over that of `neural_layered`."""
    colors, rough = spheres.texture(0.3, 0.95, 3, 1, 256), spheres.texture(0.3, 0.6, 1, 2, 256)
    width = spheres.texture(0.09, 0.36, 1, 2, 256)
    metal = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.09}
    bsdfs = {
        "openpbr": {"base_color": colors, "coat_roughness": rough, **METAL, **COAT},
        "neural_layered": {
            "alpha": width,
            "int_ior": 1.6,
            "ext_ior": 1.0,
            "base": metal | {"specular_reflectance": colors},
        },
    }
    scenes = {name: spheres.scene({"type": name, **bsdf}, 256) for name, bsdf in bsdfs.items()}
    operations = {
        name: partial(spheres.seconds, scene, options.count(64), 1)
        for name, scene in scenes.items()
    }
    least = timing.least(operations, 7)
    return rounded(least["openpbr"] / least["neural_layered"], 3)


def cases(_: Options) -> dict[str, Any]:
    found: dict[str, Any] = {
        f"conformance, {name}": partial(conforming, name)
        for name in ("urushi", *openpbr_recipe.RECIPES)
    }
    for kind in (False, True):
        found["anisotropic" if kind else "isotropic"] = partial(random, kind)
    return found | {f"white, {name}": partial(furnace, name) for name in FURNACES} | {"cost": cost}


def tables(found: Found) -> list[str]:
    """Errors of implementations and of random materials, white furnaces, and the cost."""
    errors, whites, made = [], [], []
    for name, case in found.items():
        if isinstance(case, dict):
            e, albedo = 100 * np.array(case["E"]), 100 * np.abs(case["albedo"])
            noise = f"{100 * np.mean(case['noise']):.2f} %"
            cells = [e.mean(), *np.percentile(e, [50, 95]), albedo.mean()]
            errors.append([name, f"{len(e)}", *(f"{x:.2f} %" for x in cells), noise])
        elif isinstance(case, list):
            shares = (f"{100 * x:+.2f} %".replace("-", "−") for x in case)
            whites.append([name.removeprefix("white, "), *shares])
    if errors:
        head = ["materials", "number", "E mean", "median", "p95", "error of the albedo"]
        made.append(table([*head, "noise of the walks"], errors))
    if whites:
        made.append(table(["white materials reflect, less one", "mean", "least", "most"], whites))
    if "cost" in found:
        made.append(
            table(["render", "over `neural_layered`"], [["`openpbr`", f"{found['cost']:g}"]])
        )
    return made


EXPERIMENT = Experiment(
    cases=cases,
    measure=lambda case, options: case(options),
    tables=tables,
    pages=("docs/openpbr.md", "docs/conformance.md"),
    models=BOTH,
    minutes=60,
)
