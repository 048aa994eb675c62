"""Laws of physics that materials should keep, each measured by one figure.

The materials are those of constants, which have tables by light transport.
"""

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np
from benchmarks.evaluation import predict
from benchmarks.evaluation import samples as sampling
from benchmarks.evaluation.samples import ALBEDO_COSINES, Group, Samples
from benchmarks.measures import DARK_OFFSET, in_plane

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
    """The worst deviation from one law."""

    name: str  # the law in words
    value: float
    unit: str
    limit: float | None = None  # allowed value; None if the figure is only reported
    lower: bool = False  # whether `limit` is a lower bound

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
    known = {name: group for name, group in materials.items() if sets[name].albedo is not None}
    if not known:
        return []
    excess = [_albedo(g[: len(sets[name].albedo)]) - sets[name].albedo for name, g in known.items()]
    above, error = np.concatenate(excess), np.concatenate([sets[name].albedo_se for name in known])
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
            white = sampling.unsimulated(group)
            white.table.albedo[:], white.table.bottom[whitest][:] = 1, 1
            albedo = _albedo(predict.materials(model, white, how="table"))
            largest = max(largest, float(albedo.max()))
    return Figure("largest albedo of stacks that absorb nothing", 100 * largest, "%", 100)


def vanishing_coat(model: Model, sets: Mapping[str, Samples]) -> Figure:
    """Mean E between bare bottoms and these bottoms under the `VANISHING` coat."""
    errors = [0.0]
    for samples in (samples for samples in sets.values() if not samples.table.coats):
        bottoms = predict.material(model, samples, how="table")
        coated = predict.split(layer_material(VANISHING, bottoms))
        f_hat = predict.evaluate(coated, samples.wi, samples.wo)
        errors.extend(sampling.stack_errors(f_hat, samples))
    mean = float(np.mean(errors[1:] or errors))
    return Figure("E of a vanishing coat to its bottom", 100 * mean, "%", 100 * VANISHING_ERROR)


def absorption(model: Model, stacks: int = 16) -> list[Figure]:
    """How often and by how much f rises as absorption grows at a fixed scattering.

    It must never rise: every path through the medium loses energy.
    """
    rises, albedo_rises = [], []
    for kind in ("conductor", "diffuse"):
        held = sampling.unsimulated(Group(f"absorbing {kind}", Extended(1, kind), stacks))
        bare = replace(held, table=sampling.part(held.table, lowest=0))
        bottoms, coat = predict.material(model, bare, how="table"), predict.coats_at(held.table, 0)
        scattering, values, albedos = coat.albedo * coat.sigma_t, [], []
        for sigma_a in ABSORPTION:
            depth = scattering + sigma_a
            albedo = scattering / np.maximum(depth, 1e-9)
            absorbing = coat._replace(sigma_t=depth, albedo=albedo)
            materials = predict.split(layer_material(absorbing, bottoms))
            values.append(predict.evaluate(materials, held.wi, held.wo).astype(np.float64))
            albedos.append(_albedo(materials))
        rises.append(np.diff(values, axis=0) / (np.array(values[:-1]) + DARK_OFFSET))
        albedo_rises.append(np.diff(albedos, axis=0))
    rise, albedo_rise = (np.concatenate(parts, axis=1) for parts in (rises, albedo_rises))
    largest = [100 * max(float(x.max()), 0.0) for x in (rise, albedo_rise)]
    share = 100 * float((rise > RISE).mean())
    return [
        Figure("f rises with absorption: share of pairs", share, "%", 0.0),
        Figure("  largest relative rise a step", largest[0], "%"),
        Figure("  largest rise of the albedo a step", largest[1], "%"),
    ]


def _albedo(materials: list[Material]) -> np.ndarray:
    """Directional albedo (S, A) of materials of one channel."""
    wi = in_plane(np.arccos(ALBEDO_COSINES))
    return np.stack([material.directional_albedo(wi)[:, 0] for material in materials])
