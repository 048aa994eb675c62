"""Laws of physics that materials should keep, each measured by one figure.

The materials are those of constants, which have tables by light transport.
"""

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np
from benchmarks.evaluation import predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import Group, Samples
from benchmarks.measures import DARK_OFFSET

from urushi.checks import CoatParameters
from urushi.material import Material
from urushi.material.layer import layer_material
from urushi.nets.weights import Model
from urushi.train.distribution import Extended

#: Number of stacks that absorb nothing, per number of coats and kind of bottom; numbers of coats.
WHITE_STACKS, WHITE_COATS = 16, (1, 2, 3, 5)

#: A coat that changes almost nothing, and the allowed E to the bare bottom.
VANISHING = CoatParameters(*map(np.array, (0.01, 1.001, 0.5, 0.0, 0.0)))
VANISHING_ERROR = 0.01

#: Absorption sigma_a of the coats in the test of absorption, at a fixed scattering.
ABSORPTION = np.linspace(0.0, 4.0, 9)

#: Rises of f below this fraction are rounding errors of single precision.
RISE = 1e-5


@dataclass(frozen=True)
class Figure:
    """The worst deviation from one law.

    Attributes:
        name: the law in words.
        value: the figure, in `unit`.
        limit: allowed value; None if the figure is only reported.
        lower: whether `limit` is a lower bound.
    """

    name: str
    value: float
    unit: str
    limit: float | None = None
    lower: bool = False

    @property
    def kept(self) -> bool | None:
        """Whether the law is kept; None without a limit."""
        if self.limit is None:
            return None
        return bool(self.value > self.limit if self.lower else self.value <= self.limit)


def measure(
    model: Model, sets: Mapping[str, Samples], materials: Mapping[str, list[Material]]
) -> list[Figure]:
    """All laws, on the `materials` of the groups and on stacks of this module."""
    return [
        *reciprocity_and_sign(sets, materials),
        *albedo_excess(sets, materials),
        white_albedo(model),
        vanishing_coat(model, sets),
        *absorption(model),
    ]


def reciprocity_and_sign(
    sets: Mapping[str, Samples], materials: Mapping[str, list[Material]]
) -> list[Figure]:
    """Number of pairs whose value changes if wi and wo are exchanged; and the smallest value."""
    differ, least = 0, np.inf
    for name, group in materials.items():
        wi, wo = sets[name].wi, sets[name].wo
        forward, backward = (predict.evaluate(group, *pairs) for pairs in ((wi, wo), (wo, wi)))
        differ += int((forward != backward).sum())
        above = np.minimum(wi[..., 2], wo[..., 2]) > 0
        least = min(least, float(forward[above].min()))
    return [
        Figure("reciprocity: pairs that differ", differ, "", 0),
        Figure("smallest f", least, "1/sr", 0, lower=True),
    ]


def albedo_excess(
    sets: Mapping[str, Samples], materials: Mapping[str, list[Material]]
) -> list[Figure]:
    """Largest excess of the directional albedo over the reference's, and its mean error."""
    excess, noise = [], []
    for name, group in materials.items():
        albedo, se = sets[name].albedo, sets[name].albedo_se
        if albedo is not None and se is not None:
            excess.append((_albedo(group[: len(albedo)]) - albedo).ravel())
            noise.append(se.ravel())
    if not excess:
        return []
    above, error = np.concatenate(excess), np.concatenate(noise)
    beyond = float((above - 2 * error).max())
    return [
        Figure("albedo above the reference, beyond its noise (2 se)", 100 * beyond, "%", 0.5),
        Figure("  with its noise", 100 * float(above.max()), "%"),
        Figure("  mean absolute error of the albedo", 100 * float(np.abs(above).mean()), "%"),
    ]


def white_albedo(model: Model) -> Figure:
    """The largest directional albedo of stacks that absorb nothing."""
    largest = 0.0
    for coats in WHITE_COATS:
        for kind, whitest in (("conductor", "r0"), ("diffuse", "reflectance")):
            group = Group(f"white {kind} {coats}", Extended(coats, kind), WHITE_STACKS)
            table = sampling.draw_stacks(group)
            table.albedo[:], table.bottom[whitest][:] = 1, 1
            wi, wo = sampling.draw_pairs(group)
            nothing = np.zeros(wi.shape[:2], np.float32)
            white = Samples(table, wi, wo, nothing, nothing)
            largest = max(
                largest, float(_albedo(predict.materials(model, white, how="table")).max())
            )
    return Figure("largest albedo of stacks that absorb nothing", 100 * largest, "%", 100)


def vanishing_coat(model: Model, sets: Mapping[str, Samples]) -> Figure:
    """Mean E between bare bottoms and these bottoms under the `VANISHING` coat."""
    errors = []
    for samples in sets.values():
        if samples.table.coats:
            continue
        bottoms = predict.material(model, samples, how="table")
        coated = predict.split(layer_material(VANISHING, bottoms))
        f_hat = predict.evaluate(coated, samples.wi, samples.wo)
        errors.append(sampling.stack_errors(f_hat, samples))
    mean = float(np.concatenate(errors).mean()) if errors else 0.0
    return Figure("E of a vanishing coat to its bottom", 100 * mean, "%", 100 * VANISHING_ERROR)


def absorption(model: Model, stacks: int = 16) -> list[Figure]:
    """How often and by how much f rises as absorption grows at a fixed scattering.

    It must never rise: every path through the medium loses energy.
    """
    rises, albedo_rises = [], []
    for kind in ("conductor", "diffuse"):
        group = Group(f"absorbing {kind}", Extended(1, kind), stacks)
        table, (wi, wo) = sampling.draw_stacks(group), sampling.draw_pairs(group)
        nothing = np.zeros(wi.shape[:2], np.float32)
        bare = Samples(sampling.part(table, lowest=0), wi, wo, nothing, nothing)
        bottoms = predict.material(model, bare, how="table")
        coat = {
            name: getattr(table, name)[:, 0].astype(np.float64) for name in CoatParameters._fields
        }
        coat["alpha"] = np.maximum(coat["alpha"], 0.01)
        scattering = coat["albedo"] * coat["sigma_t"]
        values, albedos = [], []
        for sigma_a in ABSORPTION:
            coat["sigma_t"] = scattering + sigma_a
            coat["albedo"] = scattering / np.maximum(coat["sigma_t"], 1e-9)
            materials = predict.split(layer_material(CoatParameters(**coat), bottoms))
            values.append(predict.evaluate(materials, wi, wo).astype(np.float64))
            albedos.append(_albedo(materials))
        f = np.stack(values)
        rises.append((f[1:] - f[:-1]) / (f[:-1] + DARK_OFFSET))
        albedo_rises.append(np.diff(np.stack(albedos), axis=0))
    rise = np.concatenate(rises, axis=1)
    worst_albedo = max(float(r.max()) for r in albedo_rises)
    share = 100 * float((rise > RISE).mean())
    return [
        Figure("f rises with absorption: share of pairs", share, "%", 0.0),
        Figure("  largest relative rise a step", 100 * max(float(rise.max()), 0.0), "%"),
        Figure("  largest rise of the albedo a step", 100 * max(worst_albedo, 0.0), "%"),
    ]


def _albedo(materials: list[Material]) -> np.ndarray:
    """Directional albedo (S, A) of materials of one channel."""
    wi = sampling.albedo_directions().astype(np.float32)
    return np.stack([material.directional_albedo(wi)[:, 0] for material in materials])
