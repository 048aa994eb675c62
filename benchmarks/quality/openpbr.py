"""Reach of the plugin `openpbr`: `python -m benchmarks.quality.openpbr`.

Draws random opaque coated materials over the normal ranges of OpenPBR's parameters, isotropic and
anisotropic ones, and prints E (docs/conventions.md) of the networks against random walks: mean,
median and 95th percentile over materials, and the noise of the walks. `--worst N` lists the worst.
`--cost` prints instead the processor time of a render over that of `neural_layered`, both with
textures of 256² texels, in one process by turns. Takes about 20 s of a core for a material; the
asked number is 200 of each kind.
"""

import argparse
import time
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.quality import conformance, openpbr_reference

#: Seed of the materials; those of training and of other benchmarks differ.
SEED = 911

#: Narrowest roughness, of the narrowest lobe there is.
LEAST_ROUGHNESS = 0.1


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


def measure(materials: list[dict[str, Any]]) -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """E of the networks, signed errors of the albedo, and E of the walks' noise: each (M,)."""
    wi, wo = openpbr_reference.pairs()
    rows, values = [], []
    for parameters in materials:
        rows.append(openpbr_reference.simulate(parameters))
        values.append(conformance.model(parameters)(wi, wo))
    f, se = (np.stack([row[k] for row in rows]) for k in range(2))
    names = {str(k): parameters for k, parameters in enumerate(materials)}
    reference = conformance.Reference(names, wi, wo, f, se)
    errors = conformance.errors(np.stack(values), reference)
    return errors.error, errors.albedo, conformance.noise(reference)


def reach(count: int, worst: int) -> None:
    """Print the errors of isotropic and of anisotropic materials."""
    print(f"{'E [%]':14}{'mean':>8}{'median':>8}{'p95':>8}{'|albedo|':>10}{'noise':>8}")
    for kind in ("isotropic", "anisotropic"):
        anisotropic = kind == "anisotropic"
        rng = np.random.default_rng((SEED, int(anisotropic)))
        materials = [draw(rng, anisotropic) for _ in range(count)]
        error, albedo, noise = (100 * x for x in measure(materials))
        median, high = np.percentile(error, [50, 95])
        line = f"{kind:14}{error.mean():8.2f}{median:8.2f}{high:8.2f}"
        print(f"{line}{np.abs(albedo).mean():10.2f}{noise.mean():8.2f}", flush=True)
        for k in np.argsort(error)[::-1][:worst]:
            given = ", ".join(f"{n}={np.round(v, 2).tolist()}" for n, v in materials[k].items())
            print(f"  {error[k]:.2f} (albedo {albedo[k]:+.2f}): {given}")


def _texture(seed: int, channels: int, low: float, high: float) -> dict[str, Any]:
    """Random texels between two values."""
    values = np.random.default_rng(seed).uniform(low, high, (256, 256, channels))
    bitmap = mi.Bitmap(values.astype(np.float32))
    return {"type": "bitmap", "bitmap": bitmap, "raw": True}


def _scene(bsdf: dict[str, Any]) -> "mi.Scene":
    """A sphere under even light."""
    camera = mi.ScalarTransform4f().look_at(origin=[0, 0, 4], target=[0, 0, 0], up=[0, 1, 0])
    return mi.load_dict(
        {
            "type": "scene",
            "integrator": {"type": "path", "max_depth": 3},
            "sensor": {
                "type": "perspective",
                "fov": 32,
                "to_world": camera,
                "film": {"type": "hdrfilm", "width": 256, "height": 256},
            },
            "light": {"type": "constant"},
            "sphere": {"type": "sphere", "bsdf": bsdf},
        }
    )


def cost(turns: int) -> None:
    """Print the least processor times of a render by turns, and their ratio."""
    colors = _texture(1, 3, 0.3, 0.95)
    roughness = {"type": "openpbr", "coat_weight": 1.0, "coat_roughness": _texture(2, 1, 0.3, 0.6)}
    scenes = {
        "openpbr": _scene(roughness | {"base_color": colors, "base_metalness": 1.0}),
        "neural_layered": _scene(
            {
                "type": "neural_layered",
                "alpha": _texture(2, 1, 0.09, 0.36),
                "int_ior": 1.6,
                "ext_ior": 1.0,
                "base": {
                    "type": "roughconductor",
                    "distribution": "ggx",
                    "alpha": 0.09,
                    "specular_reflectance": colors,
                },
            }
        ),
    }
    times: dict[str, list[float]] = {name: [] for name in scenes}
    for turn in range(turns + 1):
        for name, scene in scenes.items():
            begin = time.process_time()
            np.array(mi.render(scene, spp=64, seed=turn))
            if turn > 0:  # the first one compiles
                times[name].append(time.process_time() - begin)
    least = {name: min(t) for name, t in times.items()}
    for name, value in least.items():
        print(f"{name:16}{value:8.3f} s, of {turns} turns")
    print(f"{'ratio':16}{least['openpbr'] / least['neural_layered']:8.2f}")


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.openpbr",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--count", type=int, default=40, help="materials of each kind")
    parser.add_argument("--worst", type=int, default=0, help="number of the worst to list")
    parser.add_argument("--cost", action="store_true", help="measure the time of a render")
    parser.add_argument("--turns", type=int, default=7, help="renders of each for --cost")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    if options.cost:
        cost(options.turns)
    else:
        reach(options.count, options.worst)


if __name__ == "__main__":
    main()
