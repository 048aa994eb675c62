"""Costs of all methods: an evaluation, a render, memory, and a new material."""

import gc
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import drjit as dr
import fan2022
import mitsuba as mi
import numpy as np
from benchmarks import spheres, timing
from benchmarks.rivals import nbrdf
from benchmarks.scenes import PAPER
from benchmarks.verdict import fits
from benchmarks.verdict import methods as known
from fan2022 import PaperNetworks
from fan2022.architecture import LATENT
from fan2022.kernels import separate_kernels

import urushi
from urushi.files import read_tensors
from urushi.mitsuba.reading import probing
from urushi.nets.weights import default_model
from urushi.textures.store import KIND

PRINCIPLED = "principled"
#: Evaluations in a kernel, walks of each in the walk's, and turns of all methods.
EVALUATIONS, WALKS, EVALUATION_TURNS = 1 << 17, 16, 7
#: The picture's width, samples of a pixel, and turns of renders.
SIDE, SAMPLES, TURNS = 192, 32, 3
#: The system of Fan et al. (2022) is slow, so it is timed on a fraction of the work: an eighth of
#: the evaluations, and a 32nd of a render's samples. The time is multiplied accordingly; fixed
#: costs are negligible in it.
PAPER_EVALUATION_PARTS, PAPER_PARTS = 8, 32
#: Side of its textures in texels. `spheres.TEXELS` would be too many, because the width and the
#: bottom of every texel are projected. Reading a larger texture is little work beside the networks.
PAPER_TEXELS = 4
#: Repetitions of encoding and layering; the system of Fan et al. (2022) does them once.
OPERATIONS = 10
#: Side of the texture of which the bytes of a texel are found.
TEXELS = 16
#: Numbers of a coat and of a metal in RGB: alpha, eta, albedo, sigma_t and g; alpha and r0.
COAT_NUMBERS, BOTTOM_NUMBERS = 1 + 1 + 3 + 3 + 3, 1 + 3
#: Number of parameters of a Lambertian part and two GGX lobes.
GGX_NUMBERS = 3 + 2 * (1 + 1 + 3)


