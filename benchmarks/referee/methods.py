"""The methods that the referee compares: f of stacks, each by its own mapping of a stack.

A method raises `ParameterError` for a stack that it cannot describe, and OSError where it is not
installed. docs/referee.md states the mappings.
"""

import contextlib
import json
import os
import subprocess
import tempfile
from collections.abc import Callable, Mapping
from dataclasses import replace
from functools import cache, partial
from pathlib import Path
from typing import Any, NamedTuple

import mitsuba as mi
import numpy as np
from benchmarks import timing
from benchmarks.experiments import simulator_biases
from benchmarks.measures import bsdf_values
from benchmarks.referee import materials
from gallery.stage import rgb
from research.rivals import belcour, openpbr_recipe, plugins, weidlich

import urushi
from urushi.core.quadrature import directional_albedos
from urushi.errors import ParameterError
from urushi.openpbr_surface.description import openpbr
from urushi.openpbr_surface.description import parameters as openpbr_parameters
from urushi.walk import Conductor, Diffuse, Stack

#: Evaluations in a kernel, and turns of which the fastest counts.
EVALUATIONS, TURNS = 1 << 16, 5
#: The stack whose evaluation is timed, and that of methods without metals.
TIMED, PAINT = (materials.STACKS[f"car paint, {x}"] for x in ("silver flake", "solid red"))
PROGRAM, BPY = "URUSHI_OPENPBR_PROGRAM", "BPY_PYTHON"


class Method(NamedTuple):
    """A method."""

    # (stack, walks, wi, wo) -> (N, C) [1/sr]; walks: of a pair, for random walks
    f: Callable[..., np.ndarray]
    # The BSDF of Mitsuba whose evaluation is timed, for `mi.load_dict`; None: there is none
    timed: Callable[[], dict[str, Any]] | None = None
    # stack -> (3, C) at `materials.COSINES`; None: those of f
    albedos: Callable[[Stack], np.ndarray] | None = None


def evaluated(method: Method, stacks: Mapping[str, Stack], walks: int) -> dict[str, np.ndarray]:
    """f (N, C) at `materials.pairs` of the stacks that a method describes, by name."""
    return _described(lambda stack: method.f(stack, walks, *materials.pairs()), stacks)


def furnace(method: Method, walks: int) -> dict[str, np.ndarray]:
    """Directional albedos of white coated materials at `materials.COSINES`, by name."""
    albedos = method.albedos or (
        lambda stack: directional_albedos(partial(method.f, stack, walks), materials.lit())
    )
    return _described(lambda stack: albedos(stack).mean(-1), materials.WHITE)


def _described(function: Callable[[Stack], Any], stacks: Mapping[Any, Stack]) -> dict[Any, Any]:
    """A function of the stacks for which it raises no ParameterError."""
    found = {}
    for name, stack in stacks.items():
        with contextlib.suppress(ParameterError):
            found[name] = function(stack)
    return found


def price(method: Method) -> float | None:
    """CPU time of an evaluation of f in RGB in a kernel [ns]."""
    if method.timed is None:
        return None
    wi, wo = (np.resize(w, (EVALUATIONS, 3)) for w in materials.pairs())
    wo = np.random.default_rng(0).permutation(wo)
    recorded = timing.evaluation(mi.load_dict(method.timed()), wi, wo)
    return 1e9 * timing.least({"f": partial(timing.kernel, recorded)}, TURNS)["f"] / EVALUATIONS


# Mappings of a stack


def simple(stack: Stack) -> bool:
    """Whether a stack has one coat, whose medium is clear or absorbs."""
    first, *others = stack.coats
    return not others and not np.any(np.multiply(first.albedo, first.sigma_t))


def one_coat(stack: Stack) -> tuple[Any, Any, np.ndarray]:
    """The coat, the bottom, and the bottom's colour times what the coat transmits both ways.

    Raises:
        ParameterError: there is more than one coat, or the medium scatters.
    """
    given = openpbr_parameters(stack)
    colour = np.array(given["base_color"]) * np.array(given["coat_color"])
    return stack.coats[0], stack.bottom, colour


