"""Effect of refinement on codes: `python -m benchmarks.quality.refinement [MEASURED...]`.

About two minutes on two cores. Prints the error E (docs/conventions.md) in per cent, as a mean over
stacks and channels, of materials whose codes are the encoder's, refined, and refined without the
term that keeps codes close to the encoder's. The columns on the left are of the encoded material
itself; those on the right are of coats layered over it, which needs codes of the kind that the
layering network was trained on.

- Stored groups of `benchmarks.evaluation`: bare bottoms; stacks encoded whole, and the uppermost
  coat layered over the encoded rest.
- Unusual materials, of kinds that no training data contain, and MEASURED files (MERL or RGL). The
  reference under coats is Mitsuba's plugin `layered`; the last column is its noise. Coats over MERL
  files are left out, because Mitsuba does not read them.
"""

import argparse
from collections.abc import Callable, Iterator
from pathlib import Path
from typing import Any, NamedTuple

import mitsuba as mi
import numpy as np
from benchmarks.evaluation import benchmark, predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import GROUPS, Group, Samples

import urushi
from urushi.checks import CoatParameters
from urushi.core import direction_sets, error_metrics
from urushi.material import Material, fit, layer
from urushi.material.encode import evaluate_source, material_from_values, required_pairs
from urushi.material.layer import layer_texels
from urushi.nets import weights
from urushi.nets.weights import Model

#: Pairs of E for an unusual material; the first of them are simulated under coats; walks per pair.
PAIRS, COATED_PAIRS, WALKS = 400, 60, 4096

#: Coats of unusual materials: a smooth clear one, and a rough one with a scattering medium.
COATS = (
    {"alpha": 0.05, "eta": 1.5, "albedo": 0.0, "sigma_t": 0.0, "g": 0.0},
    {"alpha": 0.2, "eta": 1.4, "albedo": 0.9, "sigma_t": 1.0, "g": 0.3},
)

#: Functions from values (P, C) to a material: by the encoder, refined, refined freely.
Encoders = dict[str, Callable[[np.ndarray], Material]]


class Errors(NamedTuple):
    """E for each of the `Encoders`, in their order; NaN where it is not measured."""

    encoded: list[float]
    layered: list[float]
    noise: float = np.nan


def encoders(model: Model) -> Encoders:
    """The encoders of the three columns."""

    def free(values: np.ndarray) -> Material:
        default, fit.ANCHOR_HOLD = fit.ANCHOR_HOLD, 0.0
        try:
            return material_from_values(values, model, refine=True)
        finally:
            fit.ANCHOR_HOLD = default

    return {
        "encoder": lambda values: material_from_values(values, model),
        "refined": lambda values: material_from_values(values, model, refine=True),
        "free": free,
    }


def stored(make: Encoders, group: Group, samples: Samples, model: Model) -> Errors:
    """E of a stored group: stacks encoded whole, and the uppermost coat over the encoded rest."""
    pairs = required_pairs(None, model, table=False)
    wi, wo = (np.broadcast_to(w, (len(samples.table), *w.shape)) for w in pairs)
    bottoms = sampling.evaluate_bottoms(samples.table, wi, wo)
    coats = group.distribution.coats

    def error(codes: np.ndarray) -> float:
        made = predict.split(Material(codes, model))
        f_hat = predict.evaluate(made, samples.wi, samples.wo)
        return float(sampling.stack_errors(f_hat, samples).mean())

    whole = samples.probed[coats] if coats else bottoms
    encoded = [error(to_code(whole.T).latents) for to_code in make.values()]
    if not coats:
        return Errors(encoded, [np.nan] * len(make))
    rest = samples.probed[coats - 1] if coats > 1 else bottoms
    coat = {name: getattr(samples.table, name)[:, 0] for name in CoatParameters._fields}
    # In single precision, the smallest width may be rounded below 0.01.
    coat["alpha"] = np.maximum(coat["alpha"].astype(np.float64), 0.01)
    layered = [
        error(layer_texels(model, to_code(rest.T).anchors, CoatParameters(**coat)))
        for to_code in make.values()
    ]
    return Errors(encoded, layered)


def lobe(alpha: float, colour: tuple[float, float, float]) -> dict[str, Any]:
    """A GGX lobe as a BSDF of Mitsuba."""
    return {
        "type": "roughconductor",
        "distribution": "ggx",
        "material": "none",
        "alpha": alpha,
        "specular_reflectance": {"type": "rgb", "value": colour},
    }


def three_lobes(*alphas: float) -> dict[str, Any]:
    """Three lobes of different colours."""
    colours = (0.9, 0.6, 0.3), (0.3, 0.6, 0.9), (0.5, 0.5, 0.5)
    first, second, third = map(lobe, alphas, colours)
    pair = {"type": "blendbsdf", "weight": 0.5, "first": first, "second": second}
    return {"type": "blendbsdf", "weight": 0.4, "first": pair, "second": third}


def principled(**parameters: float) -> dict[str, Any]:
    """A brown `principled` BSDF."""
    return {
        "type": "principled",
        "base_color": {"type": "rgb", "value": (0.6, 0.2, 0.05)},
        **parameters,
    }


