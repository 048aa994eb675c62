"""Whether results stay the same: `python -m benchmarks.identity OUT.json [--compare OLD.json]`.

Run it before and after a change that must not alter results, on the same machine with the same
packages. It writes short SHA-256 hashes of arrays, and figures. `--compare` lists the entries that
differ and then exits with status 1.
`--sections` selects:

weights    fingerprints of the shipped weights                                              seconds
textures   texels of textures that `neural_layered` saves                                  20 s
codes      latent codes of constant coats, encoded, layered and blended materials  10 s
values     `simulate`, and f, pdf, samples and albedo of a material                         10 s
openpbr    f, pdf and samples of `openpbr`, bare and under a coat, with film and fuzz          1 min
eval       every figure of the experiment `accuracy`                                        2 min
demo       figures of the demo at 96 x 96 pixels, compared within ten per cent: Mitsuba loads
           shapes in parallel, and their order, in which lights are numbered, varies from
           run to run, so that the same seed gives other noise                              20 s
training   fingerprint of the preset `smoke`, from simulated data to trained weights        3 min

Times are of two cores. Without `--sections`, all run.
"""

import argparse
import hashlib
import json
import subprocess
import sys
import tempfile
from collections.abc import Callable
from functools import cache
from pathlib import Path
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np

import urushi
from urushi.files import atomic_write, read_tensors
from urushi.nets.weights import DEFAULT, default_model
from urushi.textures.store import KIND

#: Pairs of directions, and size of the demo's pictures and their samples per pixel.
PAIRS, DEMO_SIZE, DEMO_SPP = 500, 96, 16

#: Relative differences that are allowed, by section; elsewhere none are.
TOLERANCES = {"demo": 0.1}

Entries = dict[str, Any]


class Inputs(NamedTuple):
    """Random inputs, the same for every choice of sections.

    Attributes:
        bitmaps: texels (n, n, 1 or 3) by name.
        wi, wo: unit vectors (N, 3) of the upper hemisphere, float32.
        u: random numbers (N, 3) in [0, 1).
    """

    bitmaps: dict[str, np.ndarray]
    wi: np.ndarray
    wo: np.ndarray
    u: np.ndarray


@cache
def inputs() -> Inputs:
    """The inputs of all sections."""
    rng = np.random.default_rng(0)

    def texels(size: int, channels: int, low: float, high: float) -> np.ndarray:
        return (low + (high - low) * rng.random((size, size, channels))).astype(np.float32)

    bitmaps = {
        "alpha": texels(48, 1, 0.05, 0.5),
        "albedo": texels(48, 3, 0, 1),
        "sigma_t": texels(48, 3, 0, 2),
        "g": texels(48, 3, -0.5, 0.5),
        "coarse alpha": texels(32, 1, 0.05, 0.5),
        "coarse sigma_t": texels(32, 3, 0, 2),
        "base_color": texels(64, 3, 0.05, 0.9),
        "roughness": texels(64, 1, 0.2, 0.9),
    }
    wi, wo = rng.normal(size=(PAIRS, 3)), rng.normal(size=(PAIRS, 3))
    for w in (wi, wo):
        w[:, 2] = np.abs(w[:, 2])
        w /= np.linalg.norm(w, axis=1, keepdims=True)
    return Inputs(bitmaps, wi.astype(np.float32), wo.astype(np.float32), rng.random((PAIRS, 3)))


def hashed(*arrays: np.ndarray) -> str:
    """The first 16 hexadecimal digits of the SHA-256 of each array's bytes."""
    digests = (hashlib.sha256(np.ascontiguousarray(array).tobytes()) for array in arrays)
    return " ".join(digest.hexdigest()[:16] for digest in digests)


def weights() -> Entries:
    """The fingerprint of the shipped weights."""
    return {DEFAULT: default_model().fingerprint}


def textures() -> Entries:
    """Packed texels, and their ranges, of textured coats."""
    coarse = {
        "type": "neural_layered",
        "alpha": _texture("coarse alpha"),
        "albedo": 0.5,
        "sigma_t": _texture("coarse sigma_t"),
        "base": {
            "type": "principled",
            "base_color": _texture("base_color"),
            "roughness": _texture("roughness"),
            "metallic": 0.3,
        },
    }
    fine = {
        "type": "neural_layered",
        **{name: _texture(name) for name in ("alpha", "albedo", "sigma_t", "g")},
        "base": _conductor("Au", 0.2),
    }
    return {
        "over a conductor": _texels(fine),
        "over a texture": _texels(coarse),
    }


