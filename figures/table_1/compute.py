"""Storage, time and error of neural representations of single BRDFs.

    python -m figures.table_1.compute
    python -m figures.table_1.compute --methods BSDFNet

The second form measures some methods and keeps the results of all others.

Every method sees values of a BRDF alone, not its parameters. Errors are taken at pairs of
directions that no method has seen. Measured materials need the folder that URUSHI_TEST_DATA names,
and are left out without it.
"""

import argparse
import functools
import json
import time
from collections.abc import Callable, Sequence
from pathlib import Path
from typing import Any

import mitsuba as mi
import numpy as np
from benchmarks.rivals import metalayer, nbrdf, rainer

import urushi
from figures import results
from figures.table_1.materials import SEED, Subject, Walked, subjects, training_set
from urushi.core import direction_sets, error_metrics
from urushi.files import atomic_write
from urushi.material.source import Source
from urushi.nets.weights import default_model

FOLDER = Path(__file__).parent
PARTS = results.parts_folder("table_1")
METHODS = ("Rainer 2019", "Rainer 2020", "NBRDF", "BSDFNet", "Urushi, encoded")
#: Drawn samples of the trainings of one material (about three quarters are above the horizon), and
#: passes over them.
SAMPLES, PASSES = 1 << 16, {"NBRDF": 30, "BSDFNet": 12, "Rainer 2019": 12}
#: Shared training of Rainer et al. 2020: materials of either kind, their pairs, walks, and steps;
#: pairs by which a new material is encoded.
SHARED, PAIRS, WALKS, STEPS, MEASURED = 640, 256, 64, 3000, 512
#: Pairs of E, of P and of L1, with the walks of their reference; L1's number is a fourth power.
REFERENCE = {"E": (512, 6144), "P": (512, 2048), "L1": (625, 2048)}
#: Pairs of the measurement of evaluations, and its turns.
EVALUATED, TURNS = 1 << 16, 5


def main() -> None:
    """Compute what is missing and write results.json."""
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--methods", nargs="+", choices=METHODS, default=METHODS, metavar="METHOD")
    chosen = parser.parse_args().methods
    mi.set_variant("llvm_ad_rgb")
    parts: dict[str, Callable[[], Any]] = {}
    if "Rainer 2020" in chosen:
        parts["shared"] = shared
    parts["evaluation"] = functools.partial(evaluation, chosen)
    parts |= {subject.name: functools.partial(measure, subject, chosen) for subject in subjects()}
    path = FOLDER / "results.json"
    if tuple(chosen) == METHODS:
        found = results.collect(PARTS, parts)
        head = {"weights": default_model().fingerprint}
        head |= {name: found.pop(name) for name in ("shared", "evaluation")}
        groups = {subject.name: subject.group for subject in subjects()}
        names = dict.fromkeys(groups.values())
        head["groups"] = {name: [n for n in groups if groups[n] == name] for name in names}
        results.write(path, {**head, "materials": found})
    else:
        found = results.collect(PARTS / ", ".join(chosen), parts)
        results.write(path, merged(json.loads(path.read_text()), found))


def merged(stored: dict[str, Any], found: dict[str, Any]) -> dict[str, Any]:
    """Results of all methods in which those of some are replaced by others, or added."""
    head = {name: value for name, value in stored.items() if name != "materials"}
    if "shared" in found:
        head["shared"] = found["shared"]
    head["evaluation"] = stored["evaluation"] | found["evaluation"]
    materials = {}
    for name, old in stored["materials"].items():
        materials[name] = old | found.get(name, {})
    return {**head, "materials": materials}


def shared() -> dict[str, Any]:
    """Train the shared networks of Rainer et al. 2020 and keep them; CPU time and materials."""
    data = training_set(SHARED, PAIRS, WALKS, SEED + 1000)
    begin = time.process_time()
    networks = rainer.train_unified(*data, steps=STEPS)
    seconds = time.process_time() - begin
    layers = {
        f"{part}.{i}.{kind}": array
        for part in ("first", "second", "decoder")
        for i, layer in enumerate(getattr(networks, part))
        for kind, array in zip(("weights", "bias"), layer, strict=True)
    }
    with atomic_write(PARTS / "shared.npz") as temporary, temporary.open("wb") as file:
        np.savez(file, **layers)
    return {"seconds": round(seconds, 1), "materials": 2 * SHARED}


@functools.cache
def networks() -> rainer.Unified:
    """The shared networks that `shared` has kept."""
    with np.load(PARTS / "shared.npz") as file:
        layers = dict(file)

    def part(name: str) -> rainer.Layers:
        count = sum(key.startswith(f"{name}.") for key in layers) // 2
        keys = [f"{name}.{i}" for i in range(count)]
        return tuple((layers[f"{key}.weights"], layers[f"{key}.bias"]) for key in keys)

    return rainer.Unified(part("first"), part("second"), part("decoder"))


