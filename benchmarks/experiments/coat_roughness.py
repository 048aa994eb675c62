"""Effective roughness of a metal under a rough coat, and coat darkening: fits and their errors.

The reflection of the metal through the coat is computed by light transport (`material.adding`), at
four angles of incidence, without the coat's own reflection. Its effective roughness is that of the
GGX lobe, of equal energy at each angle, with the least mean error; the error of a lobe is the sum
of |lobe - light| over the sum of the light. `python -m benchmarks.experiments.coat_roughness` fits
the constants of docs/coat_formulas.py to the stored results, prints them, and writes all results as
docs/coat_roughness.csv.
"""

import csv
import runpy
from collections.abc import Callable
from functools import partial
from types import SimpleNamespace
from typing import Any

import numpy as np
from benchmarks import experiment
from benchmarks.experiment import Experiment, Found, Options, Pictures
from benchmarks.showing import figure, interval, table
from scipy.optimize import least_squares, minimize_scalar

import urushi
from urushi.checks import CoatParameters
from urushi.core import fresnel
from urushi.core.microfacet import half_vector, lobe_shape
from urushi.core.namespace import NUMPY, Components
from urushi.core.quadrature import half_vector_rule
from urushi.material.coated_values import coated_f

DOCS = experiment.ROOT / "docs"
INDICES = (1.1, 1.33, 1.5, 1.75, 2.0, 2.5, 3.0)
ROUGHNESS = (0.1, 0.2, 0.35, 0.5, 0.7, 1.0)
ANGLES = (0.01, 30.0, 45.0, 60.0)
#: Reflectances of the bases; the roughness of the lobe is that of the second.
BASES = (0.2, 0.5, 0.9)
#: The functions of docs/coat_formulas.py.
FORMULAS: Any = SimpleNamespace(**runpy.run_path(str(DOCS / "coat_formulas.py")))
#: Azimuths of the quadrature in each half of the range; walks of a pair, their seeds, and stacks.
AZIMUTHS, WALKS, SEEDS = 6, 2048, 4
WALKED = ((1.5, 0.1, 0.35), (1.5, 0.5, 0.35), (1.33, 0.35, 0.2), (2.0, 0.5, 0.5), (2.5, 1.0, 0.7))


class Nodes:
    """Pairs (A, M, 3) of the angles of incidence, and weights (A, M) that integrate f cos."""

    def __init__(self, angles: tuple[float, ...] = ANGLES, azimuths: int = AZIMUTHS) -> None:
        t = np.radians(angles)
        wi = np.stack([np.sin(t), 0 * t, np.cos(t)], axis=-1)
        self.wo, weights = half_vector_rule(wi, azimuths=azimuths)
        self.wi = np.broadcast_to(wi[:, None], self.wo.shape)
        self.weights = weights * self.wo[..., 2]
        self.flat = [w.reshape(-1, 3).astype(np.float32) for w in (self.wi, self.wo)]

    def lobe(self, alpha: float, eta: float = 1.0) -> np.ndarray:
        """The GGX lobe of white facets below a smooth interface of an index; 1: none."""
        i, o = (refracted(w, eta) for w in (self.wi, self.wo))
        lobe = lobe_shape(alpha, i, o, half_vector(i, o, NUMPY), NUMPY)
        for w in (self.wi, self.wo) if eta != 1 else ():
            lobe = lobe * (1 - fresnel.dielectric(w[..., 2], eta, NUMPY)[0])
        return lobe

    def error(self, f: np.ndarray, alpha: float, eta: float = 1.0) -> float:
        """Error of a lobe of equal energy at each angle, a mean over the angles of f (A, M)."""
        lobe, energy = self.lobe(alpha, eta), (f * self.weights).sum(1, keepdims=True)
        lobe = lobe * energy / (lobe * self.weights).sum(1, keepdims=True)
        return float((np.abs(lobe - f) * self.weights / energy).sum(1).mean())

    def best(self, f: np.ndarray, eta: float = 1.0) -> tuple[float, float]:
        """Roughness of the lobe of the least error, which may exceed 1, and its error."""
        found = minimize_scalar(
            lambda x: self.error(f, np.exp(x), eta),
            bounds=np.log([0.004, 3.0]),
            method="bounded",
            options={"xatol": 1e-3},
        )
        return float(np.exp(0.5 * found.x)), float(found.fun)