def evaluations(paper: str) -> dict[str, float]:
    """CPU time of an evaluation of f at random pairs in a kernel, over that of `principled`.

    For the walk in both directions, which has no plugin, by `walk_pairs` over the walk there.
    """
    rng = np.random.default_rng(0)
    wi, wo = _uniform(rng), _uniform(rng)
    si, out = _evaluated(wi, wo)
    kernels: dict[str, Callable[[], Any]] = {}
    for name, plugin in _plugins().items():
        bsdf = mi.load_dict(_bsdf(plugin, False))
        kernels[name] = partial(bsdf.eval, mi.BSDFContext(), si, out)
    least = timing.least(
        {name: partial(timing.kernel, kernel) for name, kernel in kernels.items()},
        EVALUATION_TURNS,
    )
    stack = urushi.coat(
        urushi.conductor(0.2, (0.98, 0.77, 0.34)), 0.1, 1.5, albedo=0.8, sigma_t=(0.2, 1, 2)
    )

    def walks(method: str) -> float:
        pairs = wi[: EVALUATIONS // WALKS], wo[: EVALUATIONS // WALKS]
        begin = time.process_time()
        known.ESTIMATORS[method].simulate(stack, *pairs, walks=WALKS)
        return time.process_time() - begin

    both = timing.least({e: partial(walks, e) for e in known.ESTIMATORS}, EVALUATION_TURNS)
    ratio = both[known.BOTH_WAYS] / both[known.WALK]
    least[known.BOTH_WAYS] = ratio * least[known.WALK]
    least[known.PAPER] = _evaluated_by_paper(paper, wi, wo)
    found = {name: float(f"{t / least[PRINCIPLED]:.3g}") for name, t in least.items()}
    return found | {"nanoseconds": round(1e9 * least[PRINCIPLED] / EVALUATIONS, 2)}


def _evaluated(wi: np.ndarray, wo: np.ndarray) -> tuple["mi.SurfaceInteraction3f", "mi.Vector3f"]:
    """Directions (N, 3) in memory, as arguments of `mi.BSDF.eval`."""
    si = probing.interaction(wi, np.full((len(wi), 2), 0.5))
    out = mi.Vector3f(np.ascontiguousarray(wo.T))
    dr.eval(si, out)
    return si, out


def _evaluated_by_paper(weights: str, wi: np.ndarray, wo: np.ndarray) -> float:
    """CPU time of evaluations by the system of Fan et al. (2022) [s]."""
    bsdf = mi.load_dict(spheres.material(PAPER + weights, False))
    count = EVALUATIONS // PAPER_EVALUATION_PARTS
    si, out = _evaluated(wi[:count], wo[:count])

    def seconds() -> float:
        begin = time.process_time()
        with separate_kernels():
            dr.eval(bsdf.eval(mi.BSDFContext(), si, out))
            dr.sync_thread()
        return time.process_time() - begin

    least = timing.least({known.PAPER: seconds}, TURNS)
    return PAPER_EVALUATION_PARTS * least[known.PAPER]


def renders(paper: str) -> dict[str, dict[str, float]]:
    """CPU time of a render over that with `principled`, constant and textured."""
    gc.collect()  # BSDFs in memory are compiled into every kernel
    found: dict[str, dict[str, float]] = {}
    for kind in ("constant", "textured"):
        operations = {}
        for name, plugin in _plugins().items():
            scene = spheres.scene(_bsdf(plugin, kind == "textured"), SIDE)
            operations[name] = partial(spheres.seconds, scene, SAMPLES, 1)
        least = timing.least(operations, TURNS)
        least[known.PAPER] = _rendered_by_paper(paper, kind == "textured")
        found[kind] = {name: round(t / least[PRINCIPLED], 3) for name, t in least.items()}
    return found


def _rendered_by_paper(weights: str, textured: bool) -> float:
    """CPU time of a render by the system of Fan et al. (2022) [s]."""
    material = spheres.material(PAPER + weights, textured, side=PAPER_TEXELS)
    scene = spheres.scene(material, SIDE)
    with separate_kernels():
        times = [spheres.seconds(scene, SAMPLES // PAPER_PARTS, 1) for _ in range(TURNS + 1)]
    del scene
    gc.collect()
    return PAPER_PARTS * min(times[1:])


def memory() -> dict[str, dict[str, int]]:
    """Bytes of a constant RGB material in single precision, and of a texel.

    Numbers of parametric models take one byte of a texel. `texel 6` is for six interfaces.
    """
    material, texel = 3 * 4 * default_model().arch.latent, texel_bytes()
    found = {known.NETWORKS: {"material": material, "texel": texel, "texel 6": texel}}
    names = ("material", "texel", "texel 6")
    found[known.PAPER] = dict.fromkeys(names, 3 * 4 * LATENT)
    for name in (known.WALK, known.BOTH_WAYS, *known.RIVALS):  # as of surfaces of one width
        numbers = COAT_NUMBERS + BOTTOM_NUMBERS
        found[name] = {
            "material": 4 * numbers,
            "texel": numbers,
            "texel 6": numbers + 4 * COAT_NUMBERS,
        }
    counts = {name: form.size() for name, form in fits.FORMS.items()} | {fits.GGX: GGX_NUMBERS}
    for name, numbers in counts.items():
        found[name] = {"material": 4 * numbers, "texel": numbers, "texel 6": numbers}
    found[fits.NBRDF] = {"material": 4 * nbrdf.SIZE, "texel": 0, "texel 6": 0}
    return found


def texel_bytes() -> int:
    """Bytes of a texel of the networks: a coat of one index, everything else textured."""
    described = spheres.material(known.PLUGINS[known.NETWORKS], True, side=TEXELS)
    described["bottom"] = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coat.safetensors"
        mi.load_dict(described).save(str(path))
        texels = read_tensors(path, KIND)[1]["texels"]
    return texels.nbytes // TEXELS**2


def new_materials(paper: PaperNetworks) -> dict[str, float]:
    """CPU time to encode a metal and to lay a coat over it, RGB [s]."""
    top = urushi.dielectric(0.05, 1.5)

    def seconds(system: Any, networks: Any) -> float:
        begin = time.process_time()
        bottom = system.encode(urushi.conductor(0.2, (0.98, 0.77, 0.34)), networks)
        system.layer(top, bottom, albedo=0.8, sigma_t=(0.2, 1.0, 3.0))
        return time.process_time() - begin

    own = partial(seconds, urushi, default_model())
    least = timing.least({known.NETWORKS: own}, OPERATIONS)
    fresh = PaperNetworks(paper.arch, paper.params, {})  # it has kept no codes
    least[known.PAPER] = seconds(fan2022, fresh)
    return {name: float(f"{t:.3g}") for name, t in least.items()}


def _plugins() -> dict[str, str]:
    """The plugins of methods, and `principled`; weights stand for `neural_layered`."""
    return {PRINCIPLED: PRINCIPLED, **known.PLUGINS}


def _bsdf(plugin: str, textured: bool) -> dict[str, Any]:
    """The sphere's BSDF by a plugin, or by weights; rivals have the parameters of `layered`."""
    rival = plugin in (known.PLUGINS[name] for name in known.RIVALS if name in known.PLUGINS)
    bsdf = spheres.material("layered" if rival else plugin, textured)
    return bsdf | {"type": plugin} if rival else bsdf


def _uniform(rng: np.random.Generator) -> np.ndarray:
    """Directions (`EVALUATIONS`, 3), uniform over the hemisphere."""
    cosine, turn = rng.uniform(0.01, 1, EVALUATIONS), rng.uniform(0, 2 * np.pi, EVALUATIONS)
    sine = np.sqrt(1 - cosine**2)
    return np.stack([sine * np.cos(turn), sine * np.sin(turn), cosine], axis=-1).astype(np.float32)
