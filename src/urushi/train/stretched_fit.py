"""Fitting the functions of the basis that two widths need beside those of one.

    python -m urushi.train.stretched_fit data FOLDER --stacks 600     values by light transport
    python -m urushi.train.stretched_fit fit FOLDER WEIGHTS OUT       the functions, for a basis

Random coats of one width or two cover random bottoms of two. Each stack has values at coarse nodes
of the stretched coordinates (`core.stretched`), at a few azimuths of the stretched half vector for
every node. The mean and the functions without a factor are given and stay as they are. The others
and the codes alternate in weighted least squares, as those of one width do (`basis_fit`).
"""

import argparse
import time
from collections.abc import Callable
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.interpolate import CubicSpline

from urushi.checks import CoatParameters, Widths
from urushi.core import probe_pairs as probing
from urushi.core.microfacet import of_widths
from urushi.core.namespace import NUMPY, Components
from urushi.core.stretched import FACTORS, stretched
from urushi.core.table import HIGHEST, LOWEST, SHAPE, TAN2_OFFSET, corners
from urushi.material.coated_anisotropic import coated_f
from urushi.nets import lobe as lobes
from urushi.nets import weights as files
from urushi.nets.code_fit import FIRST_FLOOR, LEAST_SHARE, PRIOR
from urushi.nets.networks import Architecture
from urushi.nets.stretched_basis import StretchedBasis
from urushi.train.proposal_fit import fit_proposal

#: Coarse nodes of u, v and w, and azimuths of the stretched half vector at each.
NODES, TURNS = (33, 17, 8), 2

#: Numbers of functions with each factor, and of probe pairs.
AZIMUTHAL, PROBES = (8, 8, 4, 4, 4), 384

#: Rounds by light, and rounds by the error that follow.
ROUNDS, LATE_ROUNDS = 3, 3

#: Rounds in which the codes of known values are solved.
SOLVING = 6

#: Share of a node's mean weight that every stack has there beside its own weight.
EVEN = 0.1

#: Stacks of a file.
SHARD = 45


class Values(NamedTuple):
    """Stacks (S) at the nodes (P) and azimuths (T)."""

    rest: np.ndarray  # float32 (S, P, T) [1/sr] f without the lobe
    top: np.ndarray  # float32 (S, P, T) [1/sr] f of the lobe
    measure: np.ndarray  # float32 (S, P, T) shares in integrals over pairs
    factors: np.ndarray  # float32 (S, P, T, 1 + `FACTORS`) with the factor one
    lobe: np.ndarray  # float32 (S, 7) of the interface
    stretch: np.ndarray  # float32 (S,) ln s
    probes: np.ndarray  # float32 (S, N) [1/sr] f at the probe pairs

    def taken(self, rows: np.ndarray) -> "Values":
        """The values of some stacks."""
        return Values(*(x[rows] for x in self))


# Values by light transport


def pairs_at(log_stretch: float, rng: np.random.Generator) -> tuple[np.ndarray, ...]:
    """Pairs wi, wo float32 (P, T, 3) at the coarse nodes, and their measure (P, T).

    The azimuths are random, one in each of T parts of the quadrant. The measure is the solid angles
    of a cell of nodes times both cosines.
    """
    axes = [np.linspace(0, 1, count) for count in NODES]
    u, v, w = (x.reshape(-1, 1) for x in np.meshgrid(*axes, indexing="ij"))
    half = [0.5 / (count - 1) for count in NODES]
    psi = (np.arange(TURNS) + rng.random((len(u), TURNS))) * (0.5 * np.pi / TURNS)
    sign = np.where(rng.random(psi.shape) < 0.5, -1, 1)
    s, tangent = np.exp(log_stretch), np.sqrt(_tan2(u))
    x, y = tangent * np.cos(psi) / s, tangent * np.sin(psi) * s
    cos_h, turn = 1 / np.sqrt(1 + x * x + y * y), np.arctan2(y, x)
    sin_h, cos_d = np.sqrt(1 - cos_h * cos_h), 1 - v * v
    sin_d = np.sqrt(1 - cos_d * cos_d)

    def cos_phi(w: np.ndarray) -> np.ndarray:
        both = sin_h * sin_d
        size = (1 - (1 - w) ** 2) * np.minimum(cos_h * cos_d, both)
        return np.where(both > 1e-12, size / np.maximum(both, 1e-12), w)

    cosine = cos_phi(w)
    sine = sign * np.sqrt(np.maximum(1 - cosine * cosine, 0))
    across = cosine * cos_h * sin_d, sine * sin_d, -cosine * sin_h * sin_d
    directions = []
    for way in (1, -1):
        p, q, z = (
            a + way * b for a, b in zip((sin_h * cos_d, 0, cos_h * cos_d), across, strict=True)
        )
        cos, sin = np.cos(turn), np.sin(turn)
        pair = np.stack([cos * p - sin * q, sin * p + cos * q, np.maximum(z, 4e-3)], axis=-1)
        directions.append(pair / np.linalg.norm(pair, axis=-1, keepdims=True))
    low, high = np.maximum(u - half[0], 0), np.minimum(u + half[0], 1)
    measure = (_tan2(high) - np.where(low > 0, _tan2(low), 0)) * cos_h**3
    low, high = np.maximum(v - half[1], 0), np.minimum(v + half[1], 1)
    measure = measure * ((1 - low * low) ** 2 - (1 - high * high) ** 2)
    low, high = (cos_phi(x.clip(0, 1)).clip(-1, 1) for x in (w - half[2], w + half[2]))
    measure = measure * np.maximum(np.arccos(low) - np.arccos(high), 1e-9)
    measure = measure * directions[0][..., 2] * directions[1][..., 2]
    wi, wo = (x.astype(np.float32) for x in directions)
    return wi, wo, measure / measure.sum()


