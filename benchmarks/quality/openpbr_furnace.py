"""White furnaces of the plugin `openpbr`: `python -m benchmarks.quality.openpbr_furnace`.

Draws random white materials and prints what they reflect of even light less one: mean, least and
greatest over materials and the cosines 1, 0.6, 0.3 and 0.2. Bases without coat are swept by
textures of one texel for each material; `--coats N` adds N coated materials of each kind, which
take some seconds each. Samples have errors of up to 0.4 %, walks of up to 1 %.
"""

import argparse
from typing import Any

import mitsuba as mi
import numpy as np

from urushi.mitsuba.reading import probing

SEED, SIDE, SAMPLES = 3, 6, 1 << 15
COSINES = (1.0, 0.6, 0.3, 0.2)
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
INDEX = ("specular_roughness", "specular_ior")
ANISOTROPY = "specular_roughness_anisotropy"
METAL = {"base_metalness": 1.0}
BASES: dict[str, tuple[tuple[str, ...], dict[str, Any]]] = {
    "dielectric": (INDEX, {}),
    "metal": (INDEX[:1], METAL),
    "anisotropic dielectric": ((*INDEX, ANISOTROPY), {}),
    "anisotropic metal": ((*INDEX[:1], ANISOTROPY), METAL),
    "rough slab": ((*INDEX, "base_diffuse_roughness"), {}),
    "index 0.7": (INDEX[:1], {"specular_ior": 0.7}),
    "index 0.7, rough slab": (INDEX[:1], {"specular_ior": 0.7, "base_diffuse_roughness": 1.0}),
    "film": (
        (*INDEX[:1], "thin_film_ior", "thin_film_thickness"),
        {"thin_film_weight": 1.0},
    ),
}


def _texture(values: np.ndarray) -> dict[str, Any]:
    bitmap = mi.Bitmap(values.astype(np.float32)[..., None])
    return {"type": "bitmap", "bitmap": bitmap, "raw": True, "filter_type": "nearest"}


def deviations(bsdf: "mi.BSDF", uv: np.ndarray) -> np.ndarray:
    """Reflected shares less one (len(COSINES), N) at points of uv (N, 2)."""
    count = len(uv) * SAMPLES
    index = np.tile(np.arange(SAMPLES), len(uv))
    u = [((index + 0.5) * 1.2207440846057596**-k % 1).astype(np.float32) for k in (1, 2, 3)]
    rows = []
    for cosine in COSINES:
        sine = (1 - cosine**2) ** 0.5
        wi = np.tile([sine * np.cos(0.87), sine * np.sin(0.87), cosine], (count, 1))
        si = probing.interaction(wi, np.repeat(uv, SAMPLES, 0), np.arange(count, dtype=np.float32))
        _, weight = bsdf.sample(mi.BSDFContext(), si, mi.Float(u[0]), mi.Point2f(u[1], u[2]))
        rows.append(weight[0].numpy().reshape(len(uv), SAMPLES).mean(1, dtype=np.float64) - 1)
    return np.array(rows)


def show(name: str, found: np.ndarray) -> None:
    """Print a row."""
    mean, low, high = (100 * x for x in (found.mean(), found.min(), found.max()))
    middle = 100 * np.median(np.abs(found))
    print(f"{name:26}{mean:+8.2f}{low:+8.2f}{high:+8.2f}{middle:8.2f}", flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.openpbr_furnace",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--coats", type=int, default=0, help="coated materials of each kind")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    print(f"{'reflected less one [%]':26}{'mean':>8}{'least':>8}{'most':>8}{'median':>8}")
    axis = (np.arange(SIDE) + 0.5) / SIDE
    uv = np.stack(np.meshgrid(axis, axis), -1).reshape(-1, 2)
    for name, (names, constants) in BASES.items():
        rng = np.random.default_rng(SEED)
        drawn = {key: _texture(rng.uniform(*RANGES[key], (SIDE, SIDE))) for key in names}
        bsdf = mi.load_dict({"type": "openpbr", "base_color": WHITE, **drawn, **constants})
        show(name, deviations(bsdf, uv))
    for reference in (False, True) if options.coats else ():
        for metalness in (0.0, 1.0):
            rng, rows = np.random.default_rng((SEED, int(metalness))), []
            for _ in range(options.coats):
                given: dict[str, Any] = {
                    key: float(rng.uniform(*RANGES[key]))
                    for key in (*INDEX, "coat_roughness", "coat_ior")
                }
                given |= {"base_metalness": metalness, "reference": reference}
                bsdf = mi.load_dict(
                    {"type": "openpbr", "base_color": WHITE, "coat_weight": 1.0, **given}
                )
                rows.append(deviations(bsdf, np.array([[0.5, 0.5]])))
            kind = "metal" if metalness else "dielectric"
            show(f"{'walks' if reference else 'networks'} over {kind}", np.concatenate(rows))


if __name__ == "__main__":
    main()
