"""Coats over all bottoms of Mitsuba: `python -m benchmarks.quality.coated_bottoms [NAME...]`.

For each bottom and each of four coats, prints the relative errors of `neural_layered` against the
random walk of `layered`, in per cent for red, green and blue. The albedo's error is the largest of
those at the cosines `COSINES` (with its sign); both plugins are evaluated at the same sampled
directions, and an albedo below `DARK` counts as `DARK`. E is as in docs/conventions.md, over
`PAIRS` pairs of cosine density and `REPEATS` walks each, less the noise of the walk. Bottoms that
cannot be coated are listed with the reason. Takes about 10 seconds of CPU time for a bottom.
`--codes` evaluates codes alone, as textured coats and coats over textured bottoms do.
"""

import argparse
import sys
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Any

import drjit as dr
import mitsuba as mi
import numpy as np

import urushi
from urushi.checks import AIR, GLASS, CoatParameters
from urushi.core import direction_sets
from urushi.core.error_metrics import stack_error
from urushi.errors import UrushiError
from urushi.material.layer import layer_texels
from urushi.mitsuba.latents.bottoms import BottomCodes
from urushi.mitsuba.reading import probing
from urushi.mitsuba.reading.below import bsdf_under
from urushi.mitsuba.reading.bsdf import has_two_widths
from urushi.nets.weights import anisotropic_model, default_model

#: Cosines of the albedos, walks for each of them, and the least divisor of an error.
COSINES, WALKS, DARK = (1.0, 0.85, 0.6, 0.3), 1 << 17, 0.02

#: Pairs of E, and walks for each.
PAIRS, REPEATS = 192, 2048

COATS = {
    "clear smooth": {"alpha": 0.03},
    "clear rough": {"alpha": 0.3},
    "tinted": {"alpha": 0.1, "sigma_t": {"type": "rgb", "value": [0.1, 0.4, 1.2]}},
    "scattering": {
        "alpha": 0.1,
        "int_ior": 1.4,
        "albedo": {"type": "rgb", "value": [0.95, 0.85, 0.7]},
        "sigma_t": 1.0,
        "g": 0.3,
    },
}


def rgb(*values: float) -> dict[str, Any]:
    """A colour."""
    return {"type": "rgb", "value": list(values)}


GREEN, ORANGE = rgb(0.1, 0.6, 0.2), rgb(0.8, 0.35, 0.05)
GOLD = {"type": "roughconductor", "material": "Au", "distribution": "ggx", "alpha": 0.15}