def _tan2(u: np.ndarray) -> np.ndarray:
    return np.maximum(np.exp(LOWEST + u * (HIGHEST - LOWEST)) - TAN2_OFFSET, 1e-9)


def draw(rng: np.random.Generator) -> tuple[Callable[..., np.ndarray], CoatParameters]:
    """A random bottom f(wi, wo) -> (N, 1), and a random coat."""

    def log_uniform(low: float, high: float) -> float:
        return float(np.exp(rng.uniform(np.log(low), np.log(high))))

    def widths(low: float, high: float, least: float) -> Widths:
        root, size = log_uniform(1, 8) ** 0.5, log_uniform(low, high)
        pair = max(size / root, least), min(size * root, 1.0)
        return Widths(*pair) if rng.random() < 0.5 else Widths(*pair[::-1])

    kind = rng.choice(["metal", "complex", "mixture", "diffuse"], p=[0.5, 1 / 6, 1 / 6, 1 / 6])
    own = widths(0.03, 0.6, 0.02)
    fresnel = (0.0, 0.0, 1.0, rng.uniform(0.2, 2.5), rng.uniform(2, 5))
    if kind != "complex":
        fresnel = (rng.uniform(0.05, 1) ** 0.5, 1.0, 0.0, 1.5, 0.0)
    lobe = np.array([own.u, *fresnel, own.v], np.float32)
    share = {"diffuse": 0.0, "mixture": rng.uniform(0.05, 0.6)}.get(kind, 1.0)
    diffuse = np.float32((1 - share) * rng.uniform(0.02, 0.9) / np.pi)

    def bottom(wi: np.ndarray, wo: np.ndarray) -> np.ndarray:
        values = np.full(len(wi), diffuse)
        return (values + share * lobes.f(lobe, wi, wo) if share else values)[:, None]

    alpha: Any = log_uniform(0.01, 0.6)
    if kind == "diffuse" or rng.random() < 0.3:
        alpha = widths(0.01, 0.6, 0.01)
    low, high = [(1.02, 1.3), (1.3, 1.7), (1.7, 2.2)][rng.choice(3, p=[0.25, 0.55, 0.2])]
    medium = [
        (0.0, 0.0, 0.0),
        (0.0, log_uniform(0.05, 2), 0.0),
        (1 - rng.random() ** 2, log_uniform(0.05, 4), rng.uniform(-0.3, 0.8)),
    ][rng.choice(3)]
    return bottom, CoatParameters(alpha, *map(np.float64, (rng.uniform(low, high), *medium)))


