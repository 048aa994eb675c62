"""Slopes of f by parameters of coated materials, against differences of the walk.

The derivative of the mean of f cos over pairs of directions, its difference quotient by the
plugin itself and by the walk, and the error of the derivative against the walk, relative to the
mean size of the slope.
"""

from functools import partial
from typing import Any, NamedTuple

import drjit as dr
import mitsuba as mi
import numpy as np
from benchmarks.experiment import BOTH, Experiment, Found
from benchmarks.showing import table
from gallery import stage

import urushi  # noqa: F401  # registers the plugins
from urushi.core.direction_sets import direction
from urushi.mitsuba.reading import probing

#: Pairs of directions at which slopes are compared, and walks for each.
PAIRS, WALKS = 2048, 256


def coated(bottom: dict, **coat: Any) -> dict:
    return {"type": "neural_layered", "alpha": 0.2, "bottom": bottom} | coat


def grey(value: float) -> dict:
    return stage.rgb(value, value, value)


def over(plugin: str, colour: str, value: float, **coat: Any) -> dict:
    """A coat over a plugin of a grey value of its colour."""
    return coated({"type": plugin, colour: grey(value)}, **coat)


diffuse = partial(over, "diffuse", "reflectance")
principled = partial(over, "principled", "base_color")


def plastic(value: float, alpha: float = 0.1, **coat: Any) -> dict:
    bottom = {"type": "roughplastic", "distribution": "ggx", "diffuse_reflectance": grey(value)}
    return coated(bottom, alpha=alpha, **coat)


def gold(value: float) -> dict:
    return coated(stage.conductor("Au", value), alpha=0.1)


def openpbr(value: float) -> dict:
    off = {"coat_weight": 1.0, "energy_compensation": False}
    return {"type": "openpbr", "base_color": grey(value)} | off


def upper_index(value: float) -> dict:
    """Over another coat, whose relative index changes with it."""
    below = diffuse(0.6, int_ior=1.7)
    return coated(below, sigma_t=0.5, albedo=0.8, int_ior=value, ext_ior=1.0)


def slab(alpha: float, sigma_t: float, albedo: float = 0.8) -> dict:
    return {"type": "neural_layered", "alpha": alpha, "sigma_t": sigma_t, "albedo": albedo}


def medium(albedo: float, sigma_t: float) -> dict:
    return coated({"type": "diffuse"}, alpha=0.3, albedo=albedo, sigma_t=sigma_t)


#: A function of a value, the value, the end of the parameter's name, and the steps from it at which
#: f is compared. At an end of a range these are three: the difference of two would be the slope
#: between them. All walks of a case have the same random numbers, so that differences have little
#: noise.
SLOPES = {
    "black diffuse": (diffuse, 0.0, "reflectance.value", (0, 0.01, 0.02)),
    "dark diffuse": (diffuse, 0.002, "reflectance.value", (0, 0.01, 0.02)),
    "white diffuse": (diffuse, 1.0, "reflectance.value", (-0.02, -0.01, 0)),
    "principled": (principled, 0.8, "base_color.value", (-0.05, 0.05)),
    "black principled": (principled, 0.0, "base_color.value", (0, 0.01, 0.02)),
    "plastic": (plastic, 0.5, "diffuse_reflectance.value", (-0.05, 0.05)),
    "absent coat": (
        partial(principled, alpha=0.02, int_ior=1.01, ext_ior=1.0),
        *(0.5, "base_color.value", (-0.02, 0.02)),
    ),
    "sharp gold": (gold, 0.01, "bottom.alpha.value", (0, 0.002)),
    "rough gold": (gold, 1.0, "bottom.alpha.value", (-0.05, -0.025, 0)),
    "openpbr": (openpbr, 0.5, "base_color.value", (-0.05, 0.05)),
    "bright openpbr": (openpbr, 0.8, "base_color.value", (-0.05, 0.05)),
    "alpha on plastic": (
        lambda x: plastic(0.5, x, sigma_t=0.5, albedo=0.5),
        *(0.2, "alpha.value", (-0.02, 0.02)),
    ),
    "depth on plastic": (
        lambda x: plastic(0.5, 0.2, sigma_t=x, albedo=0.5),
        *(0.5, "sigma_t.value", (-0.05, 0.05)),
    ),
    "two coats on plastic": (
        lambda x: coated(plastic(x), alpha=0.3),
        *(0.5, "diffuse_reflectance.value", (-0.05, 0.05)),
    ),
    "two indices": (upper_index, 1.4, "eta", (-0.05, 0.05)),
    "white medium": (lambda x: medium(x, 5.0), 1.0, "albedo.value", (-0.002, -0.001, 0)),
    "width of a slab": (lambda x: slab(x, 1.0), 0.2, "alpha.value", (-0.02, 0.02)),
    "depth of a slab": (lambda x: slab(0.2, x), 0.5, "sigma_t.value", (-0.05, 0.05)),
    "white slab": (lambda x: slab(0.2, 2.0, x), 1.0, "albedo.value", (-0.02, -0.01, 0)),
    "no medium": (lambda x: medium(0.0, x), 0.0, "sigma_t.value", (0, 0.01, 0.02)),
}


