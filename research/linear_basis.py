"""Trials of a fixed linear basis for materials: `python -m research.linear_basis`.

    python -m research.linear_basis data out/basis --stacks 3000     tables by light transport
    python -m research.linear_basis fit out/basis --functions 24     a basis and its errors

The logarithm of f without the topmost lobe is b + sum_k c_k U_k over the nodes of
`urushi.material.table`. The functions U are shared by all materials, and c is the code of one. U is
fitted to tables by alternating weighted least squares; a code is a weighted least-squares solution
from the values at some pairs. A weight is the share of energy of a pair, plus a floor.

Errors are E in per cent (mean / median / 95th percentile / largest) against the walks of
`research.next_networks`, with their noise subtracted in squares, by coats and kind of bottom:
of the transport's own table, of a code fitted to all nodes, and of a code from the probe pairs.
"""

import argparse
import math
import time
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np
from scipy.linalg import qr

from research import next_networks
from urushi.checks import CoatParameters
from urushi.core import error_metrics
from urushi.core.directions import directions_at
from urushi.material.coated_table import coated_table
from urushi.material.material import Material
from urushi.material.table import (
    HIGHEST,
    LOWEST,
    SHAPE,
    TAN2_OFFSET,
    interpolated,
    node_pairs,
    pair_coordinates,
    table_of_values,
)
from urushi.nets import lobe as lobes
from urushi.nets.weights import default_model
from urushi.train.distribution import Extended, Practical
from urushi.train.examples import bottom_lobes, top_lobes
from urushi.walk import analytic
from urushi.walk.bottoms import KINDS
from urushi.walk.table import StackTable

#: Bottoms of training stacks, with their shares.
SHARES = {
    "conductor": 0.25,
    "conductor_complex": 0.1,
    "dielectric": 0.1,
    "diffuse": 0.1,
    "mixture": 0.3,
    "measured_like": 0.15,
}
#: Shares of stacks without coats, with one, two and three.
COATS = 0.12, 0.55, 0.25, 0.08

#: Share of the measure in the weights, beside the energy.
FLOOR = 0.05

#: Weight of the covariance of training codes in a solution, and share of a node's mean weight that
#: each table has there. Without them, exponentials explode where a table holds little energy.
PRIOR, EVEN = 1e-4, 0.1

#: Stacks of a file of tables.
SHARD = 50


# Tables by light transport


def tabulated(kind: str, columns: dict[str, np.ndarray]) -> Material:
    """Bare bottoms as the channels (S) of one material with a table beside its lobes."""
    model = default_model()
    order = np.stack([columns[name] for name in KINDS[kind].parameters], axis=-1)
    lobe = bottom_lobes(kind, order, model.arch).astype(np.float32)
    wi, wo = node_pairs()
    rest = np.zeros((len(wi), len(lobe)))
    if not KINDS[kind].family.bare:
        values = analytic.at_all(kind, columns, wi, wo)  # (S, N)
        rest = np.maximum(values.T - lobes.f(lobe, wi[:, None], wo[:, None]), 0)
    return beside(lobe, table_of_values(rest))


def beside(lobe: np.ndarray, table: np.ndarray) -> Material:
    """The material of lobes (C, N) beside a table."""
    model = default_model()
    codes = np.zeros((len(lobe), model.arch.latent), np.float32)
    codes[:, : model.arch.lobe] = lobe
    return Material(codes, model, table=table, beside_lobe=True)


def transported(stack: StackTable, row: int) -> Material:
    """One stack of a table, coat by coat."""
    part = {name: column[row : row + 1] for name, column in stack.bottom.items()}
    material = tabulated(stack.kind, part)
    for k in reversed(range(stack.coats)):
        columns = (getattr(stack, n)[row, k : k + 1] for n in CoatParameters._fields)
        coat = CoatParameters(*(c.astype(np.float64) for c in columns))
        lobe = lobes.of_coat(coat.alpha, coat.eta).astype(np.float32)
        material = beside(lobe, coated_table(material, coat, lobe))
    return material