def transported(seed: int) -> Values:
    """The values of one random stack."""
    rng = np.random.default_rng([seed, 20261128])
    bottom, coat = draw(rng)
    probe_pairs = probing.probe_pairs(PROBES, 2)
    probes = coated_f(bottom, coat, *probe_pairs)
    empty = np.zeros((1, 1), np.float32)
    basis = StretchedBasis(empty, np.zeros(1, int), probe_measure(PROBES), empty)
    stretch = float(basis.stretch(probes.T)[0])
    wi, wo, measure = pairs_at(stretch, rng)
    flat = wi.reshape(-1, 3), wo.reshape(-1, 3)
    rest = coated_f(bottom, coat, *flat).reshape(measure.shape)
    lobe = lobes.of_coat(of_widths(np.float64, coat.alpha), coat.eta)
    top = lobes.f(lobe, *flat).reshape(measure.shape)
    both, apart = (Components(*np.moveaxis(w.astype(float), -1, 0)) for w in (wi + wo, wi - wo))
    around = stretched(both, apart, np.exp(2 * stretch), NUMPY)[1]
    factors = np.stack([np.ones_like(measure), *around], axis=-1)
    whole = probes[:, 0] + lobes.f(lobe, *probe_pairs)
    parts = rest, top, measure, factors, lobe_of(lobe), np.array(stretch), whole
    return Values(*(x.astype(np.float32)[None] for x in parts))


def lobe_of(lobe: np.ndarray) -> np.ndarray:
    """A lobe (7,) of two widths from one (6,) or (7,)."""
    return lobe if len(lobe) == 7 else lobes.with_two_widths(lobe)


