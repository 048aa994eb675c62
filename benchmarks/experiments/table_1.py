"""Storage, time and error of representations of single BRDFs; after Table 1 of Fan et al. 2022.

Every method sees values of a BRDF alone, not its parameters. Errors are taken at pairs of
directions that no method has seen; PSNR is that of a sphere in Urushi's studio. Measured materials
are averaged over the exchange of wi and wo, because most methods are reciprocal; the stand-ins for
MERL's favour NBRDF, because such networks made them.
"""

import math
import time
from collections.abc import Callable
from functools import cache, partial
from typing import Any

import jax
import numpy as np
from benchmarks import measures, sphere, timing
from benchmarks.experiment import NETWORKS, Experiment, Found, Options, kept
from benchmarks.measures import half_angle_pairs
from benchmarks.pictures import psnr
from benchmarks.rivals import ggx_fit, nbrdf, rainer
from benchmarks.rivals.nbrdf import size, training_pairs
from benchmarks.showing import interval, table
from benchmarks.subjects import SEED, Subject, subjects, training_set
from fan2022 import architecture as paper
from fan2022.pairs import stratified_pairs

import urushi
from urushi.core import direction_sets
from urushi.material.source import Source
from urushi.nets.weights import default_model

METHODS = (
    *("Rainer 2019", "Rainer 2020", "NBRDF", "GGX", "two GGX", "Urushi, encoded"),
    "Urushi, table",
)
#: Drawn samples of the trainings of one material (about three quarters are above the horizon), and
#: passes over them.
SAMPLES, PASSES = 1 << 16, {"NBRDF": 30, "Rainer 2019": 12}
#: Shared training of Rainer et al. 2020: materials of either kind, their pairs, walks, and steps;
#: pairs by which a new material is encoded.
SHARED, PAIRS, WALKS, STEPS, MEASURED = 640, 256, 64, 3000, 512
#: Pairs of E, of P and of L1, with the walks of their reference; L1's number is a fourth power.
REFERENCE = {"E": (512, 6144), "P": (512, 2048), "L1": (625, 2048)}
#: Pairs of the measurement of evaluations, and its turns.
EVALUATED, TURNS = 1 << 16, 5
#: Errors in the order of the tables: factor and unit.
ERRORS = {"E": (100, "%"), "P": (100, "%"), "L1": (1e3, "10⁻³/sr"), "PSNR": (1, "dB")}
#: Texels of a 4K texture, and bytes of a number.
TEXELS, BYTES = 4096**2, 4
#: Whether a method keeps sharp highlights, as the paper says.
PAPER = {"Rainer 2019": "no", "Rainer 2020": "no", "NBRDF": "yes", "Fan 2022": "yes"}


@cache
def networks() -> rainer.Unified:
    """The shared networks of Rainer et al. 2020, trained once and kept."""

    def trained() -> list[np.ndarray]:
        pairs = training_set(SHARED, PAIRS, WALKS, SEED + 1000)
        return jax.tree.leaves(rainer.train_unified(*pairs, steps=STEPS))

    structure = jax.tree.structure(rainer.untrained())
    return jax.tree.unflatten(structure, kept("rainer-2020-networks", trained))


def represent(method: str, subject: Subject, options: Options) -> Any:
    """The representation of a BRDF by a method; it has f(wi, wo) -> (N, 3)."""
    f, samples = subject.f, options.count(SAMPLES, 1 << 12)
    if method == "NBRDF":
        return nbrdf.train(f, passes=PASSES[method], samples=samples)
    if method == "Rainer 2019":
        return rainer.train(f, passes=PASSES[method], samples=samples)
    if method == "Rainer 2020":
        wi, wo = training_pairs(np.random.default_rng(SEED), 3 * MEASURED)
        wi, wo = wi[:MEASURED], wo[:MEASURED]
        return networks().encode(wi, wo, f(wi, wo))
    if method.endswith("GGX"):
        return ggx_fit.best(f, 1 if method == "GGX" else 2)
    source = Source(f, symmetric=True, noisy=subject.simulated is not None)
    return urushi.encode(source, options.weights, table=method.endswith("table"))


def measure(subject: Subject | None, options: Options) -> Found:
    """Errors and CPU seconds of the methods for a material, and E of the reference's noise.

    None: CPU times of an evaluation. A stack has no spheres and no seconds, most of which its walks
    would take.
    """
    if subject is None:
        return evaluation()
    rng, walked = np.random.default_rng((SEED, 1)), subject.simulated
    pairs = {
        "E": direction_sets.cosine_pairs(rng, REFERENCE["E"][0], lowest_cosine=0.02),
        "P": half_angle_pairs(rng, REFERENCE["P"][0]),
        "L1": stratified_pairs(rng, REFERENCE["L1"][0]),
    }
    truth, own = {}, 0.0
    for seed, (name, (wi, wo)) in enumerate(pairs.items()):
        if walked is not None:
            walks = options.count(REFERENCE[name][1], 16)
            truth[name], se = walked(wi, wo, walks, SEED + 2000 + seed)
            own = MEASURES["E"](truth[name] + se, truth[name], wi, wo) if name == "E" else own
        else:
            truth[name] = subject.f(wi, wo)
    found: Found = {"group": subject.group, "reference": own}
    original = None if walked else sphere.studio(subject.f)
    for method in METHODS:
        begin = time.process_time()
        model = represent(method, subject, options)
        seconds = time.process_time() - begin
        found[method] = {
            name: MEASURES[name](model.f(*pair), truth[name], *pair) for name, pair in pairs.items()
        }
        if original is not None:
            own = psnr(sphere.studio(model.f), original, sphere.mask())
            found[method] |= {"PSNR": own, "seconds": seconds}
    return found