def draw(seed: int) -> tuple[StackTable, str]:
    """One random stack, and its kind of bottom."""
    rng = np.random.default_rng([seed, 20261128])
    kind = rng.choice(list(SHARES), p=list(SHARES.values()))
    coats = int(rng.choice(len(COATS), p=COATS))
    practical = coats and rng.random() < 0.6
    source: Any = Practical(coats, kind) if practical else Extended(coats, kind, indices="whole")
    return source.sample(rng, 1), kind


def data(folder: Path, stacks: int) -> None:
    """Write the tables of random stacks; finished files are kept."""
    folder.mkdir(parents=True, exist_ok=True)
    for first in range(0, stacks, SHARD):
        path, began = folder / f"tables-{first:05}.npz", time.perf_counter()
        if path.exists():
            continue
        tables, tops, kinds, counts = [], [], [], []
        for seed in range(first, first + SHARD):
            stack, kind = draw(seed)
            material = transported(stack, 0)
            tables.append(material.table[..., 0])
            tops.append(material.latents[0, : material.model.arch.lobe])
            kinds.append(kind)
            counts.append(stack.coats)
        np.savez(path.with_suffix(".part.npz"), t=tables, top=tops, kind=kinds, coats=counts)
        path.with_suffix(".part.npz").rename(path)
        print(path.name, f"{time.perf_counter() - began:.0f} s", flush=True)


# The basis


def node_measure() -> np.ndarray:
    """Share (P,) of each node in integrals over pairs of cosine density on both sides.

    By a fine midpoint rule in the half angle, the difference angle and the azimuth; a point counts
    at the corners of its cell.
    """
    tan2 = np.exp(LOWEST + np.linspace(0, 1, 481) * (HIGHEST - LOWEST)) - TAN2_OFFSET
    edges = np.sqrt(np.maximum(tan2, 0))
    bounds = np.arctan(edges), np.arccos(1 - np.linspace(0, 1, 161) ** 2), np.linspace(0, np.pi, 97)
    middle, size = zip(*((0.5 * (x[1:] + x[:-1]), np.diff(x)) for x in bounds), strict=True)
    total = np.zeros(math.prod(SHAPE))
    for theta_h, width in zip(middle[0], size[0], strict=True):
        theta_d, phi_d = (x.ravel() for x in np.meshgrid(*middle[1:], indexing="ij"))
        weight = width * np.multiply.outer(*size[1:]).ravel()
        wi, wo = directions_at(np.full_like(theta_d, theta_h), theta_d, phi_d)
        weight = weight * np.sin(theta_h) * np.sin(theta_d) * np.cos(theta_d)
        weight = weight * wi[:, 2].clip(0) * wo[:, 2].clip(0)
        above = weight > 0
        places = pair_coordinates(wi[above], wo[above])
        for row, share in corners(*places):
            np.add.at(total, row, share * weight[above])
    return total / total.sum() + 1e-10  # no node is without weight


def corners(*places: np.ndarray) -> list[tuple[np.ndarray, np.ndarray]]:
    """The nodes (N,) around places (N,) in the table, each with its share."""
    index, share = [], []
    for place, count in zip(places, SHAPE, strict=True):
        scaled = np.clip(place, 0, 1) * (count - 1)
        index.append(np.minimum(scaled.astype(int), count - 2))
        share.append(scaled - index[-1])
    return [
        (
            np.ravel_multi_index(tuple(i + c for i, c in zip(index, corner, strict=True)), SHAPE),
            math.prod(s if c else 1 - s for s, c in zip(share, corner, strict=True)),
        )
        for corner in np.ndindex(2, 2, 2)
    ]


class Basis(NamedTuple):
    """ln f = mean (P,) + functions (P, K) code (K,)."""

    mean: np.ndarray
    functions: np.ndarray
    prior: np.ndarray  # (K, K), the inverse covariance of codes, times `PRIOR`


