"""Noise of importance sampling: by the codes' proposal, by that of Fan et al. 2022, by cosines.

For 200 held-out stacks, taken evenly from the groups of `benchmarks.evaluation`, and wi from 0 to
85 degrees: the coefficient of variation of f cos / pdf, which is the relative noise of a picture
under a uniform sky at one sample per pixel. The proposal of Fan et al. 2022
(`fan2022.inference`), a Gaussian on the projected half vector and a cosine lobe, both
independent of wi, has the best width and share for each material, in place of a network's. All
figures use the same directions, drawn from the codes' proposal: the second moment of f cos / q is
the integral of (f cos)^2 / q.
"""

import math
from typing import Any

import numpy as np
from benchmarks.evaluation import benchmark, predict
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, Pictures
from benchmarks.measures import in_plane
from benchmarks.showing import COLOURS, figure, table
from fan2022.inference import MIN_SHARE, MIN_SIGMA, GaussianMixture
from tqdm import tqdm

from urushi.core.namespace import NUMPY, components

MATERIALS, SAMPLES = 200, 512
ANGLES = tuple(range(0, 90, 5))

#: The proposals, in the order of the table, and their colours.
PROPOSALS = {
    "networks": COLOURS["networks"],
    "Fan et al. 2022, best fit": COLOURS["Fan et al. 2022"],
    "cosine": COLOURS["Belcour 2018"],
}

#: Shares of the materials and angles whose variation is stored.
SHARES = np.linspace(0, 1, 101)

#: Candidates for the width of the best Gaussian and the share of the cosine lobe.
SIGMAS = np.geomspace(MIN_SIGMA, 1, 24).astype(np.float32)
COSINE_SHARES = np.linspace(MIN_SHARE, 1 - MIN_SHARE, 17).astype(np.float32)


def gaussian(wi: np.ndarray, wo: np.ndarray, target: np.ndarray) -> np.ndarray:
    """The density (A, S) of the paper's proposal that diverges least from f cos over all wi.

    target: (A, S) f cos over the density of the directions, (A, S, 3).
    """
    pairs, cosine = (components(wi), components(wo), NUMPY), wo[..., 2] / math.pi
    target = target / target.sum(axis=1, keepdims=True)
    gaussians = (GaussianMixture(sigma, np.float32(1)).pdf(*pairs) for sigma in SIGMAS)
    densities = (
        np.maximum((1 - share) * gaussian + share * cosine, 1e-12)
        for gaussian in gaussians
        for share in COSINE_SHARES
    )
    return max(densities, key=lambda q: (target * np.log(q)).sum())


def measure(_: None, options: Options) -> Found:
    """By proposal: quantiles of the variation at `SHARES`, medians by angle, the largest weight."""
    held = benchmark.read().values()
    made = [m for samples in held for m in predict.materials(options.model, samples)]
    chosen = np.linspace(0, len(made) - 1, options.count(MATERIALS)).astype(int)
    rows = []
    wi, shape = np.repeat(in_plane(np.radians(ANGLES)), SAMPLES, axis=0), (len(ANGLES), SAMPLES)
    for seed, index in enumerate(tqdm(chosen, desc="materials", disable=None)):
        # Directions of the material's own proposal, by angle of wi.
        u = np.random.default_rng(seed).random((len(wi), 3), np.float32)
        wo, pdf = made[index].sample(wi, u)
        f_cos = (made[index].f(wi, wo).mean(axis=1) * wo[:, 2]).reshape(shape)
        (i, o), pdf = (w.reshape(*shape, 3) for w in (wi, wo)), pdf.reshape(shape)
        mean = (f_cos / pdf).mean(axis=1)
        densities = pdf, gaussian(i, o, f_cos / pdf), o[..., 2] / math.pi
        second = [(f_cos**2 / (q * pdf)).mean(axis=1) for q in densities]
        variation = np.sqrt(np.maximum(np.array(second) / mean**2 - 1, 0))
        weights = [(f_cos / q).max(axis=1) for q in densities]
        rows.append(np.stack([variation, weights], axis=1))
    values = np.moveaxis(np.array(rows), 0, 2)  # (proposals, 2, M, A)
    return {
        name: {
            "quantiles": np.quantile(cv, SHARES),
            "by angle": np.quantile(cv, (0.5, 0.95), axis=0),
            "largest": weight.max(),
        }
        for name, (cv, weight) in zip(PROPOSALS, values, strict=True)
    }


def plot(found: Found, _: Pictures) -> Any:
    """The variation over the share of materials and angles, and over the angle."""
    picture = figure(9, 3.4)
    left, right = picture.subplots(1, 2)
    for name, values in found["variation"].items():
        median, high = values["by angle"]
        left.plot(values["quantiles"], 100 * SHARES, color=PROPOSALS[name], label=name)
        right.plot(ANGLES, median, color=PROPOSALS[name])
        right.plot(ANGLES, high, color=PROPOSALS[name], linestyle="--")
    left.set(xscale="log", xlim=(0.03, 100), ylabel="materials and angles [%]")
    left.set_xlabel("variation of f cos θo / pdf")
    left.legend(fontsize=8)
    right.set(yscale="log", ylim=(0.03, 200), xlabel="θi [degrees]", xticks=(0, 30, 60, 85))
    right.set_ylabel("variation: median; 95 % dashed")
    return picture


def tables(found: Found) -> list[str]:
    """A row for each proposal."""

    def number(value: float) -> str:
        return f"{value:,.2g}" if value < 100 else f"{float(f'{value:.2g}'):,.0f}"

    rows = []
    for name, values in found["variation"].items():
        quantiles = np.interp((0.5, 0.95, 1), SHARES, values["quantiles"])
        rows.append([name, *map(number, (*quantiles, values["largest"]))])
    return [table(["proposal", "median", "95 %", "worst", "largest weight"], rows)]


EXPERIMENT = Experiment(
    lambda _: {"variation": None}, tables, measure, plot, models=NETWORKS, minutes=3
)