def _texture(name: str) -> dict:
    return {"type": "bitmap", "bitmap": mi.Bitmap(inputs().bitmaps[name]), "raw": True}


def _conductor(material: str, alpha: float) -> dict:
    return {
        "type": "roughconductor",
        "material": material,
        "alpha": alpha,
        "distribution": "ggx",
    }


def _texels(bsdf: dict) -> str:
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "texture.safetensors"
        mi.load_dict(bsdf).save(str(path))
        _, arrays = read_tensors(path, KIND)
    return hashed(arrays["texels"], arrays["lowest"], arrays["step"])


def codes() -> Entries:
    """Latent codes."""
    plastic = {
        "type": "roughplastic",
        "diffuse_reflectance": {"type": "rgb", "value": [0.1, 0.3, 0.5]},
    }
    inner = {"type": "neural_layered", "alpha": 0.05, "sigma_t": 1.0, "albedo": 0.9}
    coat = {"type": "neural_layered", "alpha": 0.08, "sigma_t": 0.7, "albedo": 0.6}
    bsdfs = {
        "coat over plastic": {**coat, "base": plastic},
        "coat over copper": {**coat, "base": _conductor("Cu", 0.15)},
        "coat over diffuse": {**coat, "base": {"type": "diffuse"}},
        "two coats": {
            "type": "neural_layered",
            "alpha": 0.2,
            "base": {**inner, "base": {"type": "diffuse"}},
        },
    }
    gold, layered = _gold(), _layered()
    materials = {
        **{name: _saved(bsdf) for name, bsdf in bsdfs.items()},
        "encoded description": urushi.encode(gold),
        "encoded stack": urushi.encode(_stack()),
        "encoded function": urushi.encode(_lobe),
        "layered": layered,
        "blended": urushi.lerp(urushi.encode(gold), layered, 0.3),
    }
    return {name: hashed(m.latents) for name, m in materials.items()}


def _gold() -> Any:
    return urushi.conductor(alpha=0.2, r0=(0.98, 0.77, 0.34))


def _stack() -> urushi.Stack:
    return urushi.coat(_gold(), alpha=0.05, eta=1.5, albedo=0.8, sigma_t=(0.2, 1.0, 3.0))


def _layered() -> urushi.Material:
    coat = urushi.dielectric(0.1, 1.4)
    return urushi.layer(coat, urushi.encode(_gold()), albedo=0.3, sigma_t=2.0)