def refracted(w: np.ndarray, eta: float) -> Components:
    x, y, z = np.moveaxis(w, -1, 0)
    return Components(x / eta, y / eta, np.sqrt(1 - (1 - z * z) / eta**2))


def light(eta: float, coat: float, base: Any, nodes: Nodes) -> np.ndarray:
    """f (A, M, C) of the light that the base, a material, reflects through a clear coat."""
    columns = (np.float64(x) for x in (coat**2, eta, 1.0, 0.0, 0.0))
    f = coated_f(base, CoatParameters(*columns), *nodes.flat)
    return f.reshape(*nodes.weights.shape, -1).astype(np.float64)


#: Roughness of the base by other rules: (eta, coat, base) -> roughness, and whether it is inside.
RULES: dict[str, tuple[Callable[[float, float, float], float], bool]] = {
    "none": (lambda n, c, b: b, False),
    "OpenPBR 1.1": (lambda n, c, b: min(1.0, b**4 + 2 * c**4) ** 0.25, False),
    "OpenPBR 239": (lambda n, c, b: min(1.0, b**4 + (1 - 1 / n) * c**4) ** 0.25, False),
    "fit": (lambda n, c, b: FORMULAS.base_roughness(n, c, b), False),
    "fit, refracted": (lambda n, c, b: FORMULAS.base_roughness_inside(n, c, b), True),
}


def index(eta: float, _: Options) -> list[dict[str, Any]]:
    """Rows for all roughnesses of coat and base, metals and then a Lambertian base."""
    nodes, straight, rows = Nodes(), Nodes(ANGLES[:1], 2), []
    ends = {"normal": Nodes(ANGLES[:1]), "oblique": Nodes(ANGLES[-1:])}
    for base in (*ROUGHNESS, None):
        colours = urushi.diffuse(BASES) if base is None else urushi.conductor(base**2, BASES)
        material = urushi.encode(colours)
        for coat in ROUGHNESS:
            row: dict[str, Any] = {"eta": eta, "coat": coat, "base": base}
            lit = light(eta, coat, material, straight)
            bare = material.f(*straight.flat).reshape(lit.shape)
            for name, x in (("coated", lit), ("bare", bare)):
                row[name] = np.einsum("amc,am->c", x, straight.weights)
            if base is not None:
                grey = urushi.encode(urushi.conductor(base**2, BASES[1]))
                f = light(eta, coat, grey, nodes)[..., 0]
                row["errors"] = errors = {}
                row["effective"], errors["best"] = nodes.best(f)
                row["inside"], errors["best, refracted"] = nodes.best(f, eta)
                for (name, own), part in zip(ends.items(), f[[0, -1]], strict=True):
                    row[name] = own.best(part[None])[0]
                for name, (rule, within) in RULES.items():
                    alpha = max(rule(eta, coat, base), 0.06) ** 2
                    errors[name] = nodes.error(f, alpha, eta if within else 1)
            rows.append(row)
    return rows


def walk(options: Options) -> list[dict[str, float]]:
    """Effective roughness by the walk, the mean and standard error of some seeds."""
    nodes, rows = Nodes(), []
    for eta, coat, base in WALKED:
        bases = urushi.conductor(base**2, BASES[1]), urushi.diffuse(0.0)
        stack, black = (urushi.coat(x, coat**2, eta) for x in bases)
        own = urushi.simulate(black, *nodes.flat, walks=2, progress=False)[0]
        found = []
        for seed in range(SEEDS):
            walks = options.count(WALKS, 2)
            f, _ = urushi.simulate(stack, *nodes.flat, walks=walks, seed=seed, progress=False)
            found.append(nodes.best((f - own)[:, 0].reshape(nodes.weights.shape).astype(float))[0])
        mean, se = float(np.mean(found)), float(np.std(found, ddof=1) / SEEDS**0.5)
        rows.append({"eta": eta, "coat": coat, "base": base, "effective": mean, "se": se})
    return rows


