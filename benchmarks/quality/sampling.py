"""Variance of importance sampling: `python -m benchmarks.quality.sampling`; three minutes.

For 200 held-out stacks, taken evenly from the groups of `benchmarks.evaluation`, and wi from 0 to
85 degrees, prints the coefficient of variation of f cos / pdf and the largest f cos / pdf. The
coefficient of variation is the relative noise of a picture under a uniform sky at one sample per
pixel. There are
three proposals:

- the codes' own;
- the one of Fan et al. 2022 (`urushi.fan2022.inference`), a Gaussian on the projected half vector
  and a cosine lobe, both independent of wi; its width and share are the best for each material, in
  place of a network's;
- a cosine lobe.

All figures use the same directions, drawn from the codes' proposal: the second moment of
f cos / q is the integral of (f cos)^2 / q.
"""

import argparse
import math
from typing import NamedTuple

import numpy as np
from benchmarks.evaluation import benchmark, predict
from tqdm import tqdm

from urushi.fan2022.inference import MIN_SHARE, MIN_SIGMA, GaussianMixture
from urushi.material import Material
from urushi.nets import weights
from urushi.nets.weights import Model

MATERIALS, SAMPLES = 200, 512
ANGLES = tuple(range(0, 90, 5))

#: The proposals, in the order of the table.
PROPOSALS = ("this proposal", "the paper's, best", "cosine")

#: Candidates for the width of the best Gaussian and the share of the cosine lobe.
SIGMAS = np.geomspace(MIN_SIGMA, 1, 24).astype(np.float32)
SHARES = np.linspace(MIN_SHARE, 1 - MIN_SHARE, 17).astype(np.float32)


class Drawn(NamedTuple):
    """Samples of one material by angle of wi: directions (A, S, 3), density and f cos (A, S)."""

    wi: np.ndarray
    wo: np.ndarray
    pdf: np.ndarray
    f_cos: np.ndarray


def draw(material: Material, seed: int) -> Drawn:
    """Draw directions from the material's own proposal."""
    theta = np.radians(ANGLES)
    wi = np.stack([np.sin(theta), 0 * theta, np.cos(theta)], axis=-1).astype(np.float32)
    wi = np.repeat(wi, SAMPLES, axis=0)
    u = np.random.default_rng(seed).random((len(wi), 3), np.float32)
    wo, pdf = material.sample(wi, u)
    f_cos = material.f(wi, wo).mean(axis=1) * wo[:, 2]
    shape = (len(ANGLES), SAMPLES)
    return Drawn(*(array.reshape(*shape, *array.shape[1:]) for array in (wi, wo, pdf, f_cos)))


def variation(drawn: Drawn, q: np.ndarray) -> np.ndarray:
    """Coefficients of variation (A,) of f cos / q for a density q (A, S)."""
    mean = (drawn.f_cos / drawn.pdf).mean(axis=1)
    second = (drawn.f_cos**2 / (q * drawn.pdf)).mean(axis=1)
    return np.sqrt(np.maximum(second / mean**2 - 1, 0))


def best_gaussian(drawn: Drawn) -> GaussianMixture:
    """The paper's proposal that diverges least from f cos over all wi."""
    target = drawn.f_cos / drawn.pdf
    target = target / target.sum(axis=1, keepdims=True)
    best, least = (SIGMAS[0], SHARES[0]), math.inf
    for sigma in SIGMAS:
        parts = [GaussianMixture(sigma, np.float32(s)).pdf(drawn.wi, drawn.wo) for s in (0, 1)]
        for share in SHARES:
            q = np.maximum((1 - share) * parts[0] + share * parts[1], 1e-12)
            divergence = -(target * np.log(q)).sum()
            if divergence < least:
                best, least = (sigma, share), divergence
    return GaussianMixture(*best)


def figures(model: Model) -> dict[str, tuple[np.ndarray, np.ndarray]]:
    """For each of `PROPOSALS`: variations (M, A) of materials by angles, and largest weights."""
    made = [m for samples in benchmark.read().values() for m in predict.materials(model, samples)]
    chosen = np.linspace(0, len(made) - 1, MATERIALS).astype(int)
    rows = []
    for seed, index in enumerate(tqdm(chosen, desc="materials", disable=None)):
        drawn = draw(made[index], seed)
        gaussian = np.maximum(best_gaussian(drawn).pdf(drawn.wi, drawn.wo), 1e-12)
        densities = (drawn.pdf, gaussian, drawn.wo[..., 2] / math.pi)
        rows.append([(variation(drawn, q), (drawn.f_cos / q).max(axis=1)) for q in densities])
    values = np.array(rows)  # (M, proposals, 2, A)
    return {name: tuple(values[:, i].swapaxes(0, 1)) for i, name in enumerate(PROPOSALS)}


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.sampling",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    model = weights.find(parser.parse_args().weights)
    print(f"{MATERIALS} materials, {len(ANGLES)} angles{'':4}", end="")
    print("".join(f"{name:>10}" for name in ("median", "95 %", "worst", "largest")))
    for name, (cv, weight) in figures(model).items():
        row = (*np.quantile(cv, (0.5, 0.95, 1)), weight.max())
        print(f"{name:28}" + "".join(f"{figure:10.2f}" for figure in row))


if __name__ == "__main__":
    main()
