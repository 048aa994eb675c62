"""Costs of all methods: an evaluation, a render, memory, and a new material."""

import gc
import tempfile
from functools import partial
from pathlib import Path
from typing import Any

import drjit as dr
import fan2022
import mitsuba as mi
import numpy as np
from benchmarks import spheres, timing
from benchmarks.rivals import nbrdf
from benchmarks.scenes import PAPER, PRINCIPLED
from benchmarks.verdict import fits
from benchmarks.verdict import methods as known
from fan2022 import PaperNetworks
from fan2022.architecture import LATENT
from fan2022.kernels import separate_kernels

import urushi
from urushi.core import direction_sets
from urushi.files import read_tensors
from urushi.nets.weights import default_model
from urushi.textures.store import KIND

#: The plugins of methods, and `principled`; weights stand for `neural_layered`.
PLUGINS = {PRINCIPLED: PRINCIPLED, **known.PLUGINS}
GOLD = urushi.conductor(0.2, (0.98, 0.77, 0.34))
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
#: Numbers of a coat and of a metal in RGB: alpha, eta, albedo, sigma_t and g; alpha and r0.
COAT_NUMBERS, BOTTOM_NUMBERS = 1 + 1 + 3 + 3 + 3, 1 + 3
#: Number of parameters of a Lambertian part and two GGX lobes.
GGX_NUMBERS = 3 + 2 * (1 + 1 + 3)


def evaluations(paper: str) -> dict[str, float]:
    """CPU time of an evaluation of f at random pairs in a kernel, over that of `principled`.

    For the walk in both directions, which has no plugin, by `walk_pairs` over the walk there.
    """
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(0), EVALUATIONS)
    bsdfs = {name: mi.load_dict(spheres.material(plugin, 0)) for name, plugin in PLUGINS.items()}
    recorded = {name: timing.evaluation(bsdf, wi, wo) for name, bsdf in bsdfs.items()}
    kernels = {name: partial(timing.kernel, kernel) for name, kernel in recorded.items()}
    least = timing.least(kernels, EVALUATION_TURNS)
    stack = urushi.coat(GOLD, 0.1, 1.5, albedo=0.8, sigma_t=(0.2, 1, 2))
    pairs = wi[: EVALUATIONS // WALKS], wo[: EVALUATIONS // WALKS]
    walks = {
        name: partial(walk.simulate, stack, *pairs, walks=WALKS)
        for name, walk in known.ESTIMATORS.items()
    }
    both = timing.calls(walks, EVALUATION_TURNS)
    least[known.BOTH_WAYS] = both[known.BOTH_WAYS] / both[known.WALK] * least[known.WALK]
    least[known.PAPER] = _evaluated_by_paper(paper, wi, wo)
    found = {name: t / least[PRINCIPLED] for name, t in least.items()}
    return found | {"nanoseconds": 1e9 * least[PRINCIPLED] / EVALUATIONS}


def _evaluated_by_paper(weights: str, wi: np.ndarray, wo: np.ndarray) -> float:
    """CPU time of evaluations by the system of Fan et al. (2022) [s]."""
    bsdf = mi.load_dict(spheres.material(PAPER + weights, 0))
    count = EVALUATIONS // PAPER_EVALUATION_PARTS
    recorded = timing.evaluation(bsdf, wi[:count], wo[:count])

    def evaluate() -> None:
        with separate_kernels():
            dr.eval(recorded())
            dr.sync_thread()

    return PAPER_EVALUATION_PARTS * timing.calls({"f": evaluate}, TURNS)["f"]


def renders(paper: str) -> dict[str, dict[str, float]]:
    """CPU time of a render over that with `principled`, constant and textured."""
    gc.collect()  # BSDFs in memory are compiled into every kernel
    found: dict[str, dict[str, float]] = {}
    for kind, textures in (("constant", 0), ("textured", spheres.ALL)):
        scenes = {
            name: partial(spheres.scene, spheres.material(plugin, textures), SIDE)
            for name, plugin in PLUGINS.items()
        }
        times = {name: seconds for name, (seconds, _) in spheres.renders(scenes, SAMPLES).items()}
        scene = spheres.scene(spheres.material(PAPER + paper, textures, PAPER_TEXELS), SIDE)
        with separate_kernels():
            slow = [spheres.seconds(scene, SAMPLES // PAPER_PARTS, 1) for _ in range(TURNS + 1)]
        times[known.PAPER] = PAPER_PARTS * min(slow[1:])
        del scene
        gc.collect()
        found[kind] = {name: t / times[PRINCIPLED] for name, t in times.items()}
    return found


def memory() -> dict[str, dict[str, int]]:
    """Bytes of a constant RGB material in single precision, and of a texel.

    Numbers of parametric models take one byte of a texel. `texel 6` is for six interfaces.
    """
    names = "material", "texel", "texel 6"

    def entry(material: int, texel: int, six: int | None = None) -> dict[str, int]:
        return dict(zip(names, (material, texel, texel if six is None else six), strict=True))

    found = {known.NETWORKS: entry(3 * 4 * default_model().arch.latent, texel_bytes())}
    found[known.PAPER] = entry(3 * 4 * LATENT, 3 * 4 * LATENT)
    numbers = COAT_NUMBERS + BOTTOM_NUMBERS  # of surfaces of one width
    for name in (known.WALK, known.BOTH_WAYS, *known.RIVALS):
        found[name] = entry(4 * numbers, numbers, numbers + 4 * COAT_NUMBERS)
    counts = {name: form.size() for name, form in fits.FORMS.items()} | {fits.GGX: GGX_NUMBERS}
    found |= {name: entry(4 * numbers, numbers) for name, numbers in counts.items()}
    return found | {fits.NBRDF: entry(4 * nbrdf.SIZE, 0)}


def texel_bytes() -> int:
    """Bytes of a texel of the networks: a coat of one index, everything else textured."""
    described = spheres.material(known.PLUGINS[known.NETWORKS], spheres.ALL)
    described["bottom"] = {"type": "roughconductor", "distribution": "ggx", "alpha": 0.2}
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coat.safetensors"
        mi.load_dict(described).save(str(path))
        texels = read_tensors(path, KIND)[1]["texels"]
    return texels.nbytes // len(texels)


def new_materials(paper: PaperNetworks) -> dict[str, float]:
    """CPU time to encode a metal and to lay a coat over it, RGB [s]."""
    top = urushi.dielectric(0.05, 1.5)

    def make(system: Any, networks: Any) -> None:
        system.layer(top, system.encode(GOLD, networks), albedo=0.8, sigma_t=(0.2, 1.0, 3.0))

    least = timing.calls({known.NETWORKS: partial(make, urushi, default_model())}, OPERATIONS)
    fresh = PaperNetworks(paper.arch, paper.params, {})  # it has kept no codes
    least[known.PAPER] = timing.seconds(partial(make, fan2022, fresh))
    return least