def f_cos(bsdf: "mi.BSDF", walks: int = 1) -> "mi.Float":
    """The red channel of f cos at the pairs (PAIRS * walks), all pairs for each walk."""
    u = (np.random.default_rng(seed).random((PAIRS, 2)).T for seed in (1, 2))
    wi, wo = (np.tile(direction(*numbers), (walks, 1)) for numbers in u)
    time = np.repeat(np.arange(walks, dtype=np.float32), PAIRS)
    si = probing.interaction(wi.astype(np.float32), np.full((len(wi), 2), 0.5), time)
    wo = mi.Vector3f(np.ascontiguousarray(wo.T, np.float32))
    return bsdf.eval(mi.BSDFContext(), si, wo).x


class Slopes(NamedTuple):
    """Slopes of the mean of f cos: the derivative, and differences of the plugin and of the walk.

    size: the mean size of the slope of f cos by the walk. error: standard error of the walk's.
    away: mean difference of f with gradients from f without, relative to the mean of f.
    """

    derivative: float
    plugin: float
    walk: float
    size: float
    error: float
    away: float


def slopes(case: str) -> Slopes:
    """The slopes of an entry of `SLOPES`."""
    make, value, name, steps = SLOPES[case]
    powers = np.vander(steps, increasing=True)
    weights = np.linalg.solve(powers.T, np.eye(len(steps))[1])  # the polynomial's slope at zero
    bsdf = mi.load_dict(make(value))
    plain, parameters = f_cos(bsdf).numpy(), mi.traverse(bsdf)
    (key, *_) = (key for key in parameters.keys() if key.endswith(name))  # noqa: SIM118
    dr.enable_grad(parameters[key])
    parameters.update()
    found = f_cos(bsdf)
    away = float(np.abs(found.numpy() - plain).mean() / plain.mean())
    dr.backward(dr.mean(found))
    walk = {"reference": True} if make is openpbr else {"type": "layered"}
    of_plugin, of_walk = (
        weights @ [f_cos(mi.load_dict(make(value + step) | other), walks).numpy() for step in steps]
        for other, walks in (({}, 1), (walk, WALKS))
    )
    of_walk = of_walk.reshape(WALKS, PAIRS)
    return Slopes(
        float(np.sum(dr.grad(parameters[key]).numpy()[:1])),
        float(of_plugin.mean()),
        float(of_walk.mean()),
        float(np.abs(of_walk.mean(axis=0)).mean()),
        float(of_walk.mean(axis=1).std() / WALKS**0.5),
        away,
    )


def tables(found: Found) -> list[str]:
    """The slopes, and the error of the derivative relative to the slope's mean size."""
    head = ["material", "parameter", "derivative", "plugin", "walk", "its standard error", "error"]
    head.append("f with gradients")
    rows = []
    for case, (derivative, plugin, walk, size, error, away) in found.items():
        _, value, name, *_ = SLOPES[case]
        cells = [f"{x:.4f}" for x in (derivative, plugin, walk, error)]
        off = f"{(derivative - walk) / size:+.1%}".replace("-", "−").replace("%", " %")
        parameter = f"`{name.removesuffix('.value').rpartition('.')[2]}` {value:g}"
        rows.append([case, parameter, *cells, off, f"{100 * away:.2f} %"])
    return [table(head, rows)]


EXPERIMENT = Experiment(
    cases=lambda _: {case: case for case in SLOPES},
    tables=tables,
    measure=lambda case, _: [*slopes(case)],
    pages=("docs/gradients.md",),
    models=BOTH,
    minutes=2,
)