def metals(found: Found) -> list[dict[str, Any]]:
    """The rows of metals, of all indices."""
    return [row for name in found if name != "walk" for row in found[name] if row["base"]]


def columns(rows: list[dict[str, Any]], *names: str) -> list[np.ndarray]:
    return [np.array([row[name] for row in rows]) for name in names]


def internal(row: dict[str, Any]) -> float:
    """K for which (1 - K) / (1 - K E) has the coated albedos' ratio of the reflectances' ends."""
    ratio = np.array(row["coated"]) / np.array(row["bare"])
    q, bare = ratio[-1] / ratio[0], row["bare"]
    return float((q - 1) / (q * bare[-1] - bare[0]))


def darkened(found: Found, constants: tuple[float, ...] = ()) -> dict[str, np.ndarray]:
    """Coated over bare albedo of metals (N, 2), of the darker over that of the brightest, by rules.

    Light that rough surfaces lose cancels in it. Diffuse light has the K of a Lambertian base under
    the same coat. constants: of the fit; by default those of docs/coat_formulas.py.
    """
    parts = [row for name in found if name != "walk" for row in found[name]]
    diffuse = {(r["eta"], r["coat"]): internal(r) for r in parts if r["base"] is None}
    rows = metals(found)
    eta, base, bare, coated = columns(rows, "eta", "base", "bare", "coated")
    wide = np.array([diffuse[row["eta"], row["coat"]] for row in rows])
    smooth = ((eta - 1) / (eta + 1)) ** 2
    rules = {
        "none": 0 * eta,
        "OpenPBR 1.1": smooth + (wide - smooth) * base,
        "fit": FORMULAS.internal_reflection(eta, base, wide, *constants),
    }
    ratio = coated / bare
    made = {"transport": ratio[:, :-1] / ratio[:, -1:]}
    for name, k in rules.items():
        delta = FORMULAS.darkening(k[:, None], bare)
        made[name] = delta[:, :-1] / delta[:, -1:]
    return made


def tables(found: Found) -> list[str]:
    """Errors of the rules for the roughness and for the darkening, and the check by the walk."""
    rows = metals(found)
    if not rows or "walk" not in found:
        return []
    names = "eta", "coat", "base", "effective", "inside"
    *given, effective, inside = columns(rows, *names)
    lines = []
    for name in rows[0]["errors"]:
        errors, cells = np.array([row["errors"][name] for row in rows]), ["–", "–"]
        if name in RULES:
            rule, within = RULES[name]
            off = np.array([rule(*x) for x in zip(*given, strict=True)])
            off -= inside if within else effective
            cells = [f"{np.sqrt((off**2).mean()):.3f}", f"{np.abs(off).max():.3f}"]
        lines.append([name, *cells, *shares(errors)])
    head = ["rule for the roughness", "rms error of r", "largest", "error of the lobe", "p95"]
    made, ratios = [table(head, lines)], darkened(found)
    transport, lines = ratios.pop("transport"), []
    for name, ratio in ratios.items():
        off = np.abs(ratio / transport - 1)
        lines.append([name, *shares(off.mean(1)), f"{100 * off.max():.0f} %"])
    made.append(table(["rule for the darkening", "error, mean", "p95", "largest"], lines))
    known, lines = {tuple(row[x] for x in names[:3]): row["effective"] for row in rows}, []
    for row in found["walk"]:
        place = tuple(row[x] for x in names[:3])
        own = f"{row['effective']:.4f} ± {row['se']:.4f}"
        lines.append([*map(str, place), f"{known[place]:.4f}", own])
    return [*made, table(["index", "coat", "base", "r by transport", "by the walk"], lines)]


