"""Whether results stay the same: `python -m benchmarks.identity OUT.json [--compare OLD.json]`.

Run it before and after a change that must not alter results, on the same machine with the same
packages. It writes short SHA-256 hashes of arrays, and figures. `--compare` lists the entries that
differ and then exits with status 1. `--sections` selects, with times on two cores:

weights    fingerprint of the shipped weights                                          seconds
textures   texels of textures that `neural_layered` saves                              20 s
codes      latent codes of constant coats, encoded, layered and blended materials      10 s
values     `simulate`, and f, pdf, samples and albedo of a material                    10 s
openpbr    f, pdf and samples of `openpbr`, bare and under a coat, with film and fuzz  1 min
eval       every figure of the experiment `accuracy`                                   2 min
training   fingerprint of the preset `smoke`, from simulated data to trained weights   3 min
"""

import hashlib
import json
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, Literal

import drjit as dr
import mitsuba as mi
import numpy as np
import tyro
from benchmarks.evaluation import benchmark, report
from benchmarks.spheres import texture
from gallery import stage

import urushi
from urushi.core.direction_sets import cosine_pairs
from urushi.files import atomic_write, read_tensors
from urushi.nets.weights import DEFAULT, default_model
from urushi.textures.store import KIND
from urushi.train import training as loop

#: Pairs of directions.
PAIRS = 500
GOLD = urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))
STACK = urushi.coat(GOLD, alpha=0.05, eta=1.5, albedo=0.8, sigma_t=(0.2, 1.0, 3.0))

Entries = dict[str, str]


@cache
def inputs() -> tuple[np.ndarray, np.ndarray, np.ndarray]:
    """wi and wo float32 (N, 3) above the horizon, u (N, 3) in [0, 1)."""
    rng = np.random.default_rng(0)
    return *cosine_pairs(rng, PAIRS), rng.random((PAIRS, 3))


def hashed(*arrays: np.ndarray) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of each array's bytes."""
    digests = (hashlib.sha256(np.ascontiguousarray(array).tobytes()) for array in arrays)
    return " ".join(digest.hexdigest()[:16] for digest in digests)


