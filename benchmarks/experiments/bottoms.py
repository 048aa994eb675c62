"""Coats over all bottoms of Mitsuba, `neural_layered` against the random walk of `layered`.

Relative errors for red, green and blue. The albedo's error is the largest of those at the cosines
`COSINES`; both plugins are evaluated at the same sampled directions, and an albedo below `DARK`
counts as `DARK`. E is that of `PAIRS` pairs of cosine density and `REPEATS` walks each, less the
noise of the walk. "codes" are those of the worst coat whose width is a texture.
"""

from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np
from benchmarks.experiment import BOTH, Experiment, Found, Options
from benchmarks.measures import bsdf_values, stack_error
from benchmarks.showing import table
from gallery.stage import conductor, rgb

import urushi  # noqa: F401  (registers the plugins)
from urushi.core import direction_sets
from urushi.errors import UrushiError
from urushi.mitsuba.reading import probing

#: Cosines of the albedos, walks for each of them, and the least divisor of an error.
COSINES, WALKS, DARK = (1.0, 0.85, 0.6, 0.3), 1 << 17, 0.02

#: Pairs of E, and walks for each.
PAIRS, REPEATS = 192, 2048

SCATTERING = {"int_ior": 1.4, "albedo": rgb(0.95, 0.85, 0.7), "sigma_t": 1.0, "g": 0.3}
COATS: dict[str, dict[str, Any]] = {
    "clear smooth": {"alpha": 0.03},
    "clear rough": {"alpha": 0.3},
    "tinted": {"alpha": 0.1, "sigma_t": rgb(0.1, 0.4, 1.2)},
    "scattering": {"alpha": 0.1, **SCATTERING},
}

GREEN, ORANGE = rgb(0.1, 0.6, 0.2), rgb(0.8, 0.35, 0.05)
GOLD = conductor("Au", 0.15)
LEAF = {"type": "diffuse", "reflectance": GREEN}
PLASTIC = {"diffuse_reflectance": ORANGE, "alpha": 0.1}
LACQUER = {"base_color": GREEN, "roughness": 0.5, "clearcoat": 1.0, "clearcoat_gloss": 0.9}
CLOTH = {"base_color": GREEN, "roughness": 0.7, "sheen": 1.0, "sheen_tint": 0.5}
#: In the place of a texture of one tilted normal, which needs a variant.
TILTED = object()

#: The bottoms: all opaque BSDFs of Mitsuba 3.9, its wrappers, and Urushi's own; a plugin's name,
#: with what is varied in parentheses, and its parameters.
BOTTOMS: dict[str, dict[str, Any]] = {
    name: {"type": name.split(" (")[0], **parameters}
    for name, parameters in {
        "diffuse": {"reflectance": ORANGE},
        "conductor": {"material": "Au"},
        "roughconductor": GOLD,
        "roughconductor (beckmann)": GOLD | {"distribution": "beckmann"},
        "roughconductor (.05, .3)": conductor("Au", (0.05, 0.3)),
        "plastic": {"diffuse_reflectance": ORANGE},
        "roughplastic": PLASTIC,
        "roughplastic (ggx, .3)": {
            "diffuse_reflectance": GREEN, "distribution": "ggx", "alpha": 0.3, "nonlinear": True,
        },
        "pplastic": PLASTIC,
        "pplastic (.05)": {"diffuse_reflectance": GREEN, "alpha": 0.05},
        "principled": {"base_color": ORANGE, "roughness": 0.4, "specular": 0.5},
        "principled (metal)": {"base_color": ORANGE, "metallic": 0.8, "roughness": 0.3},
        "principled (cloth)": CLOTH,
        "principled (lacquer)": LACQUER,
        "blendbsdf": {"weight": 0.4, "a": LEAF, "b": GOLD},
        "twosided": {"a": {"type": "roughplastic", "diffuse_reflectance": GREEN, "alpha": 0.2}},
        "bumpmap": {"a": TILTED, "b": LEAF},
        "normalmap": {"normalmap": TILTED, "b": LEAF},
        "mask": {"opacity": 0.5, "a": {"type": "diffuse"}},
        "null": {},
        "dielectric": {},
        "hair": {},
        "openpbr": {"base_color": GREEN, "specular_roughness": 0.3},
        "openpbr (glossy)": {"base_color": ORANGE, "specular_roughness": 0.15},
        "openpbr (metal)": {
            "base_color": ORANGE, "base_metalness": 1.0, "specular_roughness": 0.4,
        },
        "layered": {"alpha": 0.2, "a": LEAF},
        "neural_layered": {"alpha": 0.2, "a": LEAF},
    }.items()
}  # fmt: skip


