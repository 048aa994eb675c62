"""Speed: evaluations, walks, encoding, slabs, loading of textures, renders of spheres and scenes.

Default flags. Every case alternates its operations, and times are the least of some turns, so that
other load disturbs them less.
"""

import resource
import tempfile
import time
from collections.abc import Callable
from functools import partial
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks import spheres, timing
from benchmarks.experiment import NETWORKS, Experiment, Found, Options
from benchmarks.scenes import PRINCIPLED, WALK, View, coat
from benchmarks.showing import table
from benchmarks.spheres import ALL, FEW

import urushi
from urushi.core import direction_sets
from urushi.core.directions import directions_at
from urushi.material import adding
from urushi.material.slab_table import slab_tables
from urushi.measured import merl
from urushi.measured.tabulated import bin_centres
from urushi.nets.weights import ANISOTROPIC, DEFAULT
from urushi.parallel import one_blas_thread
from urushi.walk import analytic, walk_pairs
from urushi.walk.table import from_stack

#: Evaluations of a kernel; pairs and walks of the walk's; turns.
EVALUATIONS, PAIRS, WALKS, TURNS = 1 << 20, 1024, 2048, 5
#: Side of the textured coat that is loaded, pictures' width, and samples per pixel.
LOADED, SIDE, SPP = 1024, 512, 32

#: Scenes of the gallery that are rendered.
WHOLE = "caddy", "still-life", "globe", "teapot", "shoe"

_METAL = urushi.conductor(0.1, 0.9)
STACKS = {
    "alpha 0.1, eta 1.5, albedo 0.9, sigma_t 1": urushi.coat(_METAL, 0.1, 1.5, 0.9, 1.0),
    "the same, albedo 0.99, sigma_t 8, g 0.5": urushi.coat(_METAL, 0.1, 1.5, 0.99, 8.0, 0.5),
    "three interfaces, sigma_t 0.5 and 1": urushi.coat(
        urushi.coat(urushi.conductor(0.2, 0.9), 0.3, 1.2, 0.9, 1.0), 0.1, 1.5, 0.9, 0.5
    ),
}
#: Media (albedo, sigma_t, g) of three channels.
CLEAR = np.zeros((3, 3))
TINTED = np.array([(0.9, 0.5, 0.2), (0.5, 1.0, 2.0), (0.3, 0.3, 0.3)])
CHANNELS = "1 channel", "3 channels"
#: Interfaces (alpha, index relative to the medium above), and the media between them.
SLABS = {
    "a sheet of one coat": ([(0.3, 1.4), (0.3, 1 / 1.4)], [TINTED]),
    "a coat on a body of glass": ([(0.1, 1.3), (0.2, 1.5 / 1.3)], [TINTED]),
    "a coat on a pane": ([(0.2, 1.4), (0.03, 1.1), (0.03, 1 / 1.54)], [TINTED, CLEAR]),
    "a clear pane with coats on both sides": (
        [(0.1, 1.4), (0.03, 1.5 / 1.4), (0.03, 1.3 / 1.5), (0.2, 1 / 1.3)],
        [TINTED, CLEAR, TINTED],
    ),
    "three coats with media": (
        [(0.1, 1.4), (0.3, 1.2), (0.2, 0.9), (0.15, 1 / (1.4 * 1.2 * 0.9))],
        [TINTED, TINTED, TINTED],
    ),
}


def synthetic_merl(path: Path) -> Path:
    """Write a table in MERL's format: a rough conductor plus a Lambertian BRDF."""
    centres = (angle.ravel() for angle in np.broadcast_arrays(*bin_centres(merl.SHAPE)))
    wi, wo = (w.astype(np.float32) for w in directions_at(*centres))
    gold, base = urushi.conductor(0.2, (0.98, 0.77, 0.34)), urushi.diffuse((0.1, 0.05, 0.02))
    f = analytic.f(gold, wi, wo) + analytic.f(base, wi, wo)
    with path.open("wb") as file:
        np.array(merl.SHAPE, "<i4").tofile(file)
        (f / np.array(merl.SCALE)).T.astype("<f8").tofile(file)
    return path