def data(folder: Path, stacks: int) -> None:
    """Write the values of random stacks; finished files are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    for first in range(0, stacks, SHARD):
        path, began = folder / f"values-{first:05}.npz", time.perf_counter()
        if path.exists():
            continue
        parts = [transported(seed) for seed in range(first, first + SHARD)]
        arrays: dict[str, Any] = {
            n: np.concatenate([getattr(p, n) for p in parts]) for n in Values._fields
        }
        np.savez(path.with_suffix(".part.npz"), **arrays)
        path.with_suffix(".part.npz").rename(path)
        print(path.name, f"{time.perf_counter() - began:.0f} s", flush=True)


def read(folder: Path) -> Values:
    """The values of all files."""
    parts = [dict(np.load(path)) for path in sorted(folder.glob("values-*[0-9].npz"))]
    return Values(*(np.concatenate([p[name] for p in parts]) for name in Values._fields))


def probe_measure(count: int) -> np.ndarray:
    """Shares float32 (count,) of the probe pairs of two widths in integrals over pairs.

    Both cosines over the density of the pairs, a sum over their sets (`core.probe_pairs`): every
    second pair of the first has a log-uniform tan theta_h, the others log-uniform slopes.
    """
    wi, wo = (w.astype(np.float64) for w in probing.probe_pairs(count, 2))
    first = round(count * probing.HALF_ANGLE_SHARE)
    h = wi + wo
    h /= np.linalg.norm(h, axis=1, keepdims=True)
    x, y = np.abs(h[:, 0] / h[:, 2]), np.abs(h[:, 1] / h[:, 2])
    tangent, cos_d = np.hypot(x, y), np.clip((wi * h).sum(axis=1), 0, 1)
    sin_d = np.sqrt(np.maximum(1 - cos_d * cos_d, 1e-12))
    low, high = probing.MIN_TANGENT, probing.MAX_TANGENT
    span = np.log(high / low)
    radial = (tangent > low) * 2 / (np.pi * span * tangent**2)
    sloped = ((x > low) & (y > low)) / (span**2 * np.maximum(x * y, 1e-12))
    angles = probing.MAX_DIFFERENCE * np.pi * 4 * cos_d * sin_d
    density = 0.5 * (radial + sloped) / h[:, 2] ** 3 / angles
    density *= first * (tangent < high) * (np.arccos(cos_d) < probing.MAX_DIFFERENCE)
    density += (count - first) * 2 / ((1 - probing.MIN_COSINE) ** 2 * np.pi**2)
    measure = wi[:, 2] * wo[:, 2] / density
    return (measure / measure.sum()).astype(np.float32)


# The functions


class Fit(NamedTuple):
    """The state of a fit, at the coarse nodes."""

    mean: np.ndarray  # (P,)
    functions: np.ndarray  # float32 (P, K)
    factors: np.ndarray  # (K,) the factor of each function

    def at(self, around: np.ndarray) -> np.ndarray:
        """The functions (P T, K) times the factors (P, T, 1 + `FACTORS`) of a stack."""
        every = self.functions[:, None] * around[..., self.factors]
        return every.reshape(-1, every.shape[-1])

    def codes(self, values: Values, weights: np.ndarray, prior: np.ndarray) -> np.ndarray:
        """Codes (S, K) by least squares with weights (S, P, T)."""
        logs = bounded_logs(values) - self.mean[:, None]
        found = []
        for around, log, weight in zip(values.factors, logs, weights, strict=True):
            every = self.at(around)
            scaled = every * weight.reshape(-1, 1)
            normal = (scaled.T @ every).astype(float) + prior
            normal += 1e-9 * np.trace(normal) / len(normal) * np.eye(len(normal))
            found.append(np.linalg.solve(normal, (scaled.T @ log.ravel()).astype(float)))
        return np.array(found, np.float32)

    def logs(self, values: Values, codes: np.ndarray) -> np.ndarray:
        """ln f (S, P, T) of codes (S, K)."""
        pairs = zip(values.factors, codes, strict=True)
        found = np.stack([(self.at(around) @ code) for around, code in pairs])
        return found.reshape(values.rest.shape) + self.mean[:, None]


def light(values: Values) -> np.ndarray:
    """All light (S, 1, 1), in means over pairs."""
    return ((values.rest + values.top) * values.measure).sum((1, 2), keepdims=True)


def bounded_logs(values: Values) -> np.ndarray:
    """ln f (S, P, T) of rests, of which no value is far below the mean."""
    mean = (values.rest * values.measure).sum((1, 2), keepdims=True)
    return np.log(np.maximum(values.rest, LEAST_SHARE * mean + 1e-7))


def by_light(values: Values) -> np.ndarray:
    """Weights (S, P, T) of squared errors of ln f: the light of a pair, and a floor."""
    return values.measure * (values.rest / light(values) + FIRST_FLOOR)


def by_error(values: Values, logs: np.ndarray) -> np.ndarray:
    """Weights (S, P, T) by which squares of logarithms equal the error E, at ln f (S, P, T)."""
    off, f = np.minimum(logs, 12) - bounded_logs(values), values.rest
    difference, total = np.exp(np.minimum(logs, 12)) - f, light(values)
    near = np.abs(off) < 1e-3
    slope = np.where(near, f, difference / np.where(near, 1, off))
    size = np.abs(difference) + 0.02 * (f + 0.02 * total)
    weights = values.measure * (slope * slope / (size * total) + 0.02)
    return weights / weights.sum((1, 2), keepdims=True)


def fitted(rows: np.ndarray, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """The functions of a basis of two widths.

    Args:
        rows: (nodes, 1 + K) mean and functions of the basis of one width.
        values: of the training stacks.

    Returns:
        float32 (nodes, 1 + K') of all, and the inverse covariance (K', K') of the codes.
    """
    own = rows.shape[1] - 1
    counts = [own, *AZIMUTHAL]
    coarse = at_coarse_nodes(rows)
    logs = bounded_logs(values) - coarse[:, :1]
    start = [coarse[:, 1:]]
    for factor, count in enumerate(AZIMUTHAL, start=1):
        around = values.factors[..., factor]
        moment = (logs * (around - around.mean(axis=2, keepdims=True))).mean(axis=2)
        start.append(np.linalg.svd(moment, full_matrices=False)[2][:count].T * len(coarse) ** 0.5)
    fit = Fit(
        coarse[:, 0], np.concatenate(start, axis=1), np.repeat(np.arange(len(counts)), counts)
    )
    weights = by_light(values)
    for turn in range(ROUNDS + LATE_ROUNDS):
        codes = fit.codes(values, weights, np.zeros(()))
        if turn >= ROUNDS:
            weights = by_error(values, fit.logs(values, codes))
            codes = fit.codes(values, weights, np.zeros(()))
        fit = fit._replace(functions=_functions(fit, values, weights, codes, own))
    codes = fit.codes(values, by_light(values), np.zeros(()))
    further = [rows, at_all_nodes(fit.functions[:, own:])]
    prior = np.linalg.inv(np.cov(codes.T) + 1e-9 * np.eye(codes.shape[1]))
    return np.concatenate(further, axis=1).astype(np.float32), prior


def _functions(
    fit: Fit, values: Values, weights: np.ndarray, codes: np.ndarray, own: int
) -> np.ndarray:
    """The functions (P, K) that fit codes (S, K); the first `own` are as they were."""
    count = codes.shape[1] - own
    even = weights + EVEN * weights.mean(axis=0)
    logs = bounded_logs(values) - fit.mean[:, None]
    normal = np.zeros((len(fit.mean), count, count))
    right = np.zeros((len(fit.mean), count))
    for around, log, weight, code in zip(values.factors, logs, even, codes, strict=True):
        left = log - (fit.functions[:, :own] @ code[:own])[:, None]
        known = around[..., fit.factors[own:]] * code[own:]
        scaled = known * weight[..., None]
        normal += np.matmul(scaled.transpose(0, 2, 1), known)
        right += (scaled * left[..., None]).sum(axis=1)
    ridge = 1e-6 * np.trace(normal, axis1=1, axis2=2) / count + 1e-14
    found = np.linalg.solve(normal + ridge[:, None, None] * np.eye(count), right[..., None])[..., 0]
    blocks = [np.linalg.qr(found[:, fit.factors[own:] == k])[0] for k in range(1, 1 + FACTORS)]
    return np.concatenate(
        [fit.functions[:, :own], *(len(found) ** 0.5 * b for b in blocks)], axis=1
    ).astype(np.float32)


def at_coarse_nodes(rows: np.ndarray) -> np.ndarray:
    """Values float32 (P, K) at the coarse nodes of values (nodes, K) of tables."""
    axes = [np.linspace(0, 1, count) for count in NODES]
    places = (x.ravel() for x in np.meshgrid(*axes, indexing="ij"))
    return sum(rows[node] * share[:, None] for node, share in corners(SHAPE, *places))


def at_all_nodes(functions: np.ndarray) -> np.ndarray:
    """Values (nodes, K) of tables from values (P, K) at the coarse nodes, by cubic splines."""
    result = functions.reshape(*NODES, -1).astype(float)
    for axis, (known, count) in enumerate(zip(NODES, SHAPE, strict=True)):
        spline = CubicSpline(np.linspace(0, 1, known), result, axis=axis)
        result = spline(np.linspace(0, 1, count))
    return result.reshape(-1, functions.shape[1])


def solved(rows: np.ndarray, prior: np.ndarray, values: Values) -> tuple[np.ndarray, np.ndarray]:
    """Codes (S, K) that know all values, and their errors E (S,), at the coarse nodes."""
    coarse, own = at_coarse_nodes(rows), rows.shape[1] - 1 - sum(AZIMUTHAL)
    factors = np.repeat(np.arange(1 + FACTORS), [own, *AZIMUTHAL])
    fit, weights = Fit(coarse[:, 0], coarse[:, 1:], factors), by_light(values)
    best, least = np.zeros((len(values.rest), rows.shape[1] - 1)), np.full(len(values.rest), np.inf)
    for _ in range(SOLVING):
        codes = fit.codes(values, weights, PRIOR * prior)
        logs = fit.logs(values, codes)
        off = np.abs(np.exp(np.minimum(logs, 12)) - values.rest) * values.measure
        error = off.sum((1, 2)) / light(values)[:, 0, 0]
        best = np.where((error < least)[:, None], codes, best)
        least, weights = np.minimum(error, least), by_error(values, logs)
    return best, least


def write(folder: Path, given: Path, out: Path) -> None:
    """Fit the functions on top of those of a weights file, and write a weights file.

    The layering network is not trained.
    """
    values, model = read(folder), files.read(given)
    rows = np.asarray(model.params["basis.rows"])
    seen = ((values.rest * values.measure).sum((1, 2)) / light(values)[:, 0, 0]) > 0.01
    held = np.arange(len(values.rest)) % 6 == 0
    began = time.process_time()
    fit, prior = fitted(rows, values.taken(np.flatnonzero(seen & ~held)))
    tested = values.taken(np.flatnonzero(seen & held))
    e = solved(fit, prior, tested)[1]
    found = [round(100 * float(x), 2) for x in (e.mean(), *np.percentile(e, (50, 95)), e.max())]
    print(f"{seen.sum()} stacks, {time.process_time() - began:.0f} s; E of held-out ones:", *found)
    arch = Architecture(fit.shape[1] - 1, PROBES, widths=2, azimuthal=AZIMUTHAL)
    params = {name: np.zeros(shape) for name, shape in arch.parameter_shapes().items()}
    params |= {
        "basis.rows": fit,
        "basis.measure": probe_measure(PROBES),
        "basis.prior": prior,
    }
    networks = files.Model.of(arch, params, {}).networks
    params |= fit_proposal(networks, networks.encode(values.probes, values.lobe))
    files.save(out, arch, params, {"preset": "two widths", "E": found})


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    of_data, of_fit = commands.add_parser("data"), commands.add_parser("fit")
    of_data.add_argument("folder", type=Path)
    of_data.add_argument("--stacks", type=int, default=600)
    of_fit.add_argument("folder", type=Path)
    of_fit.add_argument("weights", type=Path, help="file with the basis of one width")
    of_fit.add_argument("out", type=Path, help="file to write")
    given = parser.parse_args()
    if given.command == "data":
        data(given.folder, given.stacks)
    else:
        write(given.folder, given.weights, given.out)


if __name__ == "__main__":
    main()