def weights(logs: np.ndarray, top: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """Weights (N, P) of squared errors of logarithms: energy, plus a floor."""
    energy = measure * np.exp(logs)
    total = energy.sum(axis=1, keepdims=True) + (measure * top).sum(axis=1, keepdims=True)
    return (energy / total + FLOOR * measure).astype(np.float32)


def solve(basis: Basis, logs: np.ndarray, weight: np.ndarray) -> np.ndarray:
    """Codes (N, K) by weighted least squares."""
    u = basis.functions
    k = u.shape[1]
    normal = (weight @ (u[:, :, None] * u[:, None]).reshape(len(u), -1)).reshape(-1, k, k)
    right = (weight * (logs - basis.mean)) @ u
    matrix = normal.astype(float) + basis.prior
    return np.linalg.solve(matrix, right[..., None].astype(float))[..., 0]


def encode(basis: Basis, logs: np.ndarray, top: np.ndarray, measure: np.ndarray, rounds: int = 3):
    """Codes (N, K), reweighted towards absolute errors."""
    weight = weights(logs, top, measure)
    codes = solve(basis, logs, weight)
    for _ in range(rounds):
        off = np.abs(basis.mean + codes @ basis.functions.T - logs) + 0.003
        codes = solve(basis, logs, weight / off.astype(np.float32))
    return codes


def fitted(logs: np.ndarray, top: np.ndarray, measure: np.ndarray, count: int, rounds: int = 8):
    """The basis of tables (N, P) by alternating weighted least squares."""
    weight = weights(logs, top, measure)
    even = weight + EVEN * weight.mean(axis=0)
    mean = ((weight * logs).sum(axis=0) / weight.sum(axis=0)).astype(np.float32)
    some = np.random.default_rng(0).choice(len(logs), min(600, len(logs)), replace=False)
    start = np.linalg.svd((logs - mean)[some], full_matrices=False)[2][: count - 1]
    functions = np.concatenate([np.ones((1, len(mean))), start]).T.astype(np.float32)
    basis = Basis(mean, functions, 1e-9 * np.eye(count))
    for _ in range(rounds):
        codes = solve(basis, logs, weight).astype(np.float32)
        products = (codes[:, :, None] * codes[:, None]).reshape(len(codes), -1)
        normal = (even.T @ products).reshape(-1, count, count)
        right = np.einsum("np,nk->pk", even * (logs - mean), codes, optimize=True)
        ridge = 1e-6 * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(count) / count
        u = np.linalg.solve(normal.astype(float) + ridge, right[..., None].astype(float))[..., 0]
        u = np.concatenate([np.ones((len(u), 1)), u], axis=1)  # a constant makes gains exact
        basis = Basis(mean, np.linalg.qr(u)[0][:, :count].astype(np.float32), 1e-9 * np.eye(count))
    spread = np.cov(solve(basis, logs, weight).T) + 1e-9 * np.eye(count)
    return basis._replace(prior=PRIOR * np.linalg.inv(spread))


def probes(basis: Basis, weight: np.ndarray, count: int) -> np.ndarray:
    """Nodes (count,) from which codes are solved: pivots of a QR, then random ones by weight."""
    first = qr((np.sqrt(weight)[:, None] * basis.functions).T, pivoting=True, mode="economic")[2]
    first = first[: basis.functions.shape[1]]
    others = np.setdiff1d(np.arange(len(weight)), first)
    share = weight[others] / weight[others].sum()
    more = np.random.default_rng(0).choice(others, count - len(first), replace=False, p=share)
    return np.concatenate([first, more])


# Errors


def read(folder: Path) -> tuple[np.ndarray, np.ndarray, np.ndarray, np.ndarray]:
    """Logarithms (N, P) of training tables, f (N, P) of their lobes, kinds and numbers of coats."""
    parts = [dict(np.load(path)) for path in sorted(folder.glob("tables-*[0-9].npz"))]
    table, top, kind, coats = (
        np.concatenate([p[n] for p in parts]) for n in ("t", "top", "kind", "coats")
    )
    wi, wo = node_pairs()
    top = np.stack([lobes.f(z[None], wi, wo) for z in top.astype(np.float32)]).astype(np.float32)
    logs = table.reshape(len(table), -1).astype(np.float32)
    return logs, top, kind, coats


def floored(logs: np.ndarray, measure: np.ndarray) -> np.ndarray:
    """Logarithms of at least a thousandth of the mean of f."""
    f = np.exp(logs)
    return np.log(np.maximum(f, 1e-3 * (f @ measure)[:, None] + 1e-7))


def share_of_rest(logs: np.ndarray, top: np.ndarray, measure: np.ndarray) -> np.ndarray:
    rest = np.exp(logs) @ measure
    return rest / (rest + top @ measure)


def line(name: str, errors: np.ndarray) -> str:
    e = 100 * np.asarray(errors)
    mean, median, high, most = e.mean(), *np.percentile(e, (50, 95)), e.max()
    return f"{name:44} {len(e):4} {mean:6.2f} {median:6.2f} {high:6.2f} {most:6.2f}"


def fit(folder: Path, count: int, held: str | None) -> None:
    """Fit a basis and print its errors on tables and on walks."""
    logs, top, kind, coats = read(folder)
    measure = node_measure().astype(np.float32)
    logs = floored(logs, measure)
    seen = share_of_rest(logs, top, measure) > 0.004
    logs, top, kind, coats = logs[seen], top[seen], kind[seen], coats[seen]
    test = np.arange(len(logs)) % 10 == 0
    learn = ~test & (kind != held)
    began = time.process_time()
    basis = fitted(logs[learn], top[learn], measure, count)
    print(f"K {count}, without {held}: {learn.sum()} tables, {time.process_time() - began:.0f} s")
    mean_weight = weights(logs[learn], top[learn], measure).mean(axis=0)
    chosen = probes(basis, mean_weight, 192)
    few = Basis(basis.mean[chosen], basis.functions[chosen], basis.prior)
    quadrature = measure[chosen] / np.maximum(mean_weight[chosen], 1e-12)  # of random nodes

    low, high = logs[learn].min(axis=0), logs[learn].max(axis=0)  # codes say nothing beyond

    def error(codes: np.ndarray, logs: np.ndarray, top: np.ndarray) -> np.ndarray:
        f = np.exp(np.clip(basis.mean + codes @ basis.functions.T, low, high))
        return (np.abs(f - np.exp(logs)) @ measure) / ((np.exp(logs) + top) @ measure)

    def from_probes(logs: np.ndarray, top: np.ndarray) -> np.ndarray:
        q = (quadrature / quadrature.sum()).astype(np.float32)
        return encode(few, logs[:, chosen], top[:, chosen], q)

    if held:
        test = test | (kind == held)
    whole = encode(basis, logs[test], top[test], measure)
    found = {
        "tables, all nodes": error(whole, logs[test], top[test]),
        "tables, probes": error(from_probes(logs[test], top[test]), logs[test], top[test]),
    }
    for name, errors in found.items():
        print(line(name, errors))
        for k in np.unique(kind[test]):
            for c in range(4):
                here = (kind[test] == k) & (coats[test] == c)
                if here.any():
                    print(line(f"  {k} {c}", errors[here]))
    np.savez(
        folder / f"basis-{count}-{held}.npz",
        mean=basis.mean,
        functions=basis.functions,
        prior=basis.prior,
        chosen=chosen,
        q=quadrature,
    )


def walks(folder: Path, file: str) -> None:
    """Print errors against walks of transport, of codes from all nodes and from probes."""
    stored = np.load(folder / file)
    basis = Basis(stored["mean"], stored["functions"], stored["prior"])
    measure = node_measure().astype(np.float32)
    chosen, q = stored["chosen"], (stored["q"] / stored["q"].sum()).astype(np.float32)
    few = Basis(basis.mean[chosen], basis.functions[chosen], basis.prior)
    nodes = node_pairs()
    groups: dict[str, list[tuple[float, ...]]] = {}
    store = next_networks.generate(next_networks.tests(), folder / "tests")
    for part in store.spec.parts:
        name, kind, count = part.name.split("-")
        if name == "validation":
            continue
        arrays = store.read(part)
        for row in range(len(arrays["f"])):
            table_file = folder / "test-tables" / f"{part.name}-{row}.npy"
            if not table_file.exists():
                table_file.parent.mkdir(exist_ok=True)
                np.save(table_file, test_table(part, arrays, row))
            logs = np.load(table_file).reshape(1, -1).astype(np.float32)
            lobe = test_lobe(part, arrays, row)
            top = lobes.f(lobe[None], *nodes)[None].astype(np.float32)
            low = floored(logs, measure)
            wi, wo = arrays["wi"][row], arrays["wo"][row]
            own = lobes.f(lobe[None], wi, wo)
            tables = {"transport": logs}
            tables["nodes"] = basis.mean + encode(basis, low, top, measure) @ basis.functions.T
            codes = encode(few, low[:, chosen], top[:, chosen], q)
            tables["probes"] = basis.mean + codes @ basis.functions.T
            weight = error_metrics.energy_weight(wi[:, 2], wo[:, 2])
            f = arrays["f"][row]
            energy = (f * weight).sum()
            noise = math.sqrt(2 / math.pi) * (arrays["se"][row] * weight).sum() / energy
            found = []
            for table in tables.values():
                rest = interpolated(table.reshape(*SHAPE, 1), wi, wo)[:, 0]
                e = (np.abs(own + rest - f) * weight).sum() / energy
                found.append(max(e * e - noise * noise, 0) ** 0.5)
            for group in (f"{name} {count}", f"{name} {count} {kind}"):
                groups.setdefault(group, []).append(tuple(found))
    for group in sorted(groups):
        for k, way in enumerate(("transport", "nodes", "probes")):
            print(line(f"{group}: {way}", np.array(groups[group])[:, k]))


def test_lobe(part: Any, arrays: dict[str, np.ndarray], row: int) -> np.ndarray:
    some = {name: arrays[name][row : row + 1] for name in ("coats", "bottom") if name in arrays}
    return np.asarray(top_lobes(part, some, default_model().arch))[0].astype(np.float32)


def test_table(part: Any, arrays: dict[str, np.ndarray], row: int) -> np.ndarray:
    kind, coats = part.distribution.bottom, arrays["coats"][row]  # from top to bottom
    columns = dict(zip(KINDS[kind].parameters, arrays["bottom"][row : row + 1].T, strict=True))
    material = tabulated(kind, columns)
    for values in coats[::-1]:
        coat = CoatParameters.of_columns(values[:, None].astype(np.float64))
        lobe = lobes.of_coat(coat.alpha, coat.eta).astype(np.float32)
        material = beside(lobe, coated_table(material, coat, lobe))
    return material.table[..., 0]


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    commands = parser.add_subparsers(dest="command", required=True)
    of_data, of_tests = commands.add_parser("data"), commands.add_parser("tests")
    of_data.add_argument("--stacks", type=int, default=3000)
    of_fit, of_walks = commands.add_parser("fit"), commands.add_parser("walks")
    of_fit.add_argument("--functions", type=int, default=24)
    of_fit.add_argument("--without", help="kind of bottom that is held out")
    of_walks.add_argument("basis", help="file of `fit`")
    for command in (of_data, of_tests, of_fit, of_walks):
        command.add_argument("folder", type=Path)
    given = parser.parse_args()
    if given.command == "data":
        data(given.folder, given.stacks)
    elif given.command == "fit":
        fit(given.folder, given.functions, given.without)
    elif given.command == "walks":
        walks(given.folder, given.basis)
    else:
        next_networks.generate(next_networks.tests(), given.folder / "tests")


if __name__ == "__main__":
    main()