def saved(bsdf: dict[str, Any], read: Callable[[Path], Any]) -> Any:
    """What `read` finds in the file of a plugin."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "material.safetensors"
        mi.load_dict(bsdf).save(str(path))
        return read(path)


def coat(base: dict[str, Any], **parameters: Any) -> dict[str, Any]:
    return {"type": "neural_layered", **parameters, "base": base}


def layered() -> urushi.Material:
    top = urushi.dielectric(0.1, 1.4)
    return urushi.layer(top, urushi.encode(GOLD), albedo=0.3, sigma_t=2.0)


def colors() -> dict[str, Any]:
    """Textures of a bottom."""
    return {"base_color": texture(64, 0.05, 0.9, 3, 1), "roughness": texture(64, 0.2, 0.9, 1, 2)}


def textures() -> Entries:
    """Packed texels, and their ranges, of textured coats."""
    ranges = {"albedo": (0, 1, 3, 4), "sigma_t": (0, 2, 3, 5), "g": (-0.5, 0.5, 3, 6)}
    media = {name: texture(48, *limits) for name, limits in ranges.items()}
    below = {"type": "principled", **colors(), "metallic": 0.3}
    coarse = {"alpha": texture(32, 0.05, 0.5, 1, 7), "sigma_t": texture(32, 0, 2, 3, 8)}
    bsdfs = {
        "over a conductor": coat(
            stage.conductor("Au", 0.2), alpha=texture(48, 0.05, 0.5, 1, 3), **media
        ),
        "over a texture": coat(below, albedo=0.5, **coarse),
    }
    found = {k: saved(bsdf, lambda path: read_tensors(path, KIND)[1]) for k, bsdf in bsdfs.items()}
    return {k: hashed(*(a[x] for x in ("texels", "lowest", "step"))) for k, a in found.items()}


def codes() -> Entries:
    """Latent codes."""
    plastic = {"type": "roughplastic", "diffuse_reflectance": stage.rgb(0.1, 0.3, 0.5)}
    diffuse, outer = {"type": "diffuse"}, {"alpha": 0.08, "sigma_t": 0.7, "albedo": 0.6}
    bsdfs = {
        "coat over plastic": coat(plastic, **outer),
        "coat over copper": coat(stage.conductor("Cu", 0.15), **outer),
        "coat over diffuse": coat(diffuse, **outer),
        "two coats": coat(coat(diffuse, alpha=0.05, sigma_t=1.0, albedo=0.9), alpha=0.2),
    }
    materials = {
        **{name: saved(bsdf, urushi.load) for name, bsdf in bsdfs.items()},
        "encoded description": urushi.encode(GOLD),
        "encoded stack": urushi.encode(STACK),
        "encoded function": urushi.encode(
            lambda wi, wo: np.exp(-3 * np.sum((wi - wo) ** 2, 1))[:, None] * [0.1, 0.2, 0.3]
        ),
        "layered": layered(),
        "blended": urushi.lerp(urushi.encode(GOLD), layered(), 0.3),
    }
    return {name: hashed(material.latents) for name, material in materials.items()}


def values() -> Entries:
    """What a stack and a material give for pairs of directions."""
    (wi, wo, u), material = inputs(), layered()
    return {
        "simulate": hashed(*urushi.simulate(STACK, wi, wo, walks=256, progress=False)),
        "f": hashed(material.f(wi, wo)),
        "pdf": hashed(material.pdf(wi, wo)),
        "sample": hashed(*material.sample(wi, u)[:2]),
        "directional albedo": hashed(material.directional_albedo(wi[:20])),
    }


def openpbr() -> Entries:
    """f cos, pdf and samples of the plugin `openpbr`."""
    wi, wo, u = inputs()
    metal = {"base_metalness": 1.0, "base_color": stage.rgb(0.98, 0.77, 0.34)}
    turned = {"specular_roughness_anisotropy": 0.6, "base_diffuse_roughness": 0.4}
    film = {"thin_film_weight": 0.8, "thin_film_ior": 1.6}
    top = {"coat_weight": 1.0, "coat_color": stage.rgb(0.9, 0.7, 0.4), "coat_roughness": 0.2}
    maps = {name.replace("rough", "specular_rough"): value for name, value in colors().items()}
    mixed = {**turned, **film, "base_metalness": 0.4, "coat_weight": 0.6, "coat_ior": 1.4}
    cases = {
        "plain": {"fuzz_weight": 0.5},
        "turned film": {**turned, **film},
        "metal film": {**metal, **film},
        "coat": {**top, "base_color": stage.rgb(0.2, 0.5, 0.8), "coat_darkening": 0.3},
        "coated gold": {**metal, **top},
        "coated mixture": {**top, **mixed},
        "coated textures": {**top, **maps},
        "walk": {**top, **metal, "reference": True},
    }
    si, found = dr.zeros(mi.SurfaceInteraction3f, len(wi)), {}
    si.wi, si.uv = mi.Vector3f(wi.T), mi.Point2f(u[:, :2].T)
    first, second = mi.Float(u[:, 0].copy()), mi.Point2f(u[:, 1:].T)
    for name, case in cases.items():
        bsdf, context = mi.load_dict({"type": "openpbr", **case}), mi.BSDFContext()
        f, pdf = bsdf.eval_pdf(context, si, mi.Vector3f(wo.T))
        drawn, weight = bsdf.sample(context, si, first, second)
        found[name] = hashed(*map(np.array, (f, pdf, drawn.wo, drawn.pdf, weight)))
    return found


def evaluation() -> Entries:
    """Every figure of the experiment `accuracy`."""
    found = report.measure(default_model(), benchmark.read())
    entries = found["rows"] | {law["name"]: law for law in found["laws"]}
    return {name: json.dumps(figures) for name, figures in entries.items()}


def training() -> Entries:
    """Train the preset `smoke`."""
    with tempfile.TemporaryDirectory() as folder:
        return {"smoke": loop.train("smoke", run=folder).fingerprint}


SECTIONS: dict[str, Callable[[], Entries]] = {
    "weights": lambda: {DEFAULT: default_model().fingerprint},
    "textures": textures,
    "codes": codes,
    "values": values,
    "openpbr": openpbr,
    "eval": evaluation,
    "training": training,
}


def main(
    output: tyro.conf.Positional[Path],
    compare: Path | None = None,
    sections: tuple[Literal[tuple(SECTIONS)], ...] = tuple(SECTIONS),  # type: ignore[valid-type]
) -> None:
    """Write the file and compare.

    Args:
        output: JSON file to write.
        compare: JSON file of an earlier run.
        sections: to run.
    """
    mi.set_variant("llvm_ad_rgb")
    new = {name: SECTIONS[name]() for name in sections}
    with atomic_write(output) as temporary:
        temporary.write_text(json.dumps(new, indent=1) + "\n")
    if compare is None:
        return
    old = json.loads(compare.read_text())
    both = [section for section in new if section in old]
    differences = [
        f"{section}/{name}: {old[section].get(name)} -> {new[section].get(name)}"
        for section in both
        for name in old[section] | new[section]
        if old[section].get(name) != new[section].get(name)
    ]
    print("\n".join(differences) or f"same: {', '.join(both)}")
    raise SystemExit(bool(differences))


if __name__ == "__main__":
    tyro.cli(main, description=__doc__)