def principled(stack: Stack) -> dict[str, Any]:
    """Mitsuba's `principled`: a clear coat over a metal; of paint, its own dielectric surface."""
    coat, bottom, colour = one_coat(stack)
    surface = {"type": "principled", "base_color": rgb(*colour)}
    if isinstance(bottom, Diffuse):
        return surface | {"eta": float(coat.eta), "roughness": coat.alpha**0.5}
    gloss = float(np.clip((0.1 - coat.alpha) / 0.099, 0, 1))
    metal = {"metallic": 1.0, "roughness": bottom.alpha**0.5}
    return surface | metal | {"clearcoat": 1.0, "clearcoat_gloss": gloss}


def roughplastic(stack: Stack) -> dict[str, Any]:
    """Mitsuba's `roughplastic`, for a diffuse bottom."""
    coat, bottom, colour = one_coat(stack)
    if not isinstance(bottom, Diffuse):
        raise ParameterError("roughplastic has a diffuse base; give urushi.diffuse")
    surface = {"type": "roughplastic", "distribution": "ggx", "alpha": coat.alpha}
    indices = {"int_ior": float(coat.eta), "ext_ior": 1.0, "nonlinear": True}
    return surface | indices | {"diffuse_reflectance": rgb(*colour)}


def pbrt(stack: Stack) -> Stack:
    """pbrt-v4's `coateddiffuse` and `coatedconductor`: a grey depth; of a colour of a metal the
    absorption k of the index 1."""
    if len(stack.coats) > 1:
        raise ParameterError("pbrt-v4 has one coat; give a Stack of one coat")
    coat, bottom = stack.coats[0], stack.bottom
    if isinstance(bottom, Conductor):
        r = np.minimum(np.broadcast_to(np.asarray(bottom.r0, float), 3), 0.9999)
        bottom = urushi.conductor(bottom.alpha, eta=1.0, k=2 * np.sqrt(r) / np.sqrt(1 - r))
    depth = float(np.mean(coat.sigma_t))
    medium = {"albedo": coat.albedo, "sigma_t": depth, "g": coat.g}
    return urushi.coat(bottom, coat.alpha, coat.eta, **medium)


def cycles(stack: Stack) -> dict[str, Any]:
    """Sockets of Cycles' Principled BSDF: a metal or a diffuse surface under the coat."""
    given = openpbr_parameters(stack)
    sockets: dict[str, Any] = {"Base Color": (*given["base_color"], 1.0)}
    if isinstance(stack.bottom, Diffuse):
        sockets |= {"Specular IOR Level": 0.0, "Roughness": 1.0}
    else:
        sockets |= {"Metallic": 1.0, "Roughness": given["specular_roughness"]}
    return sockets | {
        "Coat Weight": 1.0,
        "Coat Roughness": given["coat_roughness"],
        "Coat IOR": given["coat_ior"],
        "Coat Tint": (*given["coat_color"], 1.0),
    }


# Evaluation