def represent(method: str, source: Any) -> Any:
    """The representation of a BRDF by a method; it has f(wi, wo) -> (N, 3)."""
    if method == "NBRDF":
        return nbrdf.train(source.f, passes=PASSES[method], samples=SAMPLES)
    if method == "BSDFNet":
        return metalayer.train(source.f, passes=PASSES[method], samples=SAMPLES)
    if method == "Rainer 2019":
        return rainer.train(source.f, passes=PASSES[method], samples=SAMPLES)
    if method == "Rainer 2020":
        _, wi, wo = nbrdf.training_pairs(np.random.default_rng(SEED), 3 * MEASURED)
        wi, wo = wi[:MEASURED], wo[:MEASURED]
        return networks().encode(wi, wo, source.f(wi, wo))
    function = Source(source.f, symmetric=True, noisy=isinstance(source, Walked))
    return urushi.encode(function, table=False)


def measure(subject: Subject, methods: Sequence[str]) -> dict[str, Any]:
    """E, P, L1 and CPU seconds of the methods for a material, and E of the reference's noise.

    There are no seconds for a stack, whose walks would take most of them.
    """
    rng = np.random.default_rng((SEED, 1))
    pairs = {
        "E": direction_sets.cosine_pairs(rng, REFERENCE["E"][0], lowest_cosine=0.02),
        "P": direction_sets.half_angle_pairs(rng, REFERENCE["P"][0]),
        "L1": direction_sets.stratified_pairs(rng, REFERENCE["L1"][0]),
    }
    truth, own = {}, 0.0
    for seed, (name, (wi, wo)) in enumerate(pairs.items()):
        if isinstance(subject.source, Walked):
            walks = REFERENCE[name][1]
            truth[name], se = subject.source.simulated(wi, wo, walks, SEED + 2000 + seed)
            own = errors("E", truth[name] + se, truth[name], wi, wo) if name == "E" else own
        else:
            truth[name] = subject.source.f(wi, wo)
    found: dict[str, Any] = {"reference": float(f"{own:.3g}")}
    for method in methods:
        begin = time.process_time()
        model = represent(method, subject.source)
        seconds = time.process_time() - begin
        values = {
            name: errors(name, model.f(*pair), truth[name], *pair) for name, pair in pairs.items()
        }
        if not isinstance(subject.source, Walked):  # walks would take most of the time
            values["seconds"] = seconds
        found[method] = {name: float(f"{value:.4g}") for name, value in values.items()}
    return found


def errors(name: str, f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """E (mean over channels that are not black), the median of P, or L1 [1/sr]."""
    if name == "E":
        lit = f.max(axis=0) > 0
        cosines = wi[:, 2], wo[:, 2]
        return float(error_metrics.stack_error(f_hat.T[lit], f.T[lit], *cosines).mean())
    if name == "P":
        return float(np.median(error_metrics.pair_error(f_hat, f)))
    return float(np.abs(f_hat - f).mean())


def evaluation(methods: Sequence[str]) -> dict[str, float]:
    """CPU time of a value of RGB by each of the methods with NumPy [µs], the least of `TURNS`."""
    surface = urushi.conductor(alpha=0.3, r0=(0.9, 0.6, 0.3))
    code = urushi.encode(urushi.coat(surface, 0.1, 1.5, 0.7, 1.0))
    rng = np.random.default_rng(SEED)
    layers = rainer.initial(rng, rainer.decoder_sizes(rainer.LATENT_2019))
    models: dict[str, Any] = {
        "Rainer 2019": rainer.NeuralBtf(layers, np.ones(rainer.LATENT_2019, np.float32)),
        "Rainer 2020": rainer.NeuralBtf(
            rainer.initial(rng, rainer.decoder_sizes(rainer.LATENT_2020)),
            np.ones(rainer.LATENT_2020, np.float32),
        ),
        "NBRDF": nbrdf.Nbrdf(rng.normal(0, 0.1, nbrdf.SIZE)),
        "BSDFNet": metalayer.BsdfNet(metalayer.initial(rng)),
        "Urushi": code,
    }
    names = {method.split(",")[0] for method in methods}
    models = {name: model for name, model in models.items() if name in names}
    pairs = direction_sets.cosine_pairs(rng, EVALUATED)
    least = dict.fromkeys(models, np.inf)
    for _ in range(TURNS):
        for name, model in models.items():
            begin = time.process_time()
            model.f(*pairs)
            least[name] = min(least[name], time.process_time() - begin)
    return {name: float(f"{1e6 * value / EVALUATED:.3g}") for name, value in least.items()}


if __name__ == "__main__":
    main()
