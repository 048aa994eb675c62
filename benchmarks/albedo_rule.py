"""Quadrature of the albedo that bounds codes' energy: `python -m benchmarks.albedo_rule`.

Takes a minute. Writes src/urushi/material/albedo_rule.csv, or the file given by `--output`: for
each of ten angles of incidence, the fewest nodes that integrate every member of a family of BRDFs
to 0.2 % of its albedo. Nodes are picked from a fine rule one by one, each where it correlates best
with the residual, and all weights are fitted again after each by non-negative least squares (Lawson
and Hanson 1974, stopped early). No weight is negative, and a mixture of members has no larger error
than its members. Prints the number of nodes and the largest error of each angle.

The angles are Chebyshev points in ln(cos + 0.1): the albedo is smooth in this variable, and a
polynomial interpolates it between them.
"""

import argparse
from pathlib import Path

import numpy as np
from scipy.optimize import nnls

from urushi.core import fresnel
from urushi.core.namespace import NUMPY
from urushi.core.quadrature import half_vector_rule
from urushi.material.albedo_rule import COSINE_OFFSET
from urushi.nets import lobe as lobes

ANGLES, LEAST_COSINE = 10, 0.005
TOLERANCE, MOST_NODES, STEP = 0.002, 72, 2

#: Widths of the family's lobes, and lobes of random shape for each.
WIDTHS, SHAPES, WIDE = np.geomspace(0.01, 1, 20), 12, 40

OUT = Path(__file__).parents[1] / "src/urushi/material/albedo_rule.csv"


def cosines() -> np.ndarray:
    """The angles' cosines, falling from 1."""
    ends = np.log(np.array([1.0, LEAST_COSINE]) + COSINE_OFFSET)
    chebyshev = np.cos(np.pi * np.arange(ANGLES) / (ANGLES - 1))
    x = ends.mean() + 0.5 * (ends[0] - ends[1]) * chebyshev
    return np.clip(np.exp(x) - COSINE_OFFSET, LEAST_COSINE, 1)


def family(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
    """BRDFs (F, N) at wi (3,), wo (N, 3), up to factors: lobes and diffuse BRDFs, bare and coated.

    GGX lobes with several Fresnel terms; the same after the transmission of an interface and the
    absorption of a medium above them; and lobes whose tails have any power, times random smooth
    functions of all angles, in place of the shapes that networks produce.
    """
    h = wi + wo
    h /= np.linalg.norm(h, axis=-1, keepdims=True)
    cos_h, cos_d, cos_o = h[:, 2], h @ wi, wo[:, 2]
    cos_i = np.full_like(cos_o, wi[2])
    tan2 = (1 - cos_h**2) / cos_h**2
    out = [1 - _fresnel(cos_o, 1.5), 1 - _fresnel(cos_o, 2.0), 1 / (cos_i + cos_o)]
    out += [np.ones_like(cos_o), cos_o, cos_o**2, (cos_i * cos_o) ** -0.5]
    for g in (-0.8, -0.5, 0.0, 0.5, 0.8, 0.9):  # Henyey and Greenstein 1941, scattered once
        phase = (1 - g * g) * (1 + g * g + 2 * g * (wo @ wi)) ** -1.5 / (cos_i + cos_o)
        out += [phase, phase * (1 - np.exp(-0.3 * (1 / cos_i + 1 / cos_o)))]
    for alpha in WIDTHS:
        distribution = alpha**2 / (np.pi * ((alpha**2 - 1) * cos_h**2 + 1) ** 2)
        lobe = lobes.shape(alpha, np.broadcast_to(wi, wo.shape), wo)
        out += [lobe, lobe * (1 - cos_d) ** 5, *(lobe * _fresnel(cos_d, n) for n in (1.1, 1.5, 2))]
        passed = lobe * (1 - _fresnel(cos_o, 1.5))
        depth = 1 / np.sqrt(1 - (1 - cos_o**2) / 1.5**2)
        out += [passed, passed * np.exp(-0.5 * depth), passed * np.exp(-2 * depth)]
        out += [distribution / (cos_i + cos_o), distribution * np.minimum(cos_i / cos_o, 1)]
    rng = np.random.default_rng(5)
    smooth = np.stack([
        np.log(cos_i * cos_o), np.log(cos_i + cos_o), np.minimum(cos_i, cos_o), cos_d,
        (1 - cos_h**2 + 1e-14) ** 0.25, (1 - cos_d) ** 5, cos_h,
    ])  # fmt: skip
    spread = np.array([0.4, 0.8, 1, 1, 0.5, 1, 1])
    for alpha in np.repeat(WIDTHS, SHAPES):
        power = rng.uniform(1.2, 2.6)
        tail = -power * np.log1p(tan2 / alpha**2) - 0.5 * smooth[0]
        out.append(np.exp(tail + rng.normal(size=len(spread)) * spread @ smooth))
    out += [np.exp(rng.normal(size=len(spread)) * spread @ smooth) for _ in range(WIDE)]
    return np.stack(out)


def _fresnel(c: np.ndarray, eta: float) -> np.ndarray:
    return fresnel.dielectric(c, eta, NUMPY)[0]


def pick(values: np.ndarray, count: int) -> tuple[np.ndarray, np.ndarray]:
    """At most `count` columns of values (F, N), and weights by which every row sums to about 1."""
    norms, one = np.linalg.norm(values, axis=0), np.ones(len(values))
    picked: list[int] = []
    residual = one
    for _ in range(4 * count):  # columns of weight 0 are dropped, and others follow
        gain = values.T @ residual / norms
        gain[picked] = 0
        if gain.max() < 1e-9:
            break
        picked.append(int(gain.argmax()))
        weights, _ = nnls(values[:, picked], one, maxiter=10_000)
        picked = [p for p, w in zip(picked, weights, strict=True) if w > 0]
        weights = weights[weights > 0]
        residual = one - values[:, picked] @ weights
        if len(picked) == count:
            break
    return np.array(picked), weights


def nodes(cos_i: float) -> tuple[np.ndarray, np.ndarray, float]:
    """Directions (n, 3), weights (n,) and the largest error of an angle."""
    wi = np.array([np.sqrt(1 - cos_i**2), 0, cos_i])
    wo, weights = (array[0] for array in half_vector_rule(wi[None]))
    values = family(wi, wo) * wo[:, 2]
    values /= (values @ weights)[:, None]
    for count in range(16, MOST_NODES + 1, STEP):
        picked, found = pick(values, count)
        error = float(np.abs(values[:, picked] @ found - 1).max())
        if error < TOLERANCE:
            break
    return wo[picked], found * wo[picked, 2], error


def main() -> None:
    """Write the rule."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.albedo_rule",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--output", type=Path, default=OUT, help="file to write")
    output = parser.parse_args().output
    lines = [
        "# Directional albedo at ten angles, sums of weight f(wi, wo): by benchmarks.albedo_rule",
        "# cosine of wi, in the xz plane; wo; weight",
    ]
    for cos_i in cosines():
        wo, weights, error = nodes(cos_i)
        print(f"cos {cos_i:.4f}: {len(wo)} nodes, largest error {100 * error:.3f} %", flush=True)
        for (x, y, z), weight in zip(wo, weights, strict=True):
            lines.append(f"{cos_i:.8f},{x:.8f},{abs(y):.8f},{z:.8f},{weight:.6g}")
    output.write_text("\n".join(lines) + "\n", encoding="ascii")


if __name__ == "__main__":
    main()