def shares(errors: np.ndarray) -> list[str]:
    """Mean of errors, with its interval, and their 95th percentile."""
    low, high = (f"{100 * x:.1f}" for x in interval(errors))
    p95 = f"{100 * np.percentile(errors, 95):.0f} %"
    return [f"{100 * errors.mean():.1f} % ({low} to {high})", p95]


def plot(found: Found, _: Pictures) -> Any:
    """Effective roughness over the coat's, with the spread over angles, and the rules."""
    picture = figure(10, 3.4)
    axes = picture.subplots(1, 3, sharey=True)
    line = np.linspace(0.05, 1, 60)
    for axis, eta in zip(axes, (1.33, 1.5, 2.0), strict=True):
        for base, colour in zip((0.1, 0.35, 0.7), ("#0072b2", "#d55e00", "#009e73"), strict=True):
            own = [r for r in metals(found) if r["eta"] == eta and r["base"] == base]
            x, y, low, high = columns(own, "coat", "effective", "normal", "oblique")
            bars = np.abs([y - low, high - y])
            axis.errorbar(x, y, bars, fmt="o", color=colour, markersize=4, capsize=2)
            axis.plot(line, FORMULAS.base_roughness(eta, line, base), color=colour)
            axis.plot(line, np.minimum(1, base**4 + 2 * line**4) ** 0.25, ":", color=colour)
        axis.set(title=f"index {eta:g}", xlabel="coat_roughness")
        axis.grid(alpha=0.3)
    axes[0].set_ylabel("roughness of the base's lobe")
    return picture


def fit(found: Found) -> dict[str, np.ndarray]:
    """The constants of docs/coat_formulas.py by least squares of r, and of the darkening."""
    rows, ratio = metals(found), darkened(found)["transport"]
    eta, coat, base, effective, inside = columns(rows, "eta", "coat", "base", "effective", "inside")
    outer, inner = FORMULAS.base_roughness, FORMULAS.base_roughness_inside
    problems: dict[str, Any] = {  # residuals of the constants, and where to begin
        "outside": (lambda x: outer(eta, coat, base, *x) - effective, outer.__defaults__),
        "inside": (lambda x: inner(eta, coat, base, *x) - inside, inner.__defaults__),
        "internal": (
            lambda x: (darkened(found, x)["fit"] / ratio - 1).ravel(),
            FORMULAS.internal_reflection.__defaults__[1:],
        ),
    }
    return {name: least_squares(*problem).x for name, problem in problems.items()}


def main() -> None:
    """Print the fitted constants and write the table of all results."""
    stored = experiment.stored("coat_roughness")
    assert stored is not None
    for name, constants in fit(stored["cases"]).items():
        print(name, np.round(constants, 3))
    with (DOCS / "coat_roughness.csv").open("w", newline="") as file:
        rows = map(line, metals(stored["cases"]))
        csv.writer(file, lineterminator="\n").writerows([COLUMNS, *rows])


#: Columns of the table of all results, and what they show of a row.
COLUMNS = {
    "coat_ior": "eta",
    "coat_roughness": "coat",
    "base_roughness": "base",
    "effective": "effective",
    "at 0 degrees": "normal",
    "at 60 degrees": "oblique",
    "error of the lobe": "best",
    "effective, refracted": "inside",
    "error of the lobe, refracted": "best, refracted",
    "internal reflection K": "K",
}


def line(row: dict[str, Any]) -> list[float]:
    """A row of the table of all results."""
    values = row | row["errors"] | {"K": internal(row)}
    return [round(values[x], 4) for x in COLUMNS.values()]


EXPERIMENT = Experiment(
    cases=lambda _: {f"index {eta:g}": partial(index, eta) for eta in INDICES} | {"walk": walk},
    tables=tables,
    plot=plot,
    pages=("docs/coat_roughness.md",),
    minutes=6,
)

if __name__ == "__main__":
    main()