def of_bsdf(describe: Callable[[Stack], dict[str, Any]], timed: Stack = TIMED) -> Method:
    """A BSDF of Mitsuba."""

    def f(stack: Stack, _: int, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        return bsdf_values(mi.load_dict(describe(stack)), wi, wo)

    return Method(f, partial(describe, timed))


def over_metal(plugin: str) -> dict[str, Any]:
    """The timed stack by a plugin of coats."""
    plugins.register()
    coat, bottom = TIMED.coats[0], TIMED.bottom
    metal = {"type": "roughconductor", "distribution": "ggx", "alpha": bottom.alpha}
    indices = {"int_ior": float(coat.eta), "ext_ior": 1.0}
    return {"type": plugin, "alpha": coat.alpha, **indices, "bottom": metal}


def walked(
    mapped: Callable[[Stack], Stack],
    fault: Callable[[], contextlib.AbstractContextManager],
    stack: Stack,
    walks: int,
    wi: np.ndarray,
    wo: np.ndarray,
) -> np.ndarray:
    """The walk of a mapped stack, with one of the faults of `simulator_biases`."""
    count = max(2, walks * len(materials.pairs()[0]) // len(wi))
    with fault():
        return urushi.simulate(mapped(stack), wi, wo, walks=count, seed=7, progress=False)[0]


#: Urushi's material of a stack, by light transport.
encoded = cache(urushi.encode)


def of_recipe(recipe: openpbr_recipe.Recipe) -> Method:
    """One of OpenPBR's closed forms."""
    return Method(lambda s, _, wi, wo: openpbr_recipe.f(openpbr_parameters(s), wi, wo, recipe))


def program(stack: Stack, _: int, wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """f by the program of OpenPBR that `PROGRAM` names.

    Its arguments are name=number or name=red,green,blue. It reads pairs wi, wo as six numbers of
    single precision from its input until that ends, and writes f as three of them for each pair.
    """
    if not (path := os.environ.get(PROGRAM)):
        raise FileNotFoundError(f"{PROGRAM} names no program")
    given = openpbr_parameters(stack)
    texts = [f"{k}={','.join(f'{x:.7g}' for x in np.atleast_1d(v))}" for k, v in given.items()]
    data = np.concatenate([wi, wo], axis=1).astype("<f4").tobytes()
    done = subprocess.run([path, *texts], input=data, capture_output=True, check=True)
    return np.frombuffer(done.stdout, "<f4").reshape(-1, 3)


@cache
def in_blender(stacks: tuple[Stack, ...]) -> dict[Stack, np.ndarray]:
    """f and albedos (N + 3, 3) of Cycles' Principled BSDF, by pictures of tiles (`cycles_tiles`).

    The rows are those of `materials.pairs`, then of `materials.COSINES`.
    """
    if not (python := os.environ.get(BPY)):
        raise FileNotFoundError(f"{BPY} names no Python with Blender's module bpy")
    mapped, (wi, wo) = _described(cycles, {stack: stack for stack in stacks}), materials.pairs()
    given = json.dumps({str(i): sockets for i, sockets in enumerate(mapped.values())})
    with tempfile.TemporaryDirectory() as folder:
        source, target = Path(folder) / "pairs.npz", Path(folder) / "f.npy"
        sun = np.repeat(np.arange(materials.ANGLES), materials.EACH)
        np.savez(source, wi=wi, wo=wo, sun=sun, lit=materials.lit(), materials=given)
        script = Path(__file__).with_name("cycles_tiles.py")
        own = {k: v for k, v in os.environ.items() if k != "PYTHONPATH"}
        subprocess.run([python, script, source, target], env=own, capture_output=True, check=True)
        return dict(zip(mapped, np.load(target), strict=True))


def in_cycles(rows: slice, stack: Stack, *_: Any) -> np.ndarray:
    """Some of the rows of `in_blender`."""
    cycles(stack)  # refuses what it cannot describe
    return in_blender((*materials.STACKS.values(), *materials.WHITE.values()))[stack][rows]


METHODS: dict[str, Method] = {
    "walk, 128 walks": Method(
        partial(walked, lambda stack: stack, contextlib.nullcontext), partial(over_metal, "layered")
    ),
    "Urushi, tables": Method(
        lambda stack, _, *pair: encoded(stack).f(*pair), partial(over_metal, "neural_layered")
    ),
    "Urushi, codes": Method(
        lambda stack, _, *pair: replace(encoded(stack), table=None, beside_lobe=False).f(*pair)
    ),
    "Urushi, `openpbr`": of_bsdf(lambda s: openpbr(**openpbr_parameters(s)).description()),
    "Belcour 2018": Method(
        lambda stack, _, *pair: belcour.f(stack, *pair), partial(over_metal, "layered_belcour")
    ),
    "Weidlich and Wilkie 2007": Method(
        lambda stack, _, *pair: weidlich.f(stack, *pair), partial(over_metal, "layered_weidlich")
    ),
    "pbrt-v4, coated materials": Method(partial(walked, pbrt, simulator_biases.reverse_density)),
    "adobe/openpbr-bsdf": Method(program),
    "MaterialX 1.39, OpenPBR's graph": of_recipe("materialx"),
    "OpenPBR 1.1.1, the text": of_recipe("specification"),
    "Cycles' Principled": Method(
        partial(in_cycles, slice(-3)), albedos=partial(in_cycles, slice(-3, None))
    ),
    "Mitsuba's `principled`": of_bsdf(principled),
    "Mitsuba's `roughplastic`": of_bsdf(roughplastic, PAINT),
}