#: E (mean over channels that are not black), the median of P, and L1 [1/sr]: (f_hat, f, wi, wo).
MEASURES: dict[str, Callable[..., Any]] = {
    "E": measures.error,
    "P": lambda f_hat, f, *_: np.median(measures.pair_error(f_hat, f)),
    "L1": lambda f_hat, f, *_: np.abs(f_hat - f).mean(),
}


def evaluation() -> dict[str, float]:
    """CPU time of a value of RGB by each method with NumPy [µs]."""
    surface = urushi.conductor(alpha=0.3, r0=(0.9, 0.6, 0.3))
    rng = np.random.default_rng(SEED)
    models: dict[str, Any] = {
        name: rainer.NeuralBtf(rainer.decoder(rng, latent), np.ones(latent, np.float32))
        for name, latent in zip(METHODS, (rainer.LATENT_2019, rainer.LATENT_2020), strict=False)
    }
    models["NBRDF"] = nbrdf.unpacked(rng.normal(0, 0.1, nbrdf.SIZE))
    models["Urushi"] = urushi.encode(urushi.coat(surface, 0.1, 1.5, 0.7, 1.0))
    pairs = direction_sets.cosine_pairs(rng, EVALUATED)
    calls = {name: partial(model.f, *pairs) for name, model in models.items()}
    times = timing.calls(calls, TURNS)
    return {name: 1e6 * value / EVALUATED for name, value in times.items()}


def storage() -> dict[str, tuple[int, int, str]]:
    """Numbers of a texel, of a decoder, and what one decoder serves, by method."""
    old, new = rainer.LATENT_2019, rainer.LATENT_2020
    decoders = [size(rainer.decoder(np.random.default_rng(0), latent)) for latent in (old, new)]
    own, evaluated = default_model(), paper.shapes(paper.EVALUATION).values()
    return {
        "Rainer 2019": (old, decoders[0], "a texture"),
        "Rainer 2020": (new, decoders[1], "all"),
        "NBRDF": (nbrdf.SIZE, 0, "a BRDF"),
        "Fan 2022": (3 * paper.LATENT, sum(map(math.prod, evaluated)), "all"),
        "Urushi": (3 * own.arch.latent, own.params["basis.rows"].size, "all"),
    }


def tables(found: Found) -> list[str]:
    """Tables: storage and times, then each error by method and group."""
    members: dict[str, list[Found]] = {}
    for case in found.values():
        if "group" in case:
            members.setdefault(case["group"], []).append(case)
    made = [_costs(found["evaluation"], members)] if "evaluation" in found and members else []
    for name in ERRORS:
        if known := {k: cases for k, cases in members.items() if name in cases[0]["NBRDF"]}:
            made.append(_errors(name, known))
    return made


def _costs(evaluation: dict[str, float], members: dict[str, list[Found]]) -> str:
    head = ["method", "numbers per texel", "per decoder", "one decoder for", "4K texture"]
    head += ["to represent", "to evaluate", "paper: keeps highlights"]
    rows = []
    for method, (texel, decoder, serves) in storage().items():
        size = BYTES * (TEXELS * texel + decoder) / 1e9
        cells = [method, f"{texel}", f"{decoder:,}", serves, f"{size:.2g} GB", "", ""]
        if method in evaluation:
            name = "Urushi, encoded" if method == "Urushi" else method
            cases = [case[name] for group in members.values() for case in group]
            median = float(np.median([case["seconds"] for case in cases if "seconds" in case]))
            spent = f"{median:.2g} s" if median > 0.1 else f"{1000 * median:.2g} ms"
            cells[-2:] = [spent, f"{evaluation[method]:.2g} µs"]
        rows.append([*cells, PAPER.get(method, "")])
    return table(head, rows)


def _errors(name: str, members: dict[str, list[Found]]) -> str:
    factor, unit = ERRORS[name]

    def short(value: float) -> str:
        return f"{float(f'{value:.2g}'):g}"

    def cell(method: str, cases: list[Found]) -> str:
        values = factor * np.array([case[method][name] for case in cases])
        low, high = map(short, interval(values))
        return f"{short(values.mean())} ({low}–{high})"

    rows = [[method, *(cell(method, cases) for cases in members.values())] for method in METHODS]
    if name == "E":
        own = [factor * np.mean([case["reference"] for case in c]) for c in members.values()]
        rows.append(["the reference's noise", *map(short, own)])
    heads = [f"{group} ({len(cases)})" for group, cases in members.items()]
    return table([f"{name} [{unit}]", *heads], rows)


EXPERIMENT = Experiment(
    lambda options: {"evaluation": None} | {s.name: s for s in subjects(options)},
    tables,
    measure,
    models=NETWORKS,
    minutes=45,
)