def unusual_materials(files: list[Path]) -> Iterator[tuple[str, Any, dict[str, Any] | None]]:
    """Name, source for `encode`, and description for Mitsuba, if it has one."""
    described = {
        "three lobes, 0.02 0.1 0.5": three_lobes(0.02, 0.1, 0.5),
        "three lobes, 0.05 0.3 0.8": three_lobes(0.05, 0.3, 0.8),
        "three lobes, 0.01 0.02 0.04": three_lobes(0.01, 0.02, 0.04),
        "principled, clear coat": principled(
            roughness=0.5, clearcoat=1.0, clearcoat_gloss=0.9, metallic=0.3
        ),
        "principled, sheen": principled(roughness=0.9, sheen=1.0, sheen_tint=0.5),
    }
    for name, description in described.items():
        yield name, mi.load_dict(description), description
    for path in files:
        is_rgl = path.suffix == ".bsdf"
        yield (
            path.stem,
            urushi.load_measured(path),
            {"type": "measured", "filename": str(path)} if is_rgl else None,
        )


def unusual(
    make: Encoders, source: Any, description: dict[str, Any] | None, model: Model
) -> Errors:
    """E of an unusual material, encoded and under coats."""
    wi, wo = direction_sets.cosine_pairs(np.random.default_rng(5), PAIRS)
    values = evaluate_source(source, *required_pairs(source, model)).values
    made = [to_code(values) for to_code in make.values()]
    truth = evaluate_source(source, wi, wo).values
    encoded = [error(material.f(wi, wo), truth, wi, wo) for material in made]
    if description is None:
        return Errors(encoded, [np.nan] * len(make))
    wi, wo = wi[:COATED_PAIRS], wo[:COATED_PAIRS]
    by_coat, noise = [], []
    for coat in COATS:
        truth, deviation = simulated(coat, description, wi, wo)
        noise.append(error(truth + deviation, truth, wi, wo))
        top = urushi.dielectric(coat["alpha"], coat["eta"])
        medium = {name: coat[name] for name in ("albedo", "sigma_t", "g")}
        over = [layer(top, material, **medium).f(wi, wo) for material in made]
        by_coat.append([error(f_hat, truth, wi, wo) for f_hat in over])
    return Errors(encoded, list(np.mean(by_coat, axis=0)), float(np.mean(noise)))


def simulated(
    coat: dict[str, float], bottom: dict[str, Any], wi: np.ndarray, wo: np.ndarray
) -> tuple[np.ndarray, np.ndarray]:
    """Mean and standard error (N, 3) of a coat over a Mitsuba BSDF by random walks."""
    from urushi.mitsuba.reading import probing

    parameters = {name: value for name, value in coat.items() if name != "eta"}
    description = {"type": "layered", "int_ior": coat["eta"], "ext_ior": 1.0, **parameters}
    bsdf = mi.load_dict({**description, "bottom": bottom})
    # The BSDF does not depend on uv, but the seeds of its walks do.
    uv = np.random.default_rng(3).random((len(wi) * WALKS, 2))
    f = probing.bsdf_values(bsdf, np.repeat(wi, WALKS, axis=0), np.repeat(wo, WALKS, axis=0), uv)
    walks = f.reshape(len(wi), WALKS, -1)
    return walks.mean(axis=1), walks.std(axis=1) / np.sqrt(WALKS)


def error(f_hat: np.ndarray, f: np.ndarray, wi: np.ndarray, wo: np.ndarray) -> float:
    """E, the mean over channels of values (N, C)."""
    cosines = (np.broadcast_to(w[:, 2], f.T.shape) for w in (wi, wo))
    return float(error_metrics.stack_error(f_hat.T, f.T, *cosines).mean())


def show(name: str, errors: Errors) -> None:
    """Print one line."""
    columns = [*errors.encoded, *errors.layered, errors.noise]
    cells = ("" if np.isnan(e) else f"{100 * e:.2f}" if e < 1e3 else "diverges" for e in columns)
    print(f"{name:32}" + "".join(f"{cell:>10}" for cell in cells), flush=True)


def main() -> None:
    """Print the table."""
    parser = argparse.ArgumentParser(
        prog="python -m benchmarks.quality.refinement",
        description=__doc__,
        formatter_class=argparse.RawDescriptionHelpFormatter,
    )
    parser.add_argument("--weights", help="networks: a name or file; default: the default ones")
    parser.add_argument("measured", type=Path, nargs="*", help="MERL or RGL files")
    options = parser.parse_args()
    mi.set_variant("llvm_ad_rgb")
    model = weights.find(options.weights)
    make = encoders(model)
    groups = tuple(
        group
        for group in GROUPS
        if group.distribution.coats < 3 and len(group.probed) == group.distribution.coats
    )
    sets = benchmark.read(groups=groups)

    print(f"{'':32}{'encoded':>30}{'layered over it':>30}")
    print(f"{'E [%]':32}" + "".join(f"{name:>10}" for name in (*make, *make, "noise")))
    found = []
    for group in groups:
        found.append(stored(make, group, sets[group.name], model))
        show(group.name, found[-1])
    show("mean of these", mean(found))
    found = []
    for name, source, description in unusual_materials(options.measured):
        found.append(unusual(make, source, description, model))
        show(name, found[-1])
    show("median of these", median(found))


def mean(found: list[Errors]) -> Errors:
    """Means of the columns, over what was measured."""
    encoded, layered = (np.nanmean(columns, axis=0) for columns in _columns(found))
    return Errors(list(encoded), list(layered))


def median(found: list[Errors]) -> Errors:
    """Medians of the columns: one diverging material would decide a mean."""
    encoded, layered = (np.nanmedian(columns, axis=0) for columns in _columns(found))
    return Errors(list(encoded), list(layered))


def _columns(found: list[Errors]) -> tuple[list[list[float]], list[list[float]]]:
    return [e.encoded for e in found], [e.layered for e in found]


if __name__ == "__main__":
    main()