#: The bottoms: all opaque BSDFs of Mitsuba 3.9, its wrappers, and Urushi's own.
BOTTOMS: dict[str, dict[str, Any]] = {
    "diffuse": {"type": "diffuse", "reflectance": ORANGE},
    "conductor": {"type": "conductor", "material": "Au"},
    "roughconductor": GOLD,
    "roughconductor (beckmann)": {**GOLD, "distribution": "beckmann"},
    "roughconductor (.05, .3)": {**GOLD, "alpha_u": 0.05, "alpha_v": 0.3, "alpha": None},
    "plastic": {"type": "plastic", "diffuse_reflectance": ORANGE},
    "roughplastic": {"type": "roughplastic", "diffuse_reflectance": ORANGE, "alpha": 0.1},
    "roughplastic (ggx, .3)": {
        "type": "roughplastic",
        "diffuse_reflectance": GREEN,
        "distribution": "ggx",
        "alpha": 0.3,
        "nonlinear": True,
    },
    "pplastic": {"type": "pplastic", "diffuse_reflectance": ORANGE, "alpha": 0.1},
    "pplastic (.05)": {"type": "pplastic", "diffuse_reflectance": GREEN, "alpha": 0.05},
    "principled": {"type": "principled", "base_color": ORANGE, "roughness": 0.4, "specular": 0.5},
    "principled (metal)": {
        "type": "principled",
        "base_color": ORANGE,
        "metallic": 0.8,
        "roughness": 0.3,
    },
    "principled (cloth)": {
        "type": "principled",
        "base_color": GREEN,
        "roughness": 0.7,
        "sheen": 1.0,
        "sheen_tint": 0.5,
    },
    "principled (lacquer)": {
        "type": "principled",
        "base_color": GREEN,
        "roughness": 0.5,
        "clearcoat": 1.0,
        "clearcoat_gloss": 0.9,
    },
    "blendbsdf": {
        "type": "blendbsdf",
        "weight": 0.4,
        "a": {"type": "diffuse", "reflectance": GREEN},
        "b": GOLD,
    },
    "twosided": {
        "type": "twosided",
        "a": {"type": "roughplastic", "diffuse_reflectance": GREEN, "alpha": 0.2},
    },
    "bumpmap": {
        "type": "bumpmap",
        "a": {"type": "bitmap", "raw": True, "data": None},
        "b": {"type": "diffuse", "reflectance": GREEN},
    },
    "normalmap": {
        "type": "normalmap",
        "normalmap": {"type": "bitmap", "raw": True, "data": None},
        "b": {"type": "diffuse", "reflectance": GREEN},
    },
    "mask": {"type": "mask", "opacity": 0.5, "a": {"type": "diffuse"}},
    "null": {"type": "null"},
    "dielectric": {"type": "dielectric"},
    "hair": {"type": "hair"},
    "openpbr": {"type": "openpbr", "base_color": GREEN, "specular_roughness": 0.3},
    "openpbr (glossy)": {"type": "openpbr", "base_color": ORANGE, "specular_roughness": 0.15},
    "openpbr (metal)": {
        "type": "openpbr",
        "base_color": ORANGE,
        "base_metalness": 1.0,
        "specular_roughness": 0.4,
    },
    "layered": {
        "type": "layered",
        "alpha": 0.2,
        "a": {"type": "diffuse", "reflectance": GREEN},
    },
    "neural_layered": {
        "type": "neural_layered",
        "alpha": 0.2,
        "a": {"type": "diffuse", "reflectance": GREEN},
    },
}


def loaded(description: dict[str, Any]) -> "mi.BSDF":
    """A BSDF; entries of None are left out, and data of None are those of one tilted normal."""

    def filled(entry: dict[str, Any]) -> dict[str, Any]:
        result = {}
        for name, value in entry.items():
            if isinstance(value, dict):
                result[name] = filled(value)
            elif name == "data":
                result[name] = mi.TensorXf(np.full((4, 4, 3), (0.6, 0.5, 0.9), np.float32))
            elif value is not None:
                result[name] = value
        return result

    return mi.load_dict(filled(description))


def of_codes(coat: dict[str, Any], bottom: dict[str, Any]) -> "mi.BSDF":
    """A coat over a bottom by codes alone."""
    index = coat.get("int_ior", GLASS) / AIR
    below = bsdf_under(loaded(bottom), index)
    model = anisotropic_model() if has_two_widths(below) else default_model()
    encoded = BottomCodes(model, below, "codes")
    encoded.open(None)
    assert encoded.material is not None  # for the type checker
    medium = {
        name: coat[name]["value"] if isinstance(coat.get(name), dict) else coat.get(name, 0.0)
        for name in ("albedo", "sigma_t", "g")
    }
    z = encoded.material.latents
    codes = layer_texels(model, z, CoatParameters(coat["alpha"], index, **medium))
    with TemporaryDirectory() as folder:
        file = str(Path(folder) / "material.safetensors")
        urushi.Material(codes, model).save(file)
        return mi.load_dict({"type": "neural_brdf", "filename": file})


def values(bsdf: "mi.BSDF", wi: np.ndarray, wo: np.ndarray, repeats: int) -> np.ndarray:
    """f (repeats, N, 3) of independent evaluations."""
    a, b = (np.tile(w, (repeats, 1)) for w in (wi, wo))
    time = np.repeat(np.arange(repeats, dtype=np.float32), len(wi))
    f = probing.bsdf_values(bsdf, a, b, np.full((len(a), 2), 0.5), time)
    return f.reshape(repeats, len(wi), -1)