def texture(texels: np.ndarray) -> dict[str, Any]:
    """Texels (H, W, C) without filter."""
    data = mi.TensorXf(np.asarray(texels, np.float32))
    return {"type": "bitmap", "raw": True, "filter_type": "nearest", "data": data}


def albedo_errors(walk: "mi.BSDF", neural: "mi.BSDF") -> np.ndarray:
    """Relative errors (A, 3) of the albedos at `COSINES`."""
    rng, errors = np.random.default_rng(0), []
    for cosine in COSINES:
        wi = np.tile([np.sqrt(1 - cosine * cosine), 0, cosine], (WALKS, 1)).astype(np.float32)
        times = np.arange(WALKS, dtype=np.float32)
        si = probing.interaction(wi, np.full((WALKS, 2), 0.5), times)
        u = rng.random((3, WALKS), np.float32)
        sample, _ = walk.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1:]))
        pdf = np.broadcast_to(sample.pdf.numpy(), WALKS)
        wo = np.ascontiguousarray(np.array(sample.wo).T)
        drawn = (pdf > 0) & (wo[:, 2] > 0)
        weight = np.where(drawn, wo[:, 2] / np.where(drawn, pdf, 1), 0)[:, None]
        wo[~drawn] = 0, 0, 1
        f, f_hat = (weight * bsdf_values(bsdf, wi, wo, times) for bsdf in (walk, neural))
        divisor = np.maximum(f.mean(axis=0), DARK)
        errors.append((f_hat - f).mean(axis=0) / divisor)
    return np.array(errors)


def pair_errors(walk: "mi.BSDF", neural: "mi.BSDF") -> np.ndarray:
    """E (3,) without the walk's noise."""
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(1), PAIRS)
    many_wi, many_wo = (np.tile(w, (REPEATS, 1)) for w in (wi, wo))
    number = np.repeat(np.arange(REPEATS, dtype=np.float32), PAIRS)
    values = bsdf_values(walk, many_wi, many_wo, number)
    halves = values.reshape(2, -1, PAIRS, 3).mean(axis=1)
    f, f_hat = halves.mean(axis=0), bsdf_values(neural, wi, wo)
    cosines = wi[:, 2], wo[:, 2]
    found = stack_error(f_hat.T, f.T, *cosines)
    noise = 0.5 * stack_error(halves[0].T, halves[1].T, *cosines)
    return np.sqrt(np.maximum(found**2 - noise**2, 0))


def measure(bottom: dict[str, Any], _: Options) -> Found:
    """By coat, and by "codes" for the worst of all coats, [albedo, E]; or why it is refused."""
    found: Found = {}
    for name, coat in COATS.items():
        tilted = texture(np.full((4, 4, 3), (0.6, 0.5, 0.9)))
        below = {k: tilted if value is TILTED else value for k, value in bottom.items()}
        # The middle one of three texels; equal ones would be a constant.
        widths = texture(coat["alpha"] * np.array([0.6, 1, 1.7]).reshape(1, 3, 1))
        try:
            own = {"type": "neural_layered"}
            forms = {"type": "layered"}, own, own | {"alpha": widths}
            walk, *both = (mi.load_dict({**coat, **form, "bottom": below}) for form in forms)
        except (UrushiError, RuntimeError) as error:
            return {"refused": str(error).splitlines()[-1].strip()}
        worst = [
            [np.abs(albedo_errors(walk, plugin)).max(), pair_errors(walk, plugin).max()]
            for plugin in both
        ]
        found[name] = worst[0]
        found["codes"] = np.maximum(found.get("codes", 0), worst[1])
        dr.flush_malloc_cache()
    return found


def tables(found: Found) -> list[str]:
    """Largest errors of the albedo and E, in per cent."""
    columns = [*COATS, "codes"]
    rows = [
        [name, *(" / ".join(f"{100 * x:.1f}" for x in case[column]) for column in columns)]
        for name, case in found.items()
        if "refused" not in case
    ]
    return [table(["bottom", *columns], rows)]


EXPERIMENT = Experiment(
    cases=lambda _: BOTTOMS, measure=measure, tables=tables, models=BOTH, minutes=15
)