def evaluations(options: Options) -> Found:
    """Millions of RGB evaluations of f a CPU second, of constants and of textures."""
    count, rng = options.count(EVALUATIONS, 1 << 10), np.random.default_rng(0)
    (wi, wo), uv, kernels = direction_sets.cosine_pairs(rng, count), rng.random((count, 2)), {}
    for name, textures in (("constant", 0), ("textured", ALL)):
        bsdf = mi.load_dict(spheres.material(options.weights or DEFAULT, textures))
        recorded = timing.evaluation(bsdf, wi, wo, uv)
        kernels[f"million evaluations of f, {name}"] = partial(timing.kernel, recorded)
    return {name: count / 1e6 / s for name, s in timing.least(kernels, TURNS).items()}


def walks(options: Options) -> Found:
    """Millions of walks a CPU second; a walk is one estimate of f for one pair and channel."""
    number, row = options.count(WALKS, 16), np.zeros(PAIRS, np.uint32)
    pairs = direction_sets.cosine_pairs(np.random.default_rng(1), PAIRS)
    calls = {
        f"million walks, {name}": partial(
            walk_pairs, from_stack(stack), row, *pairs, walks=number, seed=1
        )
        for name, stack in STACKS.items()
    }
    return {name: PAIRS * number / 1e6 / s for name, s in timing.calls(calls, TURNS).items()}


def materials(options: Options) -> Found:
    """CPU seconds to encode and layer one material, to read and encode a measured one."""
    model, gold = options.model, urushi.conductor(0.2, (0.98, 0.77, 0.34))
    bottom, top = urushi.encode(gold, model), urushi.dielectric(0.05, 1.5)
    medium = {"albedo": 0.8, "sigma_t": (0.2, 1.0, 3.0)}
    with tempfile.TemporaryDirectory() as folder:
        path = synthetic_merl(Path(folder) / "synthetic.binary")
        measured = urushi.load_measured(path)
        calls: dict[str, Callable[[], Any]] = {
            "encode one RGB material": lambda: urushi.encode(gold, model),
            "layer one RGB material": lambda: urushi.layer(top, bottom, **medium),
            "read a MERL file": lambda: urushi.load_measured(path),
            "encode a MERL file": lambda: urushi.encode(measured, model),
        }
        return timing.calls(calls, TURNS)


def slabs(_: Options) -> Found:
    """CPU seconds of the tables of slabs on one thread, for one channel and for three."""

    def seconds(interfaces: list, media: list, channels: int) -> float:
        for function in vars(adding).values():
            getattr(function, "cache_clear", int)()
        values = np.array(media)[..., :channels]
        return timing.seconds(lambda: slab_tables(np.array(interfaces), values))

    with one_blas_thread():
        operations = {
            f"tables of {name}, {label}": partial(seconds, *slab, int(label[0]))
            for name, slab in SLABS.items()
            for label in CHANNELS
        }
        return timing.least(operations, 2)