def albedo_errors(walk: "mi.BSDF", neural: "mi.BSDF") -> tuple[np.ndarray, np.ndarray]:
    """Relative errors (A, 3) of the albedos at `COSINES`, and their standard errors."""
    rng, errors, noise = np.random.default_rng(0), [], []
    for cosine in COSINES:
        wi = np.tile([np.sqrt(1 - cosine * cosine), 0, cosine], (WALKS, 1)).astype(np.float32)
        uv = np.full((WALKS, 2), 0.5)
        si = probing.interaction(wi, uv, np.arange(WALKS, dtype=np.float32))
        u = rng.random((3, WALKS), np.float32)
        sample, _ = walk.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1:]))
        pdf = np.broadcast_to(sample.pdf.numpy(), WALKS)
        wo = np.ascontiguousarray(np.array(sample.wo).T)
        drawn = (pdf > 0) & (wo[:, 2] > 0)
        weight = np.where(drawn, wo[:, 2] / np.where(drawn, pdf, 1), 0)[:, None]
        wo[~drawn] = 0, 0, 1
        times = np.arange(WALKS, dtype=np.float32)
        f, f_hat = (
            weight * probing.bsdf_values(bsdf, wi, wo, uv, times) for bsdf in (walk, neural)
        )
        divisor = np.maximum(f.mean(axis=0), DARK)
        errors.append((f_hat - f).mean(axis=0) / divisor)
        noise.append((f_hat - f).std(axis=0) / WALKS**0.5 / divisor)
    return np.array(errors), np.array(noise)


def pair_errors(walk: "mi.BSDF", neural: "mi.BSDF") -> np.ndarray:
    """E (3,) without the walk's noise."""
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(1), PAIRS)
    halves = values(walk, wi, wo, REPEATS).reshape(2, -1, PAIRS, 3).mean(axis=1)
    f, f_hat = halves.mean(axis=0), values(neural, wi, wo, 1)[0]
    cosines = wi[:, 2], wo[:, 2]
    found = stack_error(f_hat.T, f.T, *cosines)
    noise = 0.5 * stack_error(halves[0].T, halves[1].T, *cosines)
    return np.sqrt(np.maximum(found**2 - noise**2, 0))


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.coated_bottoms",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("names", nargs="*", help="bottoms; default: all")
    parser.add_argument("--codes", action="store_true", help="leave tables out")
    parser.add_argument("--measured", type=Path, nargs="*", default=[], help="MERL or RGL files")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    bottoms = BOTTOMS | {
        f"measured_brdf ({path.stem})": {"type": "measured_brdf", "filename": str(path)}
        for path in options.measured
    }
    chosen = options.names or list(bottoms)
    print(f"{'bottom':28}{'coat':14}{'albedo [%]':>24}{'noise':>7}{'E [%]':>22}")
    worst = np.zeros(2)
    for name in chosen:
        for label, coat in COATS.items():
            bottom = {"bottom": bottoms[name]}
            try:
                if options.codes:
                    neural = of_codes(coat, bottoms[name])
                else:
                    neural = loaded({"type": "neural_layered", **coat, **bottom})
                walk = loaded({"type": "layered", **coat, **bottom})
            except (UrushiError, RuntimeError) as error:
                print(f"{name:28}refused: {str(error).splitlines()[-1].strip()}", flush=True)
                break
            errors, noise = albedo_errors(walk, neural)
            peak = np.take_along_axis(errors, np.abs(errors).argmax(axis=0)[None], 0)[0]
            pairs = pair_errors(walk, neural)
            worst = np.maximum(worst, [np.abs(peak).max(), pairs.max()])
            print(
                f"{name:28}{label:14}"
                + "".join(f"{100 * x:8.1f}" for x in peak)
                + f"{100 * noise.max():7.2f}"
                + "  "
                + "".join(f"{100 * x:7.1f}" for x in pairs),
                flush=True,
            )
            dr.flush_malloc_cache()
    print(f"worst: albedo {100 * worst[0]:.1f} %, E {100 * worst[1]:.1f} %")
    sys.stdout.flush()


if __name__ == "__main__":
    main()