def _lobe(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """A BRDF (N, 3) that no description has."""
    return np.exp(-3 * np.sum((wi - wo) ** 2, 1))[:, None] * [0.1, 0.2, 0.3]


def _saved(bsdf: dict) -> urushi.Material:
    """The material of a plugin without textures."""
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "material.safetensors"
        mi.load_dict(bsdf).save(str(path))
        return urushi.load(path)


def values() -> Entries:
    """What a stack and a material give for pairs of directions."""
    _, wi, wo, u = inputs()
    layered = _layered()
    return {
        "simulate": hashed(*urushi.simulate(_stack(), wi, wo, walks=256, progress=False)),
        "f": hashed(layered.f(wi, wo)),
        "pdf": hashed(layered.pdf(wi, wo)),
        "sample": hashed(*layered.sample(wi, u)[:2]),
        "directional albedo": hashed(layered.directional_albedo(wi[:20])),
    }


def openpbr() -> Entries:
    """What the plugin `openpbr` gives for pairs of directions."""
    gold = {"base_metalness": 1.0, "base_color": _rgb(0.98, 0.77, 0.34)}
    turned = {"specular_roughness_anisotropy": 0.6, "base_diffuse_roughness": 0.4}
    film = {"thin_film_weight": 0.8, "thin_film_ior": 1.6}
    coat = {"coat_weight": 1.0, "coat_color": _rgb(0.9, 0.7, 0.4), "coat_roughness": 0.2}
    color = {"base_color": _texture("base_color"), "specular_roughness": _texture("roughness")}
    mixed = {**turned, **film, "base_metalness": 0.4, "coat_weight": 0.6, "coat_ior": 1.4}
    cases = {
        "plain": {"fuzz_weight": 0.5},
        "turned film": {**turned, **film},
        "metal film": {**gold, **film},
        "coat": {**coat, "base_color": _rgb(0.2, 0.5, 0.8), "coat_darkening": 0.3},
        "coated gold": {**gold, **coat},
        "coated mixture": {**coat, **mixed},
        "coated textures": {**coat, **color},
        "walk": {**coat, **gold, "reference": True},
    }
    return {name: _evaluated({"type": "openpbr", **case}) for name, case in cases.items()}


def _rgb(*values: float) -> dict:
    return {"type": "rgb", "value": list(values)}


def _evaluated(bsdf: dict) -> str:
    """f times the cosine, pdf and samples of a BSDF."""
    loaded, (_, wi, wo, u) = mi.load_dict(bsdf), inputs()
    si = dr.zeros(mi.SurfaceInteraction3f, len(wi))
    si.wi, si.uv = mi.Vector3f(wi.T), mi.Point2f(u[:, :2].T)
    f, pdf = loaded.eval_pdf(mi.BSDFContext(), si, mi.Vector3f(wo.T))
    second = mi.Point2f(u[:, 1:].T)
    drawn, weight = loaded.sample(mi.BSDFContext(), si, mi.Float(u[:, 0].copy()), second)
    return hashed(*(np.array(x) for x in (f, pdf, drawn.wo, drawn.pdf, weight)))


def evaluation() -> Entries:
    """Every figure of the experiment `accuracy`."""
    from benchmarks.evaluation import benchmark, report

    return flat(report.measure(default_model(), benchmark.read()))


def demo() -> Entries:
    """The demo's figures, of a process of its own."""
    with tempfile.TemporaryDirectory() as folder:
        size = ["--width", str(DEMO_SIZE), "--height", str(DEMO_SIZE), "--spp", str(DEMO_SPP)]
        command = [sys.executable, "-m", "urushi.app.cli", "demo", "-o", folder, *size]
        subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
        figures = json.loads((Path(folder) / "report.json").read_text())
    return {
        name: figures[name]
        for name in ("relative_mse", "layered_noise", "neural_layered_noise", "psnr")
    }


def training() -> Entries:
    """Train the preset `smoke`."""
    from urushi.train import training as loop

    with tempfile.TemporaryDirectory() as folder:
        return {"smoke": loop.train("smoke", run=folder).fingerprint}


def flat(content: Any, name: str = "") -> Entries:
    """Numbers and texts of nested dictionaries and lists, by the path that leads to them."""
    if isinstance(content, dict):
        items = content.items()
    elif isinstance(content, list):
        items = enumerate(content)
    else:
        return {name: content}
    return {
        path: value
        for key, child in items
        for path, value in flat(child, f"{name}/{key}" if name else str(key)).items()
    }


SECTIONS: dict[str, Callable[[], Entries]] = {
    "weights": weights,
    "textures": textures,
    "codes": codes,
    "values": values,
    "openpbr": openpbr,
    "eval": evaluation,
    "demo": demo,
    "training": training,
}


def differences(old: Entries, new: Entries) -> list[str]:
    """One line for each entry that differs, of the sections that both have."""
    lines = []
    for section in (name for name in new if name in old):
        before, after = flat(old[section]), flat(new[section])
        tolerance = TOLERANCES.get(section, 0)
        lines += [
            f"{section}/{name}: {before.get(name)} -> {after.get(name)}"
            for name in before | after
            if not _same(before.get(name), after.get(name), tolerance)
        ]
    return lines


def _same(before: Any, after: Any, tolerance: float) -> bool:
    if tolerance and isinstance(before, float) and isinstance(after, float):
        return abs(after - before) <= tolerance * abs(before)
    return before == after


def main() -> int:
    """Write the file and compare."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.identity",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("output", type=Path, help="JSON file to write")
    parser.add_argument("--compare", type=Path, help="JSON file of an earlier run")
    parser.add_argument("--sections", nargs="+", choices=SECTIONS, default=list(SECTIONS))
    arguments = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    entries = {name: SECTIONS[name]() for name in arguments.sections}
    with atomic_write(arguments.output) as temporary:
        temporary.write_text(json.dumps(entries, indent=1) + "\n")
    if arguments.compare is None:
        return 0
    old = json.loads(arguments.compare.read_text())
    lines = differences(old, entries)
    print("\n".join(lines) if lines else f"same: {', '.join(n for n in entries if n in old)}")
    return 1 if lines else 0


if __name__ == "__main__":
    sys.exit(main())
