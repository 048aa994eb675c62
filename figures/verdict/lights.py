"""Errors of renders at equal time, bias included, as in `figures.light`."""

import argparse

from benchmarks.quality import equal_time
from benchmarks.quality.converged import REFERENCE
from benchmarks.scenes import PRINCIPLED
from benchmarks.speed.render import PAPER

from figures.light.compute import COUNT, DEPTH, DETAIL, PARTS, SAMPLES, WIDTH
from figures.verdict import methods as known

#: CPU seconds of each method.
SECONDS = 2.5


def part(scene: str, light: str, paper: str | None, seconds: float = SECONDS) -> dict[str, float]:
    """The walk's mean squared error over that of each method at the walk's time.

    The error is that against the walk's converged picture: variance and bias. `exact` is a BSDF
    without noise and bias at the cost of Mitsuba's `principled`.
    """
    plugins = {name: plugin for name, plugin in known.PLUGINS.items() if name != known.WALK}
    if paper:
        plugins[known.PAPER] = PAPER + paper
    arguments = argparse.Namespace(
        weights=list(plugins.values()),
        width=WIDTH,
        detail=DETAIL,
        depth=DEPTH,
        spp=SAMPLES,
        seconds=seconds,
        folder=PARTS / "pictures",
    )
    methods, reference = equal_time.measure(scene, light, arguments)
    walk, cheap = methods[REFERENCE], methods[PRINCIPLED]
    found = {}
    for name, plugin in plugins.items():
        method = methods[plugin]
        bias = max(method.bias(reference), 0.0)
        spread = method.variance * method.second / walk.second / COUNT
        found[name] = walk.variance / COUNT / (spread + bias)
    own = methods[plugins[known.NETWORKS]]
    found["exact"] = walk.variance * walk.second / (own.variance * cheap.second)
    return {name: float(f"{factor:.3g}") for name, factor in found.items()}