def loading(options: Options) -> Found:
    """Seconds to load, edit, save and read a textured coat; megabytes of its file and in memory.

    Textures hold noise of 8 bits, as images do: hardly two texels are equal.
    """
    side = options.count(LOADED, 16)

    def noise(low: float, high: float, channels: int, seed: int) -> Any:
        u = np.random.default_rng(seed).random((side, side, channels))
        texels = (low + (high - low) * np.floor(255 * u) / 255).astype(np.float32)
        return mi.load_dict({"type": "bitmap", "bitmap": mi.Bitmap(texels), "raw": True})

    base = mi.load_dict({"type": "roughconductor", "distribution": "ggx", "alpha": 0.2})
    described = coat(options.weights or DEFAULT) | {"base": base}
    ranges = {
        "alpha": (0.02, 0.3, 1),
        "albedo": (0, 1, 3),
        "sigma_t": (0, 2, 3),
        "g": (-0.5, 0.5, 3),
    }
    described |= {name: noise(*limits, k) for k, (name, limits) in enumerate(ranges.items())}
    begin, cpu = time.perf_counter(), time.process_time()
    bsdf = mi.load_dict(described)
    found = {"load": time.perf_counter() - begin, "load, CPU": time.process_time() - cpu}
    parameters = mi.traverse(bsdf)
    pixels = np.array(parameters["albedo.data"])
    pixels[: side // 64 + 1, : side // 64 + 1] = 0.5
    parameters["albedo.data"] = mi.TensorXf(pixels)
    found["edit"] = timing.seconds(parameters.update)
    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "coat.safetensors"
        found["save"] = timing.seconds(lambda: bsdf.save(path))
        found["file [MB]"] = path.stat().st_size / 2**20
        saved = {"type": "neural_brdf", "filename": str(path)}
        found["reload"] = timing.seconds(lambda: mi.load_dict(saved))
    peak = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss / 1024
    found["peak memory of the process [MB]"] = peak
    return {f"{side}² texels: {name}": value for name, value in found.items()}


def renders(make: Callable[[str], Any], options: Options) -> Found:
    """CPU seconds of a render by `PRINCIPLED`, codes and walk, and to compile; make: scenes."""
    names = {PRINCIPLED: PRINCIPLED, "codes": options.weights or DEFAULT, WALK: WALK}
    scenes = {name: partial(make, plugin) for name, plugin in names.items()}
    times = spheres.renders(scenes, options.count(SPP, 2))
    return {name: seconds for name, (seconds, _) in times.items()} | {"compile": times["codes"][1]}


def sphere(textures: int, brushed: bool, options: Options) -> Found:
    def make(plugin: str) -> Any:
        plugin = ANISOTROPIC if brushed and plugin == DEFAULT else plugin
        bsdf = spheres.material(plugin, textures, brushed=brushed)
        return spheres.scene(bsdf, options.count(SIDE, 32))

    return renders(make, options)


def whole(name: str, options: Options) -> Found:
    """A scene of the gallery, most of whose coats are textured."""
    view = View(name, width=options.count(SIDE, 32), detail=1.0)
    return renders(lambda plugin: view.load(plugin)[0], options)


def cases(_: Options) -> dict[str, Any]:
    functions = evaluations, walks, materials, slabs, loading
    parts: dict[str, Any] = {function.__name__: function for function in functions}
    for name, textures in (("constant", 0), ("three textures", FEW), ("all textured", ALL)):
        parts[f"sphere, {name}"] = partial(sphere, textures, False)
    for name, textures in (("constant", 0), ("three textures", FEW)):
        parts[f"brushed sphere, {name}"] = partial(sphere, textures, True)
    return parts | {f"scene {name}": partial(whole, name) for name in WHOLE}


def tables(found: Found) -> list[str]:
    """Renders as multiples of `principled`, all other figures, and slabs."""
    renders, others, slabs = [], [], []
    for name, case in found.items():
        if PRINCIPLED in case:
            ratios = (f"{case[key] / case[PRINCIPLED]:.2f}" for key in ("codes", WALK))
            renders.append([name, f"{case[PRINCIPLED]:.2g} s", *ratios, f"{case['compile']:.1f} s"])
        elif name != "slabs":
            others += [[label, f"{value:.4g}"] for label, value in case.items()]
    for name in SLABS if "slabs" in found else ():
        times = (found["slabs"][f"tables of {name}, {number}"] for number in CHANNELS)
        slabs.append([name, *(f"{seconds:.2g}" for seconds in times)])
    head = ["render", f"`{PRINCIPLED}`", "codes over it", "walk over it", "codes: compile"]
    parts = (
        (head, renders),
        (["measurement", "rate [1/CPU s] or time [CPU s]"], others),
        (["tables of [CPU s]", *CHANNELS], slabs),
    )
    return [table(*part) for part in parts if part[1]]


EXPERIMENT = Experiment(cases, tables, models=NETWORKS, minutes=15)
